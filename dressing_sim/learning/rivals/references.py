"""References that learn next to nothing: what a method must beat, and what an oracle reaches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.interpolate import CubicSpline

from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.motion import minimum_jerk
from dressing_sim.learning.policy import Inputs
from dressing_sim.learning.registration import corners
from dressing_sim.learning.rivals.method import Method, Shown, Skill
from dressing_sim.learning.transport import rigid_motion


def apart(frames: Sequence[Frame]) -> float:
    """Mean distance of the frames' origins from the first one's; 1 for a single frame."""
    gaps = [float(np.linalg.norm(frame.b - frames[0].b)) for frame in frames[1:]]
    return float(np.mean(gaps)) if gaps else 1.0


def nearest(shown: Shown, frames: Sequence[Frame]) -> int:
    """Which demonstration's situation is most like another one.

    Situations are alike if a rigid motion takes the `corners` of the one nearly to those of the
    other: the least root of the mean square of what is left.
    """
    reach = float(np.mean([apart(own) for own in shown.situations]))
    wanted, left = corners(frames, reach), []
    for own in shown.situations:
        sources = corners(own, reach)
        turn, shift = rigid_motion(sources, wanted)
        left.append(float(np.mean((sources @ turn.T + shift - wanted) ** 2)))
    return int(np.argmin(left))


def blended(paths: Sequence[FloatArray], squares: FloatArray, scale: float) -> FloatArray:
    """Paths weighed by how near each is, sum_l w_l y_l with w_l ~ 1 / d_l^2 (Shepard 1968).

    Args:
        paths: y_l, each (N, p).
        squares: d_l^2 of each point, (L, N).
        scale: A length beside which a distance is nothing at a millionth.
    """
    weights = 1.0 / np.maximum(squares, 1e-12 * scale**2)
    weights /= weights.sum(axis=0)
    return np.einsum("pn,pni->ni", weights, np.stack(paths))


@dataclass(frozen=True, slots=True)
class Nearest(Method):
    """The demonstration of the most alike situation, moved by its frames.

    Each frame takes the path x along as if it were fixed to it; near a frame that one counts:

        y = sum_p w_p (A_p' A_p^-1 (x - b_p) + b_p'),    w_p ~ 1 / |x - b_p|^2.

    Own construction.
    """

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """Keep the demonstrations."""

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            one = nearest(shown, frames)
            path, own = shown.points[one], shown.situations[one]
            squares = np.stack([np.sum((path - frame.b) ** 2, axis=1) for frame in own])
            moved = [new.to_world(old.to_local(path)) for old, new in zip(own, frames, strict=True)]
            return blended(moved, squares, shown.scale)

        return skill


@dataclass(frozen=True, slots=True)
class Straight(Method):
    """A straight line to where demonstrations end, at minimum jerk (Flash and Hogan 1985)."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The end in the frames, see `dressing_sim.learning.endpoint`."""
        end, phase = shown.place(-1), shown.phase

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            return start + minimum_jerk(phase)[:, None] * (end.predict(frames) - start)

        return skill


@dataclass(frozen=True, slots=True)
class ViaOracle(Method):
    """Via-points relative to joints that it is told, the elbow among them, and a spline.

    A via-point is where demonstrations are at a phase, their mean in the one system of coordinates
    in which they differ the least: any frame's axes at any frame's origin. Own construction; it is
    no rival, as it is told where the elbow is.
    """

    inputs: ClassVar[Inputs] = "elbow"

    via_points: int = 8
    """Besides the start."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """Where the via-points are in their coordinates."""
        rows = np.rint(np.linspace(0, self.samples - 1, self.via_points + 1)[1:]).astype(int)
        mixed = [_mixed(frames) for frames in shown.situations]
        local = Shown(shown.points, tuple(mixed), shown.duration).local[:, :, rows]
        # Of systems that agree equally well, or for one demonstration, the nearest one.
        spread = local.var(axis=0).sum(axis=-1) + 1e-6 * np.mean(local**2, axis=0).sum(axis=-1)
        chosen = np.argmin(spread, axis=0)
        places = local.mean(axis=0)[chosen, np.arange(len(rows))]
        times = shown.phase[np.append(0, rows)]

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            systems = _mixed(frames)
            via = [systems[c].to_world(x) for c, x in zip(chosen, places, strict=True)]
            spline = CubicSpline(times, np.stack([start, *via]))
            return np.asarray(spline(shown.phase))

        return skill


def _mixed(frames: Sequence[Frame]) -> tuple[Frame, ...]:
    """Every frame's axes at every frame's origin."""
    return tuple(Frame(axes.A, origin.b) for axes in frames for origin in frames)
