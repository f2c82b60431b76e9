"""What can be drawn besides what is there: frames, paths, forces."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.pictures.story import Moment, Story
from dressing_sim.world.mannequin import LINKS

_AXES = ((0.85, 0.20, 0.18), (0.20, 0.62, 0.25), (0.18, 0.36, 0.82))
_PATH, _DEMONSTRATION, _FORCE = (0.93, 0.45, 0.10), (0.45, 0.45, 0.50), (0.80, 0.10, 0.35)

#: Length of an arrow for each newton [m].
_METRES_A_NEWTON = 0.03

#: Forces below are not drawn [N].
_LEAST = 0.15

#: Segments of a path.
_SEGMENTS = 48


@dataclass(frozen=True, slots=True, eq=False)
class Mark:
    """A line, or an arrow, from one point to another.

    Attributes:
        start: Shape (3,) [m].
        end: Shape (3,) [m].
        radius: Of the line [m].
        rgb: Its colour, 0 to 1.
        arrow: Whether it has a head.
        label: Written at its end.
    """

    start: NDArray[np.float64]
    end: NDArray[np.float64]
    radius: float
    rgb: tuple[float, float, float]
    arrow: bool = False
    label: str = ""

    def add(self, scene: mujoco.MjvScene) -> None:
        """Add it to what is drawn, if there is room."""
        if scene.ngeom >= scene.maxgeom:
            return
        geom = scene.geoms[scene.ngeom]
        kind = mujoco.mjtGeom.mjGEOM_ARROW if self.arrow else mujoco.mjtGeom.mjGEOM_CAPSULE
        mujoco.mjv_initGeom(
            geom, kind, np.zeros(3), np.zeros(3), np.eye(3).ravel(), np.array([*self.rgb, 1.0])
        )
        mujoco.mjv_connector(geom, kind, self.radius, self.start, self.end)
        geom.emission, geom.specular = 0.35, 0.0
        geom.label = self.label
        scene.ngeom += 1


def lasting(story: Story, overlays: tuple[str, ...]) -> list[Mark]:
    """Marks that are the same in all pictures of an episode."""
    marks = []
    if "demonstrations" in overlays:
        for path in story.demonstrations:
            marks += _line(path, 0.002, _DEMONSTRATION)
    if "path" in overlays and story.path is not None:
        marks += _line(story.path, 0.0035, _PATH)
    return marks


def momentary(posture: Posture, moment: Moment, overlays: tuple[str, ...]) -> list[Mark]:
    """Marks of one picture: the arm's frames, and how the cloth presses on each link [N]."""
    arm, marks = moment.arm(posture), []
    if "frames" in overlays:
        for frame in arm.frames():
            marks += [
                Mark(frame.b, frame.b + 0.13 * frame.A[:, axis], 0.004, rgb, arrow=True)
                for axis, rgb in enumerate(_AXES)
            ]
    if "forces" not in overlays:
        return marks
    wrist, elbow, shoulder = arm.wrist, arm.elbow, arm.shoulder
    places = {
        "hand": wrist,
        "forearm": 0.5 * (wrist + elbow),
        "upper_arm": 0.5 * (elbow + shoulder),
    }
    for link, force in zip(LINKS, moment.link_force, strict=True):
        newtons = float(np.linalg.norm(force))
        if newtons < _LEAST or link not in places:
            continue
        start = places[link] - 0.06 * force / newtons
        end = start - _METRES_A_NEWTON * force
        # The arrow's head is where the force acts.
        marks.append(Mark(end, start, 0.006, _FORCE, arrow=True, label=f"{newtons:.1f} N"))
    return marks


def _line(path: NDArray[np.float64], radius: float, rgb: tuple[float, float, float]) -> list[Mark]:
    rows = np.unique(np.linspace(0, len(path) - 1, _SEGMENTS + 1).round().astype(int))
    points = path[rows]
    return [Mark(a, b, radius, rgb) for a, b in pairwise(points)]
