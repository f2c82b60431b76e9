"""A policy in closed loop: it asks another one again whenever the arm is seen elsewhere.

The other policy knows whole paths, from the wrist to the shoulder, and no way to go on from the
middle of one. So it is asked for the whole path to the arm as it is now, and of that the rest is
followed, from the same share of its time on. Where the gripper is not on the new path, because the
arm has moved since the last one, the distance dies away like a critically damped spring,

    target(t) = path(t) + (c + (v + w c) (t - t0)) exp(-w (t - t0)),

with c and v such that neither place nor speed of the target jumps at t0. Noise of what is seen is
smoothed by the same spring.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

from dressing_sim.arm import Posture, Vector
from dressing_sim.config import check_numbers
from dressing_sim.control import TrackingConfig
from dressing_sim.control.retiming import times_of
from dressing_sim.episode.observation import Observation
from dressing_sim.episode.operator import Operator, OperatorConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.inputs import inputs_of
from dressing_sim.learning import DemonstrationLike, Policy, Situation
from dressing_sim.learning.policy import Inputs
from dressing_sim.path import checked_path, seed_argument
from dressing_sim.policies.expert import EXPERT_REPLAN
from dressing_sim.policies.transported import TransportConfig

#: The path is over, and the gripper on it, once it is this near its end [m].
_ARRIVED = 0.005


@dataclass(frozen=True, slots=True)
class Replanning:
    """How often a path is asked for, and how soon it is joined. Own choice.

    Raises:
        InvalidInputError: A value that no policy can have.
    """

    period: float = 0.2
    """At least so long between two paths [s]."""
    rate: float = 3.0
    """How quickly the distance from a new path dies away, w [1/s]."""
    patience: float = 2.0
    """Longest wait at the end of the path for the gripper to be there [s]."""

    def __post_init__(self) -> None:
        check_numbers(self, "replanning", ("rate",), ("period", "patience"))


@dataclass(frozen=True, eq=False)
class _Plan:
    """A path and how it is joined.

    Attributes:
        path: Target (3,) [m] over time [s].
        duration: Of the path [s].
        since: When it was joined, on its own clock [s].
        away: How far from it the target was then, (3,) [m].
        going: How fast that changed, (3,) [m/s].
    """

    path: PchipInterpolator
    duration: float
    since: float = 0.0
    away: Vector = field(default_factory=lambda: np.zeros(3))
    going: Vector = field(default_factory=lambda: np.zeros(3))

    def at(self, clock: float, rate: float) -> tuple[Vector, Vector]:
        """Target (3,) [m] at a time of the path's own clock [s], and its speed (3,) [m/s]."""
        inside = min(clock, self.duration)
        on_path = np.asarray(self.path(inside))
        along = np.asarray(self.path(inside, 1)) if clock < self.duration else np.zeros(3)
        elapsed, spring = clock - self.since, self.going + rate * self.away
        fading = np.exp(-rate * elapsed)
        left = (self.away + spring * elapsed) * fading
        return on_path + left, along + spring * fading - rate * left


class ReplannedPolicy:
    """Follows the paths of another policy, and asks it again as the arm moves.

    An arm that stays where it was is asked about once: the path is then the other policy's.

    Args:
        policy: It is asked, see the module.
        config: How often, and how soon a new path is joined.
    """

    def __init__(self, policy: Policy, config: Replanning | None = None) -> None:
        self.config = config or Replanning()
        self.inputs: Inputs = inputs_of(policy)
        self.stream: str = getattr(policy, "stream", type(policy).__qualname__)
        self._policy: Any = policy
        self.reset()

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Let the other policy learn."""
        self._policy = self._policy.fit(demonstrations)
        return self

    def generate(self, frames: Situation | Posture, start: ArrayLike, seed: int = 0) -> Any:
        """The other policy's path."""
        return self._policy.generate(frames, start, **seed_argument(self._policy.generate, seed))

    def reset(self, seed: int = 0) -> None:
        """Begin an episode."""
        self._seed = seed
        self._start: Vector = np.zeros(3)
        self._plan: _Plan | None = None
        self._frames: Situation | Posture | None = None
        self._clock = self._asked = 0.0

    def act(self, observation: Observation) -> NDArray[np.float64] | None:
        """The next target (3,) [m]; None once the gripper is at the path's end."""
        if self._plan is None:
            self._start = observation.tcp
            self._plan = self._planned(observation)
            self._asked = observation.time
        elif self._due(observation):
            self._plan = self._joined(self._plan, self._planned(observation))
            self._asked = observation.time
        self._clock += observation.dt
        plan, rate = self._plan, self.config.rate
        target, _ = plan.at(self._clock, rate)
        over = self._clock - plan.duration
        near = float(np.linalg.norm(target - plan.path(plan.duration))) < _ARRIVED
        return None if over > 0.0 and (near or over > self.config.patience) else target

    def _due(self, observation: Observation) -> bool:
        late = observation.time - self._asked >= self.config.period - 1e-9
        return (
            late and observation.frames is not self._frames and (observation.frames != self._frames)
        )

    def _planned(self, observation: Observation) -> _Plan:
        """The whole path to the arm as it is seen now."""
        self._frames = observation.frames
        asked = observation.frames, self._start, self._seed
        made = checked_path(self.generate(*asked), "the policy")
        dt = made.dt if made.dt is not None else getattr(self._policy, "dt", None)
        if dt is None:
            raise InvalidInputError("its path has no dt; valid is a path that says how fast it is")
        places = np.vstack([self._start, made.positions])
        times = times_of(places, dt, TrackingConfig().max_speed)
        return _Plan(PchipInterpolator(times, places), float(times[-1]))

    def _joined(self, before: _Plan, after: _Plan) -> _Plan:
        """The new plan from the share of its time that the old one was at; sets the clock."""
        place, speed = before.at(self._clock, self.config.rate)
        over = max(self._clock - before.duration, 0.0)
        share = min(self._clock / before.duration, 1.0)
        self._clock = share * after.duration + over
        there, along = after.at(self._clock, self.config.rate)
        return _Plan(after.path, after.duration, self._clock, place - there, speed - along)


@dataclass(frozen=True, slots=True)
class ReplannedConfig:
    """Hyper-parameters of our default in closed loop."""

    transport: TransportConfig = field(default_factory=TransportConfig)
    replanning: Replanning = field(default_factory=Replanning)

    def make(self, seed: int = 0) -> ReplannedPolicy:
        """A new policy, not yet fitted."""
        return ReplannedPolicy(self.transport.make(seed), self.replanning)


@dataclass(frozen=True, slots=True)
class ReplannedExpertConfig:
    """Hyper-parameters of the operator who looks again."""

    operator: OperatorConfig = field(default_factory=OperatorConfig)
    replanning: Replanning = field(default_factory=Replanning)

    def make(self, seed: int = 0) -> ReplannedPolicy:
        """A new operator."""
        return ReplannedPolicy(Operator(self.operator), self.replanning)


POLICIES: Mapping[str, ReplannedConfig | ReplannedExpertConfig] = {
    "transport-replan": ReplannedConfig(),
    EXPERT_REPLAN: ReplannedExpertConfig(),
}
