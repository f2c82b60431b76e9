"""What is chosen, and the preview that follows it at once."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from dressing_sim.checks import of_kind
from dressing_sim.control import RobotKinematics
from dressing_sim.learning import Policy
from dressing_sim.viewer.choices import Choices
from dressing_sim.viewer.lessons import Lessons
from dressing_sim.viewer.preview import Preview, preview, resting
from dressing_sim.viewer.watched import Watched


class Choosing(Watched, ABC):
    """Choices, and what they look like. One thread follows them, another learns.

    Args:
        lessons: What can be learned from.
        choices: What is chosen at first.

    Attributes:
        lessons: As given.
        choices: What is chosen now.
        preview: What they look like; None until that is known.
        rest: Joint positions (7,) of the robot in it [rad]; None until they are known.
        showing: Whether a dressing is looked at, not the preview.
    """

    def __init__(self, lessons: Lessons, choices: Choices | None = None) -> None:
        super().__init__()
        self.lessons = lessons
        self.choices = choices or Choices()
        self.preview: Preview | None = None
        self.rest: NDArray[np.float64] | None = None
        self.showing = False
        self._look = 0
        self._kinematics = RobotKinematics()
        self._lock = threading.RLock()
        self._previewing = ThreadPoolExecutor(1, "preview")
        self._learning = ThreadPoolExecutor(1, "learn")

    def close(self) -> None:
        """End what is being done; it is of no use afterwards."""
        for pool in (self._previewing, self._learning):
            pool.shutdown(wait=False, cancel_futures=True)

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
            self.pause()
        self.tell(choices=choices, error="", showing=self.showing and not moved)
        self._previewing.submit(self._follow, self._look)

    def choose_by(self, change: Callable[[Choices], Choices]) -> None:
        """Choose what a function makes of the choices; an error of it is told on the page."""
        with self.telling(), self._lock:
            self.choose(change(self.choices))

    @abstractmethod
    def pause(self) -> None:
        """Let time stand still in the dressing that is looked at."""

    def _follow(self, look: int) -> None:
        if look != self._look:
            return  # somebody has chosen again since
        choices = self.choices
        with self.telling():
            policy = self.lessons.ready(choices)
            shown = preview(choices, policy)
            self.tell(preview=shown)
            if policy is None:
                self._learning.submit(self._learn, look)
            if look == self._look:
                self.tell(rest=resting(shown, self._kinematics))

    def _learn(self, look: int) -> None:
        if look != self._look:
            return
        with self.telling(busy=True):
            self.lessons.policy(self.choices, self._told)
            self._previewing.submit(self._follow, self._look)

    def learned(self, choices: Choices) -> Future[Policy]:
        """The policy, as soon as it has learned."""
        return self._learning.submit(self.lessons.policy, choices, self._told)
