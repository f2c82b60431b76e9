"""Random new situations for Algorithm 1: bounds of orientation and translation, and samplers.

Orientations are bounded in Euler angles and translations by coordinate (paper, equations 11, 12).
In three dimensions R = Rz(gamma) Ry(beta) Rx(alpha), the angles (alpha, beta, gamma) about the
fixed x, y and z axes; in two there is one angle.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import listed, of_kind, real_array, real_number, shown
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.demonstrations import DemonstrationLike, check_demonstrations
from dressing_sim.learning.frame import FloatArray, Frame, Situation


@runtime_checkable
class SituationSampler(Protocol):
    """Draws situations. A task that knows its kinematics (an arm's joints, say) brings its own."""

    def sample(self, rng: np.random.Generator) -> Sequence[Frame]:
        """A random situation; the same generator state gives the same one."""


def rotation(angles: ArrayLike) -> FloatArray:
    """Rotation matrix of one angle (2 x 2) or of three Euler angles (3 x 3), in [rad]."""
    values = np.atleast_1d(real_array(angles, None, "angles have", "rad"))
    cosines, sines = np.cos(values), np.sin(values)
    if values.shape == (1,):
        return np.array([[cosines[0], -sines[0]], [sines[0], cosines[0]]])
    if values.shape != (3,):
        raise InvalidInputError(f"a rotation has 1 or 3 angles, not {values.shape}")
    (ca, cb, cg), (sa, sb, sg) = cosines, sines
    return np.array(
        [
            [cg * cb, cg * sb * sa - sg * ca, cg * sb * ca + sg * sa],
            [sg * cb, sg * sb * sa + cg * ca, sg * sb * ca - cg * sa],
            [-sb, cb * sa, cb * ca],
        ]
    )


def euler_angles(matrix: ArrayLike) -> FloatArray:
    """Angles of a rotation matrix, the inverse of ``rotation``: (1,) or (3,), in [rad]."""
    r = real_array(matrix, None, "a rotation has")
    if r.shape == (2, 2):
        return np.array([np.arctan2(r[1, 0], r[0, 0])])
    if r.shape != (3, 3):
        raise InvalidInputError(f"a rotation is 2 x 2 or 3 x 3, not {r.shape}")
    across = np.hypot(r[0, 0], r[1, 0])
    beta = np.arctan2(-r[2, 0], across)
    if across < 1e-9:  # x points up or down: only alpha -+ gamma counts, so gamma may be zero
        return np.array([np.arctan2(-r[1, 2], r[1, 1]), beta, 0.0])
    return np.array([np.arctan2(r[2, 1], r[2, 2]), beta, np.arctan2(r[1, 0], r[0, 0])])


def _bounds(low: ArrayLike, high: ArrayLike, name: str) -> tuple[FloatArray, FloatArray]:
    a = np.atleast_1d(real_array(low, None, f"the bounds of the {name} have"))
    b = np.atleast_1d(real_array(high, None, f"the bounds of the {name} have"))
    if a.shape != b.shape or not (a <= b).all():
        raise InvalidInputError(
            f"the bounds of the {name} must be finite and low <= high, not {shown(low)} to "
            f"{shown(high)}"
        )
    return a, b


@dataclass(frozen=True, eq=False)
class FrameBounds:
    """Where one frame may be: A = R(angles) base, b in a box; all uniform and independent.

    Attributes:
        base: (p, p) basis at zero angles; it carries a scale or a reflection, if any.
        angles: lowest and highest angles in [rad], each (1,) for p = 2 or (3,) for p = 3.
        translation: lowest and highest b, each (p,).
    """

    base: FloatArray
    angles: tuple[FloatArray, FloatArray]
    translation: tuple[FloatArray, FloatArray]

    def __post_init__(self) -> None:
        for name in ("angles", "translation"):
            pair = listed(getattr(self, name), f"the bounds of the {name}", "lowest and highest")
            if len(pair) != 2:
                raise InvalidInputError(
                    f"the bounds of the {name} are {len(pair)}, valid is lowest and highest"
                )
        angles = _bounds(*self.angles, "angles")
        translation = _bounds(*self.translation, "translation")
        frame = Frame(self.base, translation[0])
        if angles[0].size != {2: 1, 3: 3}.get(frame.dimension):
            raise InvalidInputError("a frame has one angle in two dimensions, three in three")
        object.__setattr__(self, "base", frame.A)
        object.__setattr__(self, "angles", angles)
        object.__setattr__(self, "translation", translation)

    @classmethod
    def fixed(cls, frame: Frame) -> Self:
        """Bounds that hold one frame only."""
        of_kind(frame, Frame, "frame", "a Frame")
        zero = np.zeros({2: 1, 3: 3}.get(frame.dimension, 0))
        return cls(frame.A, (zero, zero), (frame.b, frame.b))

    def sample(self, rng: np.random.Generator) -> Frame:
        """A frame, uniform within the bounds."""
        of_kind(rng, np.random.Generator, "rng", "a random generator of numpy's")
        translation = rng.uniform(*self.translation)
        return Frame(rotation(rng.uniform(*self.angles)) @ self.base, translation)


@dataclass(frozen=True)
class BoundsSampler:
    """Every frame drawn from its own bounds, independently of the others.

    Attributes:
        bounds: one for each frame of the situation.
        names: of the frames, if they have any.
    """

    bounds: tuple[FrameBounds, ...]
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for one in listed(self.bounds, "bounds", "a sequence of FrameBounds"):
            of_kind(one, FrameBounds, "bounds of a frame", "FrameBounds")
        for name in listed(self.names, "names", "a sequence of texts"):
            of_kind(name, str, "the name of a frame", "a text")

    def sample(self, rng: np.random.Generator) -> Situation:
        """A situation, each frame uniform within its bounds."""
        return Situation.of([bounds.sample(rng) for bounds in self.bounds], self.names)

    @classmethod
    def around(
        cls,
        demonstrations: Sequence[DemonstrationLike],
        angle_margin: float = np.deg2rad(10.0),
        translation_margin: float = 0.25,
    ) -> Self:
        """Bounds that just hold the demonstrated frames, and a margin.

        The angles are those of the rotation from the first demonstration's frame. They are taken
        on the shortest arcs that hold them, see ``arcs``, so bounds may go beyond 180 degrees
        where demonstrations lie on both sides of them. The margins are choices of this library.

        Args:
            demonstrations: at least one.
            angle_margin: added on both sides of each angle that varies, in [rad]; less where the
                arc would go round further than once.
            translation_margin: added on both sides, as a fraction of each coordinate's range.
        """
        real_number(angle_margin, "angle_margin", 0.0)
        real_number(translation_margin, "translation_margin", 0.0)
        situations = [Situation.of(d.frames) for d in check_demonstrations(demonstrations)]
        bounds = []
        for views in zip(*situations, strict=True):
            base = views[0].A
            turns = np.array([euler_angles(_nearest_rotation(base, view.A)) for view in views])
            angles = arcs(turns)
            width = np.ptp(angles, axis=0)
            margin = np.where(width > 1e-9, angle_margin, 0.0)
            margin = np.minimum(margin, np.maximum(np.pi - 0.5 * width, 0.0))
            origins = np.array([view.b for view in views])
            slack = translation_margin * np.ptp(origins, axis=0)
            bounds.append(
                FrameBounds(
                    base,
                    (angles.min(axis=0) - margin, angles.max(axis=0) + margin),
                    (origins.min(axis=0) - slack, origins.max(axis=0) + slack),
                )
            )
        return cls(tuple(bounds), situations[0].names)


def arcs(angles: FloatArray) -> FloatArray:
    """The same rotations by angles that lie close together.

    An angle counts modulo a full turn, and (alpha, beta, gamma) is the same rotation as
    (alpha + pi, pi - beta, gamma + pi): where a rotation goes past the vertical, its Euler angles
    leap by half a turn. Of the two forms of each rotation that is taken which widens the arcs
    least, beginning with the smallest rotations, if all arcs together become shorter by it.

    Args:
        angles: (n, 1) or (n, 3), as of ``euler_angles``, in [rad].

    Returns:
        Angles of the same shape; the range of each column is the shortest arc that holds it.
    """
    plain = _on_shortest_arcs(angles)
    if angles.shape[1] == 1:
        return plain
    chosen = angles.copy()
    done: list[int] = []
    for index in np.argsort(np.abs(angles).sum(axis=1), kind="stable"):
        alpha, beta, gamma = angles[index]
        forms = np.array(
            [angles[index], [_wrapped(alpha + np.pi), np.pi - beta, _wrapped(gamma + np.pi)]]
        )
        widths = []
        for form in forms:
            held = np.vstack([chosen[done], form])
            widths.append(np.ptp(_on_shortest_arcs(held), axis=0).sum())
        chosen[index] = forms[int(widths[1] < widths[0] - 1e-9)]
        done.append(int(index))
    other = _on_shortest_arcs(chosen)
    shorter = np.ptp(other, axis=0).sum() < np.ptp(plain, axis=0).sum() - 1e-9
    return other if shorter else plain


def _wrapped(angle: float) -> float:
    """The angle between -pi and pi."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


def _on_shortest_arcs(angles: FloatArray) -> FloatArray:
    """Angles (n, m), those beyond the widest gap of their column turned once; never the first."""
    result = angles.copy()
    for column in result.T:
        rising = np.sort(column)
        gaps = np.diff(rising, append=rising[0] + 2.0 * np.pi)
        widest = int(np.argmax(gaps))
        if gaps[widest] > gaps[-1] + 1e-9:  # else they are on the shortest arc already
            turns = (column <= rising[widest]).astype(np.float64)
            column += 2.0 * np.pi * (turns - turns[0])
    return result


def _nearest_rotation(base: FloatArray, other: FloatArray) -> FloatArray:
    """The rotation R for which R base is nearest to ``other`` (orthogonal Procrustes)."""
    u, _, vt = np.linalg.svd(other @ base.T)
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return u @ vt
