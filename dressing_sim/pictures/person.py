"""The person as drawn: seated, with a head, a body, and an arm that lies inside the simulated one.

Drawn only. Cloth and robot touch the capsules of `dressing_sim.world.mannequin`; of the body drawn
here, they cannot touch legs, face and fingers. All proportions are our own, after those capsules
and a median sitting adult's.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import FORWARD, LEFT, UP, Posture
from dressing_sim.pictures.implicit import Cone, Field, Solid, shade, surface
from dressing_sim.world.mannequin import SHOULDER_TO_MIDLINE

#: How far inside the surface that contacts see the arm's skin is drawn [m]: own choice, what cloth
#: sinks in under a usual load. Real skin would give way; ours, drawn in full, would poke through.
SKIN_INSET = 0.006

#: Height of the floor below the shoulder [m], a sitting adult's.
FLOOR = 1.0

#: How far the middle of what the person sits on is below the shoulder [m].
SEAT = 0.61

#: How round the edges of clothes are [m].
_HEM = 0.010

_COLOURS = {
    "skin": (0.87, 0.66, 0.54),
    "skin_hand": (0.87, 0.66, 0.54),
    "shirt": (0.88, 0.89, 0.90),
    "trousers": (0.24, 0.28, 0.36),
    "shoes": (0.16, 0.16, 0.17),
}


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A part of the person, to be drawn.

    Attributes:
        name: What it is.
        vertices: Shape (n, 3), in the robot's base frame [m].
        faces: Triangles (m, 3).
        normals: Shape (n, 3).
        light: How open each vertex is to the light, from 0 to 1, shape (n,).
        colour: Red, green and blue, 0 to 1.
    """

    name: str
    vertices: NDArray[np.float64]
    faces: NDArray[np.signedinteger]
    normals: NDArray[np.float64]
    light: NDArray[np.float64]
    colour: tuple[float, float, float]


class _Body:
    """Places of the trunk: left, forward and up of the midline at the shoulders' height."""

    def __init__(self, shoulder: NDArray[np.float64]) -> None:
        self._middle = shoulder - SHOULDER_TO_MIDLINE * LEFT

    def at(self, left: float, forward: float, up: float) -> NDArray[np.float64]:
        """A point (3,) [m]."""
        return self._middle + left * LEFT + forward * FORWARD + up * UP

    def cone(
        self,
        start: tuple[float, float, float],
        end: tuple[float, float, float],
        radii: tuple[float, float],
        squash: float = 1.0,
        flat: NDArray[np.float64] | None = FORWARD,
    ) -> Cone:
        """A part between two such points; `squash` says how deep it is, relative to its width."""
        return Cone(self.at(*start), self.at(*end), radii, None if squash == 1.0 else flat, squash)

    def both(
        self,
        start: tuple[float, float, float],
        end: tuple[float, float, float],
        radii: tuple[float, float],
        squash: float = 1.0,
    ) -> list[Cone]:
        """The same on the left and on the right."""
        mirrored = [(-p[0], *p[1:]) for p in (start, end)]
        return [
            self.cone(start, end, radii, squash),
            self.cone(mirrored[0], mirrored[1], radii, squash),
        ]


def _trunk(body: _Body) -> list[Cone]:
    """Chest, belly, the slope of the shoulders."""
    return [
        body.cone((0.0, 0.0, -0.13), (0.0, 0.012, -0.30), (0.150, 0.138), 0.70),
        body.cone((0.0, 0.005, -0.30), (0.0, 0.0, -0.50), (0.135, 0.150), 0.76),
        *body.both((0.06, 0.035, -0.14), (0.08, 0.03, -0.17), (0.065, 0.06)),
        *body.both((0.0, -0.02, 0.015), (0.145, -0.012, -0.035), (0.055, 0.052)),
        *body.both((0.10, -0.035, -0.09), (0.11, -0.02, -0.22), (0.07, 0.05)),
    ]


def _head(body: _Body) -> list[Cone]:
    return [
        body.cone((0.0, -0.020, 0.0), (0.0, -0.005, 0.16), (0.058, 0.052)),
        body.cone((0.0, -0.018, 0.252), (0.0, 0.022, 0.256), (0.083, 0.078)),
        body.cone((0.0, 0.028, 0.235), (0.0, 0.050, 0.180), (0.066, 0.046)),
        *body.both((0.036, 0.018, 0.195), (0.012, 0.066, 0.160), (0.032, 0.024)),
    ]


def _face(body: _Body) -> list[Cone]:
    """What is too small to flow together as widely as the rest."""
    return [
        body.cone((0.0, 0.092, 0.240), (0.0, 0.108, 0.206), (0.009, 0.012)),
        *body.both((0.010, 0.098, 0.203), (0.012, 0.094, 0.203), (0.008, 0.007)),
        *body.both((0.014, 0.086, 0.250), (0.044, 0.072, 0.252), (0.010, 0.007)),
        *body.both((0.0, 0.089, 0.178), (0.018, 0.083, 0.178), (0.008, 0.005)),
        *body.both((0.080, -0.012, 0.250), (0.077, -0.004, 0.216), (0.014, 0.010), 0.8),
        *body.both((0.087, -0.020, 0.256), (0.088, -0.016, 0.236), (0.009, 0.009)),
    ]


