"""A servo of a joint: a spring and a damper towards where it is asked to be."""

from __future__ import annotations

import mujoco
import numpy as np


def add_servo(
    spec: mujoco.MjSpec, joint: str, stiffness: float, damping: float, effort: float | None = None
) -> None:
    """Add an actuator, named as its joint: ``stiffness (asked - position) - damping speed``.

    Args:
        spec: The world that has the joint.
        joint: Name of the joint.
        stiffness: In [N m/rad] or, of a slide, [N/m].
        damping: In [N m s/rad] or [N s/m].
        effort: Largest torque [N m] or force [N]; no limit if not given.
    """
    gain, bias = np.zeros(10), np.zeros(10)
    gain[0], bias[1], bias[2] = stiffness, -stiffness, -damping
    servo = spec.add_actuator(
        name=joint,
        target=joint,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        gainprm=gain,
        biasprm=bias,
    )
    if effort is not None:
        servo.forcelimited = True
        servo.forcerange = [-effort, effort]
