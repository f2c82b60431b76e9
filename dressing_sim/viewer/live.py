"""One dressing as the page shows it: stepped, kept moment by moment, and gone on with from any.

All that moves is a `Dressing`. A `Live` keeps what it read in each step, and a snapshot now and
then, so that any moment can be looked at again at once and gone on from with the same bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.control.retiming import retime, smooth
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.meter import Row
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.record import DEFAULT_PATH_DT
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rollout import begin, plan
from dressing_sim.learning import Policy
from dressing_sim.path import Path, policy_path
from dressing_sim.viewer.leaders import AlongTargets, AlongTrajectory, ByHand, Leader, Order

#: Control steps between two snapshots.
_BETWEEN = 25


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """What is drawn of one control step.

    Attributes:
        row: What was measured.
        cloth: Vertices of the sleeve, (n_vertices, 3) [m].
        arm: Where the arm is.
    """

    row: Row
    cloth: NDArray[np.float32]
    arm: Posture


class Live:
    """One dressing in progress.

    Args:
        dressing: It begins anew.
        leader: Who leads the gripper; None for a dressing that is over before it begins.
        path: What is followed, to be drawn; None without.
        outcome: The verdict if it is known without moving.

    Attributes:
        dressing: As given.
        leader: As given, until another takes over.
        path: As given.
        moments: One a step, and one before the first.
        orders: What the robot was told, one a step.
        outcome: The verdict, once it is over.
    """

    def __init__(
        self,
        dressing: Dressing,
        leader: Leader | None,
        path: Path | None = None,
        outcome: Outcome | None = None,
    ) -> None:
        self.dressing, self.leader, self.path, self.outcome = dressing, leader, path, outcome
        if isinstance(leader, AlongTrajectory):
            row = dressing.reset(leader.commands[0], leader.targets[0])
        else:
            row = begin(dressing)
        self.commands = [dressing.command]
        self.moments = [self._moment(row)]
        self.orders: list[Order] = []
        self._snapshots = {0: dressing.snapshot()}

    @classmethod
    def of_policy(
        cls, source: Policy | Path, posture: Posture, seed: int, config: EpisodeConfig
    ) -> Live:
        """A dressing as `dressing_sim.episode.record.record` carries it out.

        Raises:
            PolicyError: The policy gives no answer.
        """
        dressing = Dressing(posture, config)
        if dressing.invalid is not None:
            return cls(dressing, None, None, Outcome(False, invalid=dressing.invalid))
        limit = config.time_limit
        path = policy_path(source, posture, dressing.start, seed, DEFAULT_PATH_DT, limit)
        planned = plan(dressing, path.positions, path.dt or DEFAULT_PATH_DT)
        if isinstance(planned, Recording):
            return cls(dressing, None, path, planned.outcome)
        return cls(dressing, AlongTrajectory(dressing, planned), path)

    @classmethod
    def by_hand(cls, posture: Posture, config: EpisodeConfig) -> Live:
        """A dressing that somebody leads."""
        dressing = Dressing(posture, config)
        return cls(dressing, ByHand(dressing.start))

    @property
    def n_hold(self) -> int:
        """For how many steps the robot holds in the end."""
        config = self.dressing.config
        return round(config.hold / config.tracking.dt)

    @property
    def n_steps(self) -> int:
        """Steps so far."""
        return len(self.orders)

    @property
    def time(self) -> float:
        """Since the robot began to move [s]."""
        return self.n_steps * self.dressing.config.tracking.dt

    @property
    def finished(self) -> bool:
        """Whether the leader had time for all that it wanted to do."""
        return not self.dressing.done and self.leader is not None

    @property
    def over(self) -> bool:
        """Whether there is a verdict."""
        return self.outcome is not None

    @property
    def waits(self) -> bool:
        """Whether time stands still until whoever leads moves on."""
        return isinstance(self.leader, ByHand) and self.leader.waits(self.dressing)

    def step(self) -> bool:
        """Go on by one control step; False once it is over."""
        if self.over or self.leader is None:
            return False
        order = None if self.dressing.done else self.leader.order(self.n_steps)
        if order is None:
            self.outcome = self.leader.outcome(self)
            return False
        row = order.carry_out(self.dressing)
        if self.dressing.invalid is None:
            self.orders.append(order)
            self.commands.append(self.dressing.command)
            self.moments.append(self._moment(row))
            if self.n_steps % _BETWEEN == 0:
                self._snapshots[self.n_steps] = self.dressing.snapshot()
        return True

    def _moment(self, row: Row) -> Moment:
        world, arm = self.dressing.world, self.dressing.posture
        return Moment(row, world.cloth.astype(np.float32), arm.moved(world.person))

    def steps(self) -> Iterator[Moment]:
        """Go on to the end, moment by moment."""
        while self.step():
            yield self.moments[-1]

    def back_to(self, step: int) -> None:
        """Go back to after a step: what came later is forgotten, and there is no verdict.

        The nearest snapshot before it is restored, and the orders since then are carried out again.
        """
        at = min(max(step, 0), self.n_steps)
        near = max(one for one in self._snapshots if one <= at)
        self.dressing.restore(self._snapshots[near])
        for order in self.orders[near:at]:
            order.carry_out(self.dressing)
        self._snapshots = {k: s for k, s in self._snapshots.items() if k <= at}
        del self.orders[at:], self.moments[at + 1 :], self.commands[at + 1 :]
        if isinstance(self.leader, ByHand):
            self.leader = ByHand(self.dressing.target)
        if self.leader is not None:
            self.outcome = None

    def take_over(self) -> None:
        """Somebody leads by hand from here on."""
        self.leader, self.path, self.outcome = ByHand(self.dressing.target), None, None

    def hand_over(self, path: Path) -> None:
        """Follow a path from the place on it that is nearest to the gripper."""
        config, here = self.dressing.config, self.dressing.target
        nearest = int(np.linalg.norm(path.positions - here, axis=1).argmin())
        rest = np.vstack([here, path.positions[nearest:]])
        tracking = config.tracking
        timed = retime(rest, path.dt or DEFAULT_PATH_DT, tracking.dt, tracking.max_speed)
        targets = smooth(timed, tracking.dt, tracking.smoothing)
        self.leader = AlongTargets(targets, self.n_steps, self.n_hold)
        self.path, self.outcome = path, None

    def let_go(self) -> None:
        """Whoever leads by hand is done: the robot holds, and then there is a verdict."""
        if isinstance(self.leader, ByHand):
            self.leader.let_go(self.n_steps, self.n_hold)