def _hand(
    wrist: NDArray[np.float64],
    along: NDArray[np.float64],
    thumb: NDArray[np.float64],
    scale: float,
    curl: float,
) -> list[Cone]:
    """A hand, from its wrist along the forearm; its fingers bend by `curl` [rad] at each joint."""
    palm = np.cross(along, thumb)

    def point(a: float, t: float, n: float) -> NDArray[np.float64]:
        return wrist + scale * (a * along + t * thumb + n * palm)

    parts = []
    for number, (side, length) in enumerate(
        ((0.026, 0.034), (0.009, 0.037), (-0.009, 0.034), (-0.024, 0.027))
    ):
        knuckle = 0.080 - 0.004 * abs(number - 1)
        root, end = point(0.012, 0.5 * side, 0.0), point(knuckle, side, 0.0)
        parts.append(Cone(root, end, (0.0145 * scale, 0.0115 * scale)))
        angle, radius = 0.0, 0.0105 * scale
        for share in (1.0, 0.66, 0.5):
            angle += curl
            step = scale * length * share * (np.cos(angle) * along + np.sin(angle) * palm)
            parts.append(Cone(end, end + step, (radius, 0.9 * radius)))
            end, radius = end + step, 0.9 * radius
    bends = [point(0.018, 0.016, 0.004), point(0.048, 0.036, 0.014)]
    bends += [point(0.076, 0.036, 0.026), point(0.096, 0.024, 0.032)]
    radii = scale * np.array([0.015, 0.0125, 0.0105, 0.009])
    parts += [
        Cone(a, b, (float(r), float(s)))
        for a, b, r, s in zip(bends[:-1], bends[1:], radii[:-1], radii[1:], strict=True)
    ]
    return parts


def left_arm(posture: Posture) -> Solid:
    """The arm that is dressed, within the simulated one by `SKIN_INSET` or more."""
    size = posture.arm_size
    shoulder, elbow, wrist = posture.shoulder, posture.elbow, posture.wrist
    upper, fore = size.upper_arm_radius - SKIN_INSET, size.forearm_radius - SKIN_INSET
    forward, left, up = posture.upper_arm_rotation.T
    down, along = -up, (wrist - elbow) / size.forearm_length
    thumb = np.cross(left, along)
    thumb *= np.sign(thumb @ forward + thumb @ up) or 1.0

    def joint(
        start: NDArray[np.float64], axis: NDArray[np.float64], at: float, off: float = 0.0
    ) -> NDArray[np.float64]:
        return start + at * axis + off * forward

    long, short = size.upper_arm_length, size.forearm_length
    parts = [
        Cone(shoulder, joint(shoulder, down, 0.35 * long), (1.06 * upper, 0.97 * upper)),
        Cone(joint(shoulder, down, 0.35 * long), elbow, (0.97 * upper, 0.80 * upper)),
        Cone(
            joint(shoulder, down, 0.38 * long, 0.10 * upper),
            joint(shoulder, down, 0.70 * long, 0.10 * upper),
            (0.88 * upper, 0.82 * upper),
        ),
        Cone(elbow, elbow + 0.30 * short * along, (0.98 * fore, 1.0 * fore)),
        Cone(elbow + 0.30 * short * along, wrist, (1.0 * fore, 0.78 * fore), left, 0.9),
    ]
    scale = min(1.0, size.hand_radius / 0.043)
    return Solid((*parts, *_hand(wrist, along, thumb, scale, 0.75)), 0.007)


def _right_arm(body: _Body) -> list[Cone]:
    """At rest, its hand on the thigh."""
    shoulder, elbow, wrist = (-0.185, 0.0, -0.005), (-0.245, -0.02, -0.275), (-0.145, 0.185, -0.385)
    start, end = body.at(*elbow), body.at(*wrist)
    along = (end - start) / np.linalg.norm(end - start)
    thumb = np.cross(UP, along)
    thumb = -thumb / np.linalg.norm(thumb)
    flat = along * 0.96 - 0.0 * UP
    return [
        body.cone(shoulder, elbow, (0.046, 0.034)),
        body.cone(elbow, wrist, (0.035, 0.024)),
        *_hand(end, flat, thumb if np.cross(flat, thumb) @ UP < 0.0 else -thumb, 1.0, 0.28),
    ]


def _legs(body: _Body, wider: float) -> list[Cone]:
    return [
        body.cone((0.0, 0.0, -0.47), (0.0, 0.02, -0.49), (0.155, 0.150), 0.8),
        *body.both((0.085, 0.02, -0.495), (0.12, 0.43, -0.50), (0.080 + wider, 0.058 + wider)),
        *body.both((0.12, 0.43, -0.50), (0.12, 0.40, -0.92), (0.057 + wider, 0.044 + wider)),
    ]


