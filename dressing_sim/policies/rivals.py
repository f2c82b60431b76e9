"""The rivals as policies: methods of `dressing_sim.learning.rivals` that generate paths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import real_array, real_number, real_vector, whole_number
from dressing_sim.config import from_plain, to_plain
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import DemonstrationLike, Frame
from dressing_sim.learning.frame import FloatArray, situation
from dressing_sim.learning.policy import Inputs
from dressing_sim.learning.rivals import METHODS, Equivariance, Method, Shown, Skill
from dressing_sim.learning.rivals.method import begun_at, library
from dressing_sim.policies.warped import KinematicWarping


class RivalPolicy:
    """A method as a policy.

    Args:
        method: Its hyper-parameters.
        seed: Of the randomness of learning.

    Attributes:
        inputs: Its class of inputs.
        equivariance: What moves its answer along when the whole scene is moved.
        dt: Time between two points of its path [s], once fitted.
    """

    def __init__(self, method: Method, seed: int = 0) -> None:
        self.method = method
        self.seed = seed
        self.inputs: Inputs = method.inputs
        self.equivariance: Equivariance = method.equivariance
        self.dt: float | None = None
        self._shown: Shown | None = None
        self._skill: Skill | None = None

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Learn from one demonstration or more.

        Raises:
            InvalidInputError: Demonstrations that cannot be learned from.
        """
        return self._learn(Shown.of(demonstrations, self.method.samples))

    def _learn(self, shown: Shown) -> Self:
        self._skill = self.method.learn(shown, np.random.default_rng(self.seed))
        self.dt = shown.duration / (self.method.samples - 1)
        self._shown = shown
        return self

    def __getstate__(self) -> dict[str, Any]:
        """What goes to another process, which learns again: a skill is a function made here."""
        return {**self.__dict__, "_skill": None}

    def generate(self, frames: Sequence[Frame], start: ArrayLike) -> FloatArray:
        """A path (N, p) for a situation, which begins at the start (p,), in world coordinates.

        Raises:
            InvalidInputError: Not fitted, or another number or dimension of frames.
        """
        shown = self._known()
        asked, own = situation(frames), shown.situations[0]
        if [one.dimension for one in asked] != [one.dimension for one in own]:
            raise InvalidInputError(
                f"the situation has {len(asked)} frames of dimension "
                f"{[one.dimension for one in asked]}, valid is as learned from: {len(own)} of "
                f"dimension {own[0].dimension}"
            )
        begin = real_vector(start, own[0].dimension, "start has", "m")
        if self._skill is None:
            self._skill = _learned(_Lesson.of(self.method, self.seed, shown))
        return begun_at(begin, self._skill(asked, begin), shown.phase)

    def state(self) -> tuple[dict[str, Any], dict[str, FloatArray]]:
        """Settings and arrays, see `dressing_sim.learning.storage`: the demonstrations in phase.

        A file says what was learned from, and whoever reads it learns it again.
        """
        shown = self._known()
        settings = {
            "method": type(self.method).__name__,
            "config": to_plain(self.method),
            "seed": self.seed,
            "duration": shown.duration,
        }
        arrays = {
            "points": shown.points,
            "bases": np.array([[one.A for one in frames] for frames in shown.situations]),
            "origins": np.array([[one.b for one in frames] for frames in shown.situations]),
        }
        return settings, arrays

    @classmethod
    def from_state(cls, settings: dict[str, Any], arrays: Mapping[str, FloatArray]) -> Self:
        """The policy that `state` came from."""
        kinds = {type(one.method).__name__: type(one.method) for one in POLICIES.values()}
        if settings["method"] not in kinds:
            raise InvalidInputError(f"an unknown method, valid is one of {', '.join(kinds)}")
        method = from_plain(kinds[settings["method"]], settings["config"])
        policy = cls(method, whole_number(settings["seed"], "seed"))
        points = real_array(arrays["points"], ("M", method.samples, "p"), "points have", fewest=1)
        m, _, p = points.shape
        origins = real_array(arrays["origins"], (m, "P", p), "origins of frames have")
        bases = real_array(arrays["bases"], (*origins.shape, p), "bases of frames have")
        pairs = [zip(*both, strict=True) for both in zip(bases, origins, strict=True)]
        frames = tuple(tuple(Frame(basis, origin) for basis, origin in pair) for pair in pairs)
        duration = real_number(settings["duration"], "duration", 0.0, above=True)
        return policy._learn(Shown(points, frames, duration))

    def _known(self) -> Shown:
        if self._shown is None:
            raise InvalidInputError("the policy has not learned yet; valid is fit() first")
        return self._shown


@dataclass(frozen=True)
class _Lesson:
    """What a skill depends on; equal if its numbers are."""

    method: Method
    seed: int
    content: bytes
    shown: Shown = field(compare=False)

    @classmethod
    def of(cls, method: Method, seed: int, shown: Shown) -> Self:
        """With the demonstrations' numbers."""
        frames = [array for one in shown.situations for f in one for array in (f.A, f.b)]
        duration = np.float64(shown.duration)
        content = b"".join(np.asarray(a).tobytes() for a in (shown.points, *frames, duration))
        return cls(method, seed, content, shown)


@lru_cache(maxsize=32)
def _learned(lesson: _Lesson) -> Skill:
    """The skill again; kept, as a worker is sent the same policy for each of its episodes."""
    return lesson.method.learn(lesson.shown, np.random.default_rng(lesson.seed))


@dataclass(frozen=True, slots=True)
class RivalConfig:
    """A method with its hyper-parameters."""

    method: Method

    def make(self, seed: int = 0) -> RivalPolicy:
        """A new policy, not yet fitted.

        Raises:
            InvalidInputError: A package of the extra ``rivals`` that it needs is not installed.
        """
        if self.method.package is not None:
            library(self.method.package)
        return RivalPolicy(self.method, seed)


#: The library's methods, and the one that knows an arm.
POLICIES: Mapping[str, RivalConfig] = {
    **{name: RivalConfig(one) for name, one in METHODS.items()},
    "warp": RivalConfig(KinematicWarping()),
}
