"""A dressing in progress: begun, paused, looked back at and gone on with.

All tabs of a page show the same session. Three threads share the work: one follows the choices at
once, one demonstrates and learns, one simulates; a new order to the last replaces the one before.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

from dressing_sim.benchmark.records import first_failure
from dressing_sim.checks import real_number, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.viewer.choices import Choices
from dressing_sim.viewer.choosing import Choosing
from dressing_sim.viewer.guide import Guide
from dressing_sim.viewer.leaders import ByHand
from dressing_sim.viewer.lessons import Lessons
from dressing_sim.viewer.live import Live, Moment
from dressing_sim.viewer.preview import preview

#: Looks for a new target so often while time stands still [s].
_PATIENCE = 0.005


class Playing(Choosing):
    """Choices, and a dressing of them in progress.

    Args:
        lessons: What can be learned from.
        choices: What is chosen at first.

    Attributes:
        guide: A line to teach along, while somebody teaches.
        live: The dressing that was begun last, or None.
        beside: Another one that it is compared with, or None.
        replayed: Index of the run's episode that `live` is, or None.
        running: Whether time goes on.
        at: The step that is looked at; None for the newest.
        speed: Simulated seconds a second, at most; 0 for as many as there can be.
    """

    def __init__(self, lessons: Lessons, choices: Choices | None = None) -> None:
        super().__init__(lessons, choices)
        self.guide: Guide | None = None
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

    @property
    def failed_at(self) -> int | None:
        """The step in which something went wrong first in the dressing that is shown."""
        live = self.live
        if live is None or live.outcome is None or not self.showing:
            return None
        failure = first_failure(live.outcome)
        if failure is None or failure.time is None or not live.n_steps:
            return None
        return round(failure.time / live.dressing.config.tracking.dt)

    def look_at_failure(self) -> None:
        """Look at the moment in which something went wrong first."""
        step = self.failed_at
        if step is not None:
            self.look_at(step)

    def set_speed(self, speed: float) -> None:
        """How fast time goes, see `speed`."""
        self.tell(speed=real_number(speed, "speed", 0.0, 100.0))
