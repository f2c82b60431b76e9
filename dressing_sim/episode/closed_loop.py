"""Dressing in closed loop: somebody who looks decides in every control step where to go."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.checks import real_vector
from dressing_sim.control import JointTrajectory
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.meter import Row
from dressing_sim.episode.observation import Force, Observation
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rollout import Observer, begin, keep, recorded
from dressing_sim.episode.rules import UNREACHABLE
from dressing_sim.inputs import asked_with, inputs_of
from dressing_sim.path import policy_at_fault, policy_name, policy_seed, reset_policy


class ClosedLoop:
    """One episode that somebody leads target by target, until it has finished.

    It has finished once nothing was wanted for ``config.hold`` seconds in one go; the robot holds
    meanwhile. A path whose targets are given one by one is the same episode, to the bit, as the
    path that is followed.

    Args:
        dressing: It begins anew.
        observer: Called after every control step.

    Attributes:
        dressing: As given.
        row: What was measured last.
        held: For how many steps the robot has been holding.
    """

    def __init__(self, dressing: Dressing, observer: Observer | None = None) -> None:
        self.dressing, self.row, self.held = dressing, begin(dressing), 0
        self._observer = observer
        self._n_hold = round(dressing.config.hold / dressing.config.tracking.dt)
        self._commands, self._targets, self._errors = [dressing.command], [dressing.target], [0.0]
        self._positions = [self.row.tcp]

    @property
    def finished(self) -> bool:
        """Whether it held for as long as it must."""
        return self.held >= self._n_hold

    @property
    def out_of_reach(self) -> bool:
        """Whether the robot cannot get near enough to its target; the episode then ends."""
        return self._errors[-1] > self.dressing.config.tracking.max_error

    @property
    def over(self) -> bool:
        """Whether there is nothing more to step."""
        return self.finished or self.out_of_reach or self.dressing.done

    def step(
        self,
        wanted: NDArray[np.float64] | None,
        rotation: NDArray[np.float64] | None = None,
    ) -> Row:
        """Lead the gripper for one control step.

        Args:
            wanted: Target (3,), in the robot's base frame [m]; None to stop and hold.
            rotation: Orientation of the hand, see `Dressing.step`.

        Raises:
            InvalidInputError: The target is not finite, or the dressing is over.
        """
        dressing = self.dressing
        if wanted is not None:
            self.row, self.held = dressing.step(wanted, rotation), 0
        else:
            self.row, self.held = dressing.hold(), self.held + 1
        if keep(dressing, self.row, self._positions, self._observer):
            self._commands.append(dressing.command)
            self._targets.append(dressing.target)
            self._errors.append(dressing.target_error)
        return self.row

    def recording(self) -> Recording:
        """The episode so far, judged."""
        config, errors = self.dressing.config, self._errors
        dt = config.tracking.dt
        trajectory = JointTrajectory(
            np.array(self._commands), dt, np.array(self._targets), np.array(errors)
        )
        n_left = round(config.time_limit / dt) + 1 - len(self._positions) if self.finished else -1
        recording = recorded(self.dressing, trajectory, self._positions, n_left * dt)
        if recording.reach_left >= 0.0 or recording.broke is not None:
            return recording
        told = f"the robot stays {errors[-1]:.3g} m from the target"
        failure = Failure(UNREACHABLE.name, told, self.row.time, self.row.armscye_s)
        outcome = Outcome(False, (failure,), recording.outcome.metrics)
        return replace(recording, outcome=outcome)


def close_the_loop(
    dressing: Dressing, policy: Any, seed: int, observer: Observer | None = None
) -> Recording:
    """Ask a policy for a target in every step until it returns None, then stop and hold.

    Args:
        dressing: It begins anew.
        policy: It has ``act``, and may have ``reset``.
        seed: Of the policy's own randomness.
        observer: Called after every control step.
    """
    name = policy_name(policy)
    forces = inputs_of(policy) == "frames+force"
    reset_policy(policy, policy_seed(policy, seed))
    loop, dt = ClosedLoop(dressing, observer), dressing.config.tracking.dt
    seen = dressing.seen
    frames = asked_with(policy, seen)
    target: NDArray[np.float64] = dressing.target
    while not loop.over:
        wanted = None
        if loop.held == 0:
            row = loop.row
            force = Force(row.grip_force, row.link_force) if forces else None
            if dressing.seen is not seen:
                seen = dressing.seen
                frames = asked_with(policy, seen)
            wanted = policy.act(Observation(row.time, dt, row.tcp, target, frames, force))
        if wanted is not None:
            with policy_at_fault():
                target = wanted = real_vector(wanted, 3, f"{name}: act returned a target of", "m")
        loop.step(wanted)
    return loop.recording()
