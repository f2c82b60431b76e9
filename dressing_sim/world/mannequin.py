"""The mannequin: torso, head and one arm of capsules, static during an episode.

Extra spheres close the joints: without them cloth slips into the gap that two capsules leave
when the elbow bends.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import mujoco
import numpy as np

from dressing_sim.arm import FORWARD, LEFT, UP, Posture

SKIN = (0.93, 0.76, 0.65, 1.0)
SHIRT = (0.62, 0.68, 0.74, 1.0)

#: The links whose contact forces are reported, from the hand to the head.
ARM_LINKS = ("hand", "forearm", "upper_arm")
LINKS = (*ARM_LINKS, "torso", "head")

#: Size of the trunk relative to the shoulder joint [m], our own choice after the 50th-percentile
#: male's biacromial breadth of 0.40 m and sitting acromion-to-vertex height of 0.30 m.
SHOULDER_TO_MIDLINE = 0.185
TORSO_RADIUS = 0.105
TORSO_LENGTH = 0.42
HEAD_RADIUS = 0.095
HEAD_HEIGHT = 0.24
HAND_LENGTH = 0.09


#: Start, end and radius of a capsule; without an end, of a sphere.
_Part = tuple[np.ndarray, np.ndarray | None, float]


def _add_link(
    spec: mujoco.MjSpec,
    shared: Mapping[str, Any],
    name: str,
    rgba: tuple[float, ...],
    *parts: _Part,
) -> None:
    body = spec.worldbody.add_body(name=name)
    for number, (start, end, radius) in enumerate(parts):
        kind, place = (
            (mujoco.mjtGeom.mjGEOM_SPHERE, {"pos": start})
            if end is None
            else (mujoco.mjtGeom.mjGEOM_CAPSULE, {"fromto": [*start, *end]})
        )
        body.add_geom(
            name=f"{name}{number}", type=kind, size=[radius, 0, 0], rgba=rgba, **place, **shared
        )


def add_mannequin(
    spec: mujoco.MjSpec,
    posture: Posture,
    friction: float,
    contype: int,
    conaffinity: int,
) -> None:
    """Add the mannequin to the world, one body a link of `LINKS`, its arm in the given posture.

    Args:
        spec: Model to edit; its world frame is the robot's base frame.
        posture: Posture, size and place of the arm.
        friction: Sliding friction coefficient of skin and cloth.
        contype: Contact type bits of every geom.
        conaffinity: Contact affinity bits of every geom.
    """
    size = posture.arm_size
    shoulder, elbow, wrist = posture.shoulder, posture.elbow, posture.wrist
    fingers = wrist + HAND_LENGTH * (wrist - elbow) / size.forearm_length
    middle = shoulder - SHOULDER_TO_MIDLINE * LEFT
    chest = middle - 0.05 * UP

    shared = {
        "friction": [friction, 0.005, 0.0001],
        "contype": contype,
        "conaffinity": conaffinity,
        "condim": 3,
    }
    link = partial(_add_link, spec, shared)
    # Spheres at shoulder, elbow and wrist are a little larger than the capsules they join.
    link(
        "hand",
        SKIN,
        (wrist, fingers, 0.62 * size.hand_radius),
        (fingers, None, 0.72 * size.hand_radius),
    )
    link(
        "forearm",
        SKIN,
        (wrist, elbow, size.forearm_radius),
        (wrist, None, 1.02 * size.forearm_radius),
    )
    link(
        "upper_arm",
        SKIN,
        (elbow, shoulder, size.upper_arm_radius),
        (elbow, None, 1.02 * size.upper_arm_radius),
        (shoulder, None, 1.15 * size.upper_arm_radius),
    )
    right_shoulder = middle - SHOULDER_TO_MIDLINE * LEFT
    hip = chest - TORSO_LENGTH * UP
    link(
        "torso",
        SHIRT,
        (shoulder + 0.055 * -LEFT, right_shoulder + 0.055 * LEFT, 0.05),
        (chest - 0.045 * LEFT, hip - 0.045 * LEFT, TORSO_RADIUS),
        (chest + 0.045 * LEFT, hip + 0.045 * LEFT, TORSO_RADIUS),
    )
    head = middle + HEAD_HEIGHT * UP + 0.02 * FORWARD
    link("head", SKIN, (middle, head, 0.045), (head, None, HEAD_RADIUS))