def _clipped(field: Field, *cuts: Field) -> Field:
    """Only what is inside all cuts, too; with rounded edges."""

    def clipped(points: NDArray[np.float64]) -> NDArray[np.float64]:
        left = -field(points)
        for cut in cuts:
            left = _blended(left, -cut(points), _HEM)
        return -left

    return clipped


def _outside(*parts: Cone) -> Field:
    """Beyond all these parts."""
    solid = Solid(parts, 1e-6)
    return lambda points: -solid(points)


def trunk(posture: Posture) -> Solid:
    """What cloth at the shoulder lies on, besides the arm; in the shirt."""
    return Solid(tuple(_trunk(_Body(posture.shoulder))), 0.05)


def beside_arm(posture: Posture) -> Solid:
    """What goes with the shoulder and not with the arm: trunk, head and the other arm."""
    body = _Body(posture.shoulder)
    return Solid((*_trunk(body), *_head(body), *_right_arm(body)), 0.05)


@lru_cache(maxsize=4)
def person(posture: Posture) -> tuple[Surface, ...]:
    """All of the person that is drawn."""
    body = _Body(posture.shoulder)
    arm, chest = left_arm(posture), Solid(tuple(_trunk(body)), 0.05)
    head, face = Solid(tuple(_head(body)), 0.03), Solid(tuple(_face(body)), 0.008)
    right = Solid(tuple(_right_arm(body)), 0.014)

    def skin(points: NDArray[np.float64]) -> NDArray[np.float64]:
        joined = _blended(_blended(head(points), face(points), 0.012), chest(points), 0.035)
        return _blended(_blended(joined, arm(points), 0.03), right(points), 0.03)

    def loose(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return chest(points) - 0.007

    holes = [body.cone((0.0, 0.015, 0.03), (0.0, 0.06, 0.06), (0.098, 0.098))]
    holes += body.both((0.19, 0.0, 0.03), (0.205, 0.005, -0.075), (0.068, 0.064))
    shirt = _clipped(loose, _outside(*holes), _above(body.at(0.0, 0.0, -0.53)))
    legs = Solid(tuple(_legs(body, 0.004)), 0.05)
    trousers = _clipped(legs, _below(body.at(0.0, 0.0, -0.44)))
    shoes = Solid(
        tuple(
            body.both((0.12, 0.375, -0.955), (0.125, 0.53, -0.97), (0.045, 0.034))
            + body.both((0.12, 0.395, -0.90), (0.12, 0.39, -0.95), (0.040, 0.044))
        ),
        0.03,
    )

    def everything(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.minimum(np.minimum(skin(points), loose(points)), legs(points))

    def part(name: str, field: Field, box: NDArray[np.float64], cell: float) -> Surface:
        vertices, faces, normals = surface(field, box, cell)
        if name.startswith("skin"):
            hidden = (shirt(vertices) < -0.004) | (trousers(vertices) < -0.004)
            away = np.linalg.norm(vertices - palm, axis=1)
            hidden |= away < reach if name == "skin" else away > reach + 0.01
            faces = faces[~hidden[faces].all(axis=1)]
        used, kept = np.unique(faces, return_inverse=True)
        vertices, normals = vertices[used], normals[used]
        light, kept = shade(everything, vertices, normals), kept.reshape(-1, 3)
        return Surface(name, vertices, kept, normals, light, _COLOURS[name])

    # Fingers are finer than the rest; both meshes are of one surface, so that no seam shows.
    wrist, reach = posture.wrist, 1.75 * posture.arm_size.hand_radius
    palm = wrist + 0.95 * reach * (wrist - posture.elbow) / posture.arm_size.forearm_length
    at_palm = np.array([palm - reach - 0.02, palm + reach + 0.02])
    upper = np.array([body.at(-0.33, -0.2, -0.5), body.at(0.16, 0.35, 0.4)])
    return (
        part("skin", skin, _sorted(upper, arm.box()), 0.012),
        part("skin_hand", skin, at_palm, 0.0055),
        part("shirt", shirt, chest.box(), 0.015),
        part("trousers", trousers, legs.box(), 0.020),
        part("shoes", shoes, shoes.box(), 0.014),
    )


def _sorted(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """A box around two, given by two corners each."""
    corners = np.concatenate([first, second])
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def _blended(a: NDArray[np.float64], b: NDArray[np.float64], blend: float) -> NDArray[np.float64]:
    return np.minimum(a, b) - np.maximum(blend - np.abs(a - b), 0.0) ** 2 / (4.0 * blend)


def _above(point: NDArray[np.float64]) -> Field:
    return lambda points: point[2] - points[:, 2]


def _below(point: NDArray[np.float64]) -> Field:
    return lambda points: points[:, 2] - point[2]
