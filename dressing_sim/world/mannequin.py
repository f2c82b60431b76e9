"""The mannequin: torso, head and one arm of capsules, static during an episode unless it moves.

Extra spheres close the joints: without them cloth slips into the gap that two capsules leave
when the elbow bends.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from dressing_sim.arm import FORWARD, LEFT, UP, Posture
from dressing_sim.world.person import DENSITY, add_chain

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


def _add_geoms(
    body: mujoco.MjsBody,
    name: str,
    rgba: tuple[float, ...],
    parts: tuple[_Part, ...],
    shared: Mapping[str, Any],
    origin: np.ndarray,
    density: float | None,
) -> None:
    """Add a link's geoms to its body, weightless if they close a joint, unless it has no density.

    A body that cannot move needs none.
    """
    for number, (start, end, radius) in enumerate(parts):
        kind, place = (
            (mujoco.mjtGeom.mjGEOM_SPHERE, {"pos": start - origin})
            if end is None
            else (mujoco.mjtGeom.mjGEOM_CAPSULE, {"fromto": [*(start - origin), *(end - origin)]})
        )
        geom = body.add_geom(
            name=f"{name}{number}", type=kind, size=[radius, 0, 0], rgba=rgba, **place, **shared
        )
        if density is not None:
            geom.density = 0.0 if end is None and name != "hand" else density


def add_mannequin(
    spec: mujoco.MjSpec,
    posture: Posture,
    friction: float,
    contype: int,
    conaffinity: int,
) -> None:
    """Add the mannequin to the world, one body a link of `LINKS`, its arm in the given posture.

    The bodies of a person who moves are a chain of joints, see `dressing_sim.world.person`.

    Args:
        spec: Model to edit; its world frame is the robot's base frame.
        posture: Posture, size, place and motion of the arm.
        friction: Sliding friction coefficient of skin and cloth.
        contype: Contact type bits of every geom.
        conaffinity: Contact affinity bits of every geom.
    """
    shared = {
        "friction": [friction, 0.005, 0.0001],
        "contype": contype,
        "conaffinity": conaffinity,
        "condim": 3,
    }
    chain = {} if posture.motion is None else add_chain(spec, posture)
    for name, parts in _parts(posture).items():
        rgba = SKIN if name in (*ARM_LINKS, "head") else SHIRT
        if name in chain:
            (body, origin), density = chain[name], DENSITY.get(name)
        else:
            body, origin, density = spec.worldbody.add_body(name=name), np.zeros(3), None
        _add_geoms(body, name, rgba, parts, shared, origin, density)


def _parts(posture: Posture) -> dict[str, tuple[_Part, ...]]:
    """What each link is made of, in the robot's base frame."""
    size = posture.arm_size
    shoulder, elbow, wrist = posture.shoulder, posture.elbow, posture.wrist
    fingers = wrist + HAND_LENGTH * (wrist - elbow) / size.forearm_length
    middle = shoulder - SHOULDER_TO_MIDLINE * LEFT
    chest = middle - 0.05 * UP
    right_shoulder = middle - SHOULDER_TO_MIDLINE * LEFT
    hip = chest - TORSO_LENGTH * UP
    head = middle + HEAD_HEIGHT * UP + 0.02 * FORWARD
    # Spheres at shoulder, elbow and wrist are a little larger than the capsules they join.
    return {
        "hand": (
            (wrist, fingers, 0.62 * size.hand_radius),
            (fingers, None, 0.72 * size.hand_radius),
        ),
        "forearm": (
            (wrist, elbow, size.forearm_radius),
            (wrist, None, 1.02 * size.forearm_radius),
        ),
        "upper_arm": (
            (elbow, shoulder, size.upper_arm_radius),
            (elbow, None, 1.02 * size.upper_arm_radius),
            (shoulder, None, 1.15 * size.upper_arm_radius),
        ),
        "torso": (
            (shoulder + 0.055 * -LEFT, right_shoulder + 0.055 * LEFT, 0.05),
            (chest - 0.045 * LEFT, hip - 0.045 * LEFT, TORSO_RADIUS),
            (chest + 0.045 * LEFT, hip + 0.045 * LEFT, TORSO_RADIUS),
        ),
        "head": ((middle, head, 0.045), (head, None, HEAD_RADIUS)),
    }
