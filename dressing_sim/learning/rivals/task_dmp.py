"""Dynamic movement primitives whose forcing term depends on the situation: mixtures of mixtures.

Each demonstration's forcing term is a Gaussian mixture over phase and force; the mixtures are
components of one over the task parameters q as well, and the force is its regression,

    f(s, q) = sum_m h_m(q) E_m[f | s],   h_m(q) ~ N(q | q_m, l^2 I),

in a dynamic movement primitive from the start to the goal that the frames say.

Source: Pervez and Lee (2018), "Learning task-parameterized dynamic movement primitives using
mixture of GMMs", Intelligent Service Robotics 11, doi:10.1007/s11370-017-0235-8.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.registration import corners
from dressing_sim.learning.rivals.fusion import over_time, time_mixture
from dressing_sim.learning.rivals.method import Method, Shown, Skill
from dressing_sim.learning.rivals.references import apart
from dressing_sim.learning.rivals.springs import forces, rollout


@dataclass(frozen=True, slots=True)
class TaskDMP(Method):
    """TP-DMP, see the module; forces are counted along the axes of the last frame, the wrist's."""

    components: int = 8
    """Of each demonstration's mixture."""
    floor: float = 1e-4
    """Added to variances, as a fraction of the data's."""
    width: float = 0.5
    """l, over the mean distance of a demonstration's task parameters from the nearest other's."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The forcing term of each demonstration."""
        axes = [frames[-1] for frames in shown.situations]
        still = tuple((Frame(frame.A, np.zeros(frame.dimension)),) for frame in axes)
        pushed = np.stack([forces(path, path[-1]) for path in shown.points])
        told = Shown(pushed[:, :-1], still, shown.duration)
        phase = shown.phase
        terms = np.stack(
            [
                over_time(time_mixture(told.only([m]), self.components, self.floor), phase).means[0]
                for m in range(len(axes))
            ]
        )
        end = shown.place(-1)
        reach = float(np.mean([apart(frames) for frames in shown.situations]))
        known = np.stack([task_parameters(frames, reach) for frames in shown.situations])
        width = self.width * _spacing(known)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            gaps = np.sum((known - task_parameters(frames, reach)) ** 2, axis=1) / width**2
            share = np.exp(-0.5 * (gaps - gaps.min()))
            force = np.einsum("m,mni->ni", share / share.sum(), terms)
            turned = frames[-1].displacements_to_world(force)
            return rollout(turned, start, end.predict(frames))

        return skill


def task_parameters(frames: Sequence[Frame], reach: float) -> FloatArray:
    """What does not change when a situation is moved: the other frames' corners in the last one."""
    return frames[-1].to_local(corners(frames[:-1], reach)).ravel() / reach


def _spacing(known: FloatArray) -> float:
    """Mean distance of a row (M, d) from the nearest other; 1 for a single row."""
    if len(known) == 1:
        return 1.0
    gaps = np.linalg.norm(known[:, None] - known, axis=2)
    return max(float((gaps + np.diag(np.full(len(gaps), np.inf))).min(axis=1).mean()), 1e-9)
