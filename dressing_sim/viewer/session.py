"""What one page holds and does, without a browser: choices, a preview, and a dressing in progress.

All tabs of a page show the same session. Three threads share the work: one follows the choices at
once, one demonstrates and learns, one simulates; a new order to the last replaces the one before.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dressing_sim.checks import real_number, real_vector, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.path import Path
from dressing_sim.viewer.choices import TAKES, Choices
from dressing_sim.viewer.choosing import Choosing
from dressing_sim.viewer.lessons import Lessons, demonstration_of
from dressing_sim.viewer.live import ByHand, Live, Moment
from dressing_sim.viewer.past import Past
from dressing_sim.viewer.preview import guide, preview

#: Looks for a new target so often while time stands still [s].
_PATIENCE = 0.005


class Session(Choosing):
    """One page's state.

    Args:
        lessons: What can be learned from.
        choices: What is chosen at first.
        past: A run to look at, or None.

    Attributes:
        past: As given.
        guide: A path to teach along, while somebody teaches.
        live: The dressing that was begun last, or None.
        beside: Another one that it is compared with, or None.
        replayed: Index of the run's episode that `live` is, or None.
        running: Whether time goes on.
        at: The step that is looked at; None for the newest.
        speed: Simulated seconds a second, at most; 0 for as many as there can be.
    """

    def __init__(
        self, lessons: Lessons, choices: Choices | None = None, past: Past | None = None
    ) -> None:
        super().__init__(lessons, choices)
        self.past = past
        self.guide: Path | None = None
        self.live: Live | None = None
        self.beside: Live | None = None
        self.replayed: int | None = None
        self.running = False
        self.at: int | None = None
        self.speed = 1.0
        self._order = 0
        self._made_with = ""
        self._simulating = ThreadPoolExecutor(1, "simulate")

    def close(self) -> None:
        """End what is being done; the session is of no use afterwards."""
        self._order += 1
        self._simulating.shutdown(wait=False, cancel_futures=True)
        super().close()

    def moment(self) -> Moment | None:
        """The moment that is looked at, if there is a dressing."""
        with self._lock:
            if self.live is None:
                return None
            at = self.live.n_steps if self.at is None else min(self.at, self.live.n_steps)
            return self.live.moments[at]

    def moments(self) -> list[Moment]:
        """All moments of the dressing so far."""
        with self._lock:
            return [] if self.live is None else [*self.live.moments]

    def _do(self, job: Callable[[int], None]) -> None:
        """Let the simulating thread do something instead of what it does."""
        self._order += 1
        order = self._order

        def guarded() -> None:
            if order == self._order:
                with self.telling(busy=True):
                    job(order)

        self._simulating.submit(guarded)

    def _begin(self, live: Live, beside: Live | None = None, replayed: int | None = None) -> None:
        with self._lock:
            self.tell(live=live, beside=beside, replayed=replayed, at=None, status="", showing=True)

    def _run(self, order: int) -> None:
        """Let time go on until it is over, or somebody wants something else."""
        live = self._branch()
        self.tell(running=True)
        try:
            due, waited = time.perf_counter(), False
            while order == self._order:
                if live.waits:
                    if not waited:
                        self.tell()
                    waited = True
                    time.sleep(_PATIENCE)
                    due = time.perf_counter()
                    continue
                waited = False
                if not live.step():
                    break
                self.tell()
                if self.speed > 0.0:
                    due += live.dressing.config.tracking.dt / self.speed
                    early = due - time.perf_counter()
                    time.sleep(max(early, 0.0))
                    due -= min(early, 0.0)  # what was lost is not caught up with
        finally:
            self.tell(running=False)

    def dress(self) -> None:
        """Begin a dressing of what is chosen."""
        choices = self.choices

        def job(order: int) -> None:
            policy = self.learned(choices).result()
            if order != self._order:
                return
            self._told("the cloth settles")
            live = Live.of_policy(policy, choices.posture, choices.seed, choices.config())
            self._made_with = choices.policy_name
            self.guide = None
            self._begin(live)
            self._run(order)

        self._do(job)

    def pause(self) -> None:
        """Let time stand still."""
        self._order += 1
        self.tell()

    def go_on(self) -> None:
        """Let time go on from the moment that is looked at: what came later is forgotten.

        If another policy is chosen by now, it goes on with the rest of the path that it would take.
        """
        choices = self.choices

        def job(order: int) -> None:
            live = self._branch()
            by_policy = live.leader is not None and not isinstance(live.leader, ByHand)
            if by_policy and choices.policy_name != self._made_with:
                policy = self.learned(choices).result()
                asked = replace(choices, posture=live.dressing.posture)
                path = preview(asked, policy).path
                if path is None:
                    raise InvalidInputError(f"{choices.policy_name} gives no path here")
                live.hand_over(path)
                self._made_with = choices.policy_name
            self._run(order)

        self._do(job)

    def _branch(self) -> Live:
        live = self.live
        if live is None:
            raise InvalidInputError("there is no dressing to go on with; valid is to dress first")
        with self._lock:
            if self.at is not None and self.at < live.n_steps:
                live.back_to(self.at)
            self.tell(at=None, status="", showing=True)
        return live

    def step_once(self) -> None:
        """Go on by one control step, or look at the moment after the one that is looked at."""
        live, at = self.live, self.at
        if live is not None and at is not None and at < live.n_steps:
            self.look_at(at + 1)
            return

        def job(order: int) -> None:
            self._branch().step()
            self.tell()

        self._do(job)

    def look_at(self, step: int) -> None:
        """Look at the moment after a step; time stands still."""
        at = whole_number(step, "step")
        if self.running:
            self.pause()
        self.tell(at=at, showing=self.live is not None)

    # By hand.

    def teach(self) -> None:
        """Begin a dressing of the chosen arm by hand."""
        choices = self.choices

        def job(order: int) -> None:
            self._told("the cloth settles")
            live = Live.by_hand(choices.posture, choices.config())
            self.guide = guide(choices)
            self._begin(live)
            self._run(order)

        self._do(job)

    def take_over(self) -> None:
        """Lead by hand from the moment that is looked at."""

        def job(order: int) -> None:
            self._branch().take_over()
            self._run(order)

        self._do(job)

    def lead(self, target: NDArray[np.float64]) -> None:
        """Lead the gripper to a place (3,) [m], if it is led by hand."""
        place = real_vector(target, 3, "target has", "m")
        live = self.live
        if live is not None and isinstance(live.leader, ByHand):
            live.leader.target = place

    @property
    def by_hand(self) -> bool:
        """Whether the dressing is led by hand and not over."""
        live = self.live
        return live is not None and isinstance(live.leader, ByHand) and not live.over

    def let_go(self) -> None:
        """End a dressing by hand: the robot holds, and there is a verdict."""

        def job(order: int) -> None:
            self._branch().let_go()
            self._run(order)

        self._do(job)

    def keep_take(self) -> None:
        """Keep the dressing by hand as a demonstration.

        Raises:
            InvalidInputError: It was none, or did not dress the arm.
        """
        live = self.live
        if live is None or not isinstance(live.leader, ByHand):
            raise InvalidInputError("there is no take; valid is to lead the gripper by hand first")
        self.lessons.keep(demonstration_of(live))
        self.tell(error="")

    def drop_take(self) -> None:
        """Drop the last take.

        Raises:
            InvalidInputError: There is none, or its file cannot be written.
        """
        self.lessons.drop(len(self.lessons.takes) - 1)
        self.tell(error="")

    def train(self) -> None:
        """Learn from the takes from now on."""
        self.choose(replace(self.choices, demonstrations=TAKES))
        self.tell(showing=False)

    def set_speed(self, speed: float) -> None:
        """How fast time goes, see `speed`."""
        self.tell(speed=real_number(speed, "speed", 0.0, 100.0))

    # A run.

    def replay(self, row: str, posture: str, beside: str | None = None) -> None:
        """Show an episode of the run again, beside that of another row on the same posture."""
        past = self.past
        if past is None:
            raise InvalidInputError("no run is open; valid is dressing-sim view RUN")
        index = past.episode(row, posture).index
        other = None if beside is None else past.episode(beside, posture).index

        def job(order: int) -> None:
            second = None
            if other is not None:
                self._told(f"{beside} dresses {posture}")
                second = past.live(other)
                while order == self._order and second.step():
                    pass
            self._told(f"{row} learns again")
            self.guide = None
            self._begin(past.live(index), second, index)
            self._run(order)

        self._do(job)
