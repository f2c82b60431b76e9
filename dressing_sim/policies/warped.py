"""Teach once: a demonstration warped from one arm to another, bone by bone.

Each point of the demonstration follows both bones, the nearer one more, as skin follows a skeleton:

    y = sum_l w_l T_l(x),   w_l ~ 1 / d_l(x)^2,

with d_l the distance from bone l, and T_l what takes bone l of the demonstrated arm to that of the
new one: the axes of its frame, stretched along it by the ratio of the lengths. The weights are
those of Shepard's interpolation (1968, doi:10.1145/800186.810616); the rest is an own construction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dressing_sim.learning import Frame
from dressing_sim.learning.frame import FloatArray
from dressing_sim.learning.rivals.method import Method, Shown, Skill
from dressing_sim.learning.rivals.references import blended, nearest
from dressing_sim.policies.skeleton import Skeleton


@dataclass(frozen=True, slots=True)
class KinematicWarping(Method):
    """Warping bone by bone, see the module; of the demonstration of the nearest situation."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """Keep the demonstrations, and the bones' lengths."""
        bones = np.mean([Skeleton.of(frames).bones for frames in shown.situations], axis=0)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            one = nearest(shown, frames)
            path, own = shown.points[one], shown.situations[one]
            here, there = Skeleton.of(own, bones), Skeleton.of(frames, bones)
            gaps = np.stack([_distance(path, frame.b, here.elbow) for frame in own])
            ratios = there.bones / here.bones  # upper arm and forearm, as the frames are
            moved = []
            for old, new, ratio in zip(own, frames, ratios, strict=True):
                local = old.to_local(path)
                local[:, 0] *= ratio
                moved.append(new.to_world(local))
            return blended(moved, gaps**2, shown.scale)

        return skill


def _distance(points: FloatArray, begin: FloatArray, end: FloatArray) -> FloatArray:
    """Of points (N, 3) from a bone, (N,)."""
    bone = end - begin
    share = np.clip((points - begin) @ bone / (bone @ bone), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - begin - share[:, None] * bone, axis=1))
