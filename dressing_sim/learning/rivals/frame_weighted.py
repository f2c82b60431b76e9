"""Frame-weighted motion generation: one demonstration is bent from its first frame to its second.

Seen from the frame where the motion begins, each point of a reference demonstration follows the
other frame by a weight w(s) between 0 and 1:

    y = x + w (b' - b),   y <- R(w v) (y - b') + b',   v the rotation vector of A' A^-1,

with (A, b), (A', b') the other frame of the reference and of the new situation, and
w(s) = sum_j w_j phi_j(s) over the share s of the path's length. The w_j are those with which
demonstrations generate each other best, by the distance of dynamic time warping.

Source: Sun, Kober, Gienger and Zhu (2023), "Learning from few demonstrations with frame-weighted
motion generation", ISER, arXiv:2303.14188.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Literal

import numpy as np
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.dtw import dtw_distance
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.rivals.method import Method, Shown, Skill
from dressing_sim.learning.rivals.references import nearest


@dataclass(frozen=True, slots=True)
class FrameWeighted(Method):
    """Frame-weighted motion generation, see the module. For two frames in space."""

    basis: int = 10
    """Basis functions of the weight."""
    reference: Literal["first", "nearest"] = "first"
    """Which demonstration is bent."""
    iterations: int = 30
    """Most steps of the search for weights."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The weights w_j.

        Raises:
            InvalidInputError: Other than two frames in space.
        """
        if shown.points.shape[2] != 3 or len(shown.situations[0]) != 2:
            raise InvalidInputError("frame-weighted motion generation needs two frames in space")
        begin = _begin(shown)
        bases = [_basis(_share(path), self.basis) for path in shown.points]
        pairs = list(permutations(range(len(shown.points)), 2))

        def bent(one: int, frames: Sequence[Frame], weights: FloatArray) -> FloatArray:
            own = shown.situations[one]
            return bend(shown.points[one], own, frames, bases[one] @ weights, begin)

        def cost(weights: FloatArray) -> float:
            made = [(bent(i, shown.situations[j], weights), shown.points[j]) for i, j in pairs]
            return sum(dtw_distance(path, truth) for path, truth in made) / shown.scale

        weights = np.full(self.basis, 0.5)
        if pairs:
            limits = {"maxiter": self.iterations}
            found = minimize(
                cost, weights, bounds=[(0.0, 1.0)] * self.basis, method="L-BFGS-B", options=limits
            )
            weights = found.x

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            one = 0 if self.reference == "first" else nearest(shown, frames)
            return bent(one, frames, weights)

        return skill


def bend(
    path: FloatArray,
    own: Sequence[Frame],
    frames: Sequence[Frame],
    weight: FloatArray,
    begin: int,
) -> FloatArray:
    """The path (N, 3) of a situation of two frames in another one, with weights (N,)."""
    first, new = own[begin], frames[begin]
    other, target = (_seen(f[1 - begin], f[begin]) for f in (own, frames))
    local = first.to_local(path) + weight[:, None] * (target.b - other.b)
    turn = Rotation.from_matrix(target.A @ np.linalg.inv(other.A)).as_rotvec()
    turned = Rotation.from_rotvec(weight[:, None] * turn).apply(local - target.b)
    return new.to_world(turned + target.b)


def _seen(frame: Frame, first: Frame) -> Frame:
    return Frame(first.displacements_to_local(frame.A.T).T, first.to_local(frame.b))


def _begin(shown: Shown) -> int:
    """The frame in which demonstrations' starts agree best; of one, the frame nearest to it."""
    starts = shown.local[:, :, 0]
    spread = starts.var(axis=0) + 1e-9 * starts**2
    return int(np.argmin(spread.sum(axis=-1).sum(axis=0)))


def _share(path: FloatArray) -> FloatArray:
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1)))
    return length / length[-1]


def _basis(share: FloatArray, count: int) -> FloatArray:
    """Gaussian functions, (N, count), which sum to one."""
    centres = np.linspace(0.0, 1.0, count)
    width = 1.0 / max(count - 1, 1)
    values = np.exp(-0.5 * ((share[:, None] - centres) / width) ** 2)
    return values / values.sum(axis=1, keepdims=True)
