"""What one page holds and does, without a browser: choices, a preview, and a dressing in progress.

All tabs of a page show the same session. Three threads share the work: one follows the choices at
once, one demonstrates and learns, one simulates; a new order to the last replaces the one before.
"""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dressing_sim.checks import of_kind, real_number, real_vector, whole_number
from dressing_sim.control import PandaKinematics
from dressing_sim.errors import DressingSimError, InvalidInputError, one_line
from dressing_sim.path import Path
from dressing_sim.viewer.choices import TAKES, Choices
from dressing_sim.viewer.lessons import Lessons, demonstration_of
from dressing_sim.viewer.live import ByHand, Live, Moment
from dressing_sim.viewer.past import Past
from dressing_sim.viewer.preview import Preview, guide, preview, resting

_LOG = logging.getLogger("dressing_sim")

#: Looks for a new target so often while time stands still [s].
_PATIENCE = 0.005

#: Longest error that is told.
_LONGEST = 400


class Session:
    """One page's state.

    Args:
        lessons: What can be learned from.
        choices: What is chosen at first.
        past: A run to look at, or None.

    Attributes:
        lessons: As given.
        past: As given.
        choices: What is chosen now.
        preview: What they look like; None until that is known.
        rest: Joint positions (7,) of the robot in it [rad]; None until they are known.
        showing: Whether the dressing is looked at, not the preview.
        guide: A path to teach along, while somebody teaches.
        live: The dressing that was begun last, or None.
        beside: Another one that it is compared with, or None.
        replayed: Index of the run's episode that `live` is, or None.
        running: Whether time goes on.
        at: The step that is looked at; None for the newest.
        speed: Simulated seconds a second, at most; 0 for as many as there can be.
        status: What is being done, or nothing.
        error: What went wrong last, or nothing.
    """

    def __init__(
        self, lessons: Lessons, choices: Choices | None = None, past: Past | None = None
    ) -> None:
        self.lessons, self.past = lessons, past
        self.choices = choices or Choices()
        self.preview: Preview | None = None
        self.rest: NDArray[np.float64] | None = None
        self.showing = False
        self.guide: Path | None = None
        self.live: Live | None = None
        self.beside: Live | None = None
        self.replayed: int | None = None
        self.running = False
        self.at: int | None = None
        self.speed = 1.0
        self.status = self.error = ""
        self._order = self._look = 0
        self._made_with = ""
        self._kinematics = PandaKinematics()
        self._lock = threading.RLock()
        self._news = threading.Condition()
        self._version = 0
        self._previewing, self._learning, self._simulating = (
            ThreadPoolExecutor(1, name) for name in ("preview", "learn", "simulate")
        )

    def close(self) -> None:
        """End what is being done; the session is of no use afterwards."""
        self._order += 1
        for pool in (self._previewing, self._learning, self._simulating):
            pool.shutdown(wait=False, cancel_futures=True)

    # What watches it.

    def _tell(self, **changes: object) -> None:
        with self._news:
            for name, value in changes.items():
                setattr(self, name, value)
            self._version += 1
            self._news.notify_all()

    def refresh(self) -> None:
        """Let whoever watches look again."""
        self._tell()

    def news(self, seen: int, timeout: float | None = None) -> int:
        """Wait until there is something newer than a version; returns what it is now."""
        with self._news:
            self._news.wait_for(lambda: self._version != seen, timeout)
            return self._version

    @property
    def version(self) -> int:
        """How often something has changed."""
        return self._version

    def wait(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Wait until something is so; whether it is."""
        with self._news:
            return self._news.wait_for(condition, timeout)

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

    # What is chosen.

    def choose(self, choices: Choices) -> None:
        """Choose otherwise; the preview follows, and a policy that has not learned begins to."""
        of_kind(choices, Choices, "choices", "Choices")
        before, self._look = self.choices, self._look + 1
        moved = (before.posture, before.garment, before.friction) != (
            choices.posture,
            choices.garment,
            choices.friction,
        )
        if moved and self.showing:
            self._order += 1
        self._tell(choices=choices, error="", showing=self.showing and not moved)
        self._previewing.submit(self._follow, self._look)

    def choose_by(self, change: Callable[[Choices], Choices]) -> None:
        """Choose what a function makes of the choices; an error of it is told on the page."""
        with self._reporting(busy=False), self._lock:
            self.choose(change(self.choices))

    def _follow(self, look: int) -> None:
        if look != self._look:
            return  # somebody has chosen again since
        choices = self.choices
        with self._reporting(busy=False):
            policy = self.lessons.ready(choices)
            shown = preview(choices, policy)
            self._tell(preview=shown)
            if policy is None:
                self._learning.submit(self._learn, look)
            if look == self._look:
                self._tell(rest=resting(shown, self._kinematics))

    def _learn(self, look: int) -> None:
        if look != self._look:
            return
        with self._reporting():
            self.lessons.policy(self.choices, self._told)
            self._previewing.submit(self._follow, self._look)

    def _told(self, status: str) -> None:
        self._tell(status=status)

    def _reporting(self, busy: bool = True) -> _Reporting:
        return _Reporting(self._tell, busy)

    # What is simulated.

    def _do(self, job: Callable[[int], None]) -> None:
        """Let the simulating thread do something instead of what it does."""
        self._order += 1
        order = self._order

        def guarded() -> None:
            if order == self._order:
                with self._reporting():
                    job(order)

        self._simulating.submit(guarded)

    def _begin(self, live: Live, beside: Live | None = None, replayed: int | None = None) -> None:
        with self._lock:
            self._tell(
                live=live, beside=beside, replayed=replayed, at=None, status="", showing=True
            )

    def _run(self, order: int) -> None:
        """Let time go on until it is over, or somebody wants something else."""
        live = self.live
        if live is None:
            return
        self._tell(running=True, at=None)
        try:
            due, waited = time.perf_counter(), False
            while order == self._order:
                if live.waits:
                    if not waited:
                        self._tell()
                    waited = True
                    time.sleep(_PATIENCE)
                    due = time.perf_counter()
                    continue
                waited = False
                if not live.step():
                    break
                self._tell()
                if self.speed > 0.0:
                    due = max(due + live.dressing.config.tracking.dt / self.speed, due)
                    time.sleep(max(0.0, due - time.perf_counter()))
                    due = max(due, time.perf_counter() - 0.1)
        finally:
            self._tell(running=False)

    def dress(self) -> None:
        """Begin a dressing of what is chosen."""
        choices = self.choices

        def job(order: int) -> None:
            policy = self._learning.submit(self.lessons.policy, choices, self._told).result()
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
        self._tell()

    def go_on(self) -> None:
        """Let time go on from the moment that is looked at: what came later is forgotten.

        If another policy is chosen by now, it goes on with the rest of the path that it would take.
        """
        choices = self.choices

        def job(order: int) -> None:
            live = self._branch()
            if isinstance(live.leader, ByHand):
                self._run(order)
                return
            if live.leader is not None and choices.policy_name != self._made_with:
                policy = self._learning.submit(self.lessons.policy, choices, self._told).result()
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
            self._tell(at=None, status="", showing=True)
        return live

    def step_once(self) -> None:
        """Go on by one control step."""

        def job(order: int) -> None:
            self._branch().step()
            self._tell()

        self._do(job)

    def look_at(self, step: int) -> None:
        """Look at the moment after a step; time stands still."""
        at = whole_number(step, "step")
        if self.running:
            self.pause()
        self._tell(at=at, showing=self.live is not None)

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
            live = self._branch()
            live.take_over()
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
        self._tell(error="")

    def drop_take(self) -> None:
        """Drop the last take.

        Raises:
            InvalidInputError: There is none, or its file cannot be written.
        """
        self.lessons.drop(len(self.lessons.takes) - 1)
        self._tell(error="")

    def telling(self) -> AbstractContextManager[None]:
        """Within the block an error is told on the page."""
        return self._reporting(busy=False)

    def train(self) -> None:
        """Learn from the takes from now on."""
        self.choose(replace(self.choices, demonstrations=TAKES))
        self._tell(showing=False)

    def set_speed(self, speed: float) -> None:
        """How fast time goes, see `speed`."""
        self._tell(speed=real_number(speed, "speed", 0.0, 100.0))

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
            live = past.live(index)
            self.guide = None
            self._begin(live, second, index)
            self._run(order)

        self._do(job)


class _Reporting(AbstractContextManager[None]):
    """Within the block an error is told on the page instead of ending the thread.

    Args:
        tell: As `Session._tell`.
        busy: Whether the block sets the status, which is then empty after it.
    """

    def __init__(self, tell: Callable[..., None], busy: bool) -> None:
        self._tell, self._busy = tell, busy

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, value: BaseException | None, traceback: object) -> bool:
        if value is None:
            if self._busy:
                self._tell(status="")
            return False
        if not isinstance(value, Exception):
            return False
        if not isinstance(value, DressingSimError):
            _LOG.error("the page: %r", value, exc_info=value)
        self._tell(status="", error=one_line(str(value) or repr(value), _LONGEST))
        return True
