"""What one page holds and does, without a browser: dressings by policies, by hand, and of a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dressing_sim.checks import real_vector
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.registry import DEFAULT, learns
from dressing_sim.viewer.choices import TAKES, TAUGHT, Choices
from dressing_sim.viewer.guide import Guide
from dressing_sim.viewer.leaders import ByHand
from dressing_sim.viewer.lessons import Lessons, demonstration_of
from dressing_sim.viewer.live import Live
from dressing_sim.viewer.past import Past
from dressing_sim.viewer.playing import Playing

#: The gripper is at the end of the guide when so much of it is left [m].
_THERE = 0.02


class Session(Playing):
    """One page's state.

    Args:
        lessons: What can be learned from.
        choices: What is chosen at first.
        past: A run to look at, or None.

    Attributes:
        past: As given.
        kept: The dressing by hand that was kept last, or None.
    """

    def __init__(
        self, lessons: Lessons, choices: Choices | None = None, past: Past | None = None
    ) -> None:
        super().__init__(lessons, choices)
        self.past = past
        self.kept: Live | None = None

    # By hand.

    def another_arm(self) -> None:
        """Choose an arm that nobody has taught yet; after the last the first comes again."""
        taken = {take.posture.name for take in self.lessons.takes}
        names = [posture.name for posture in TAUGHT]
        now = self.choices.posture.name
        first = names.index(now) + 1 if now in names else 0
        order = [*TAUGHT[first:], *TAUGHT[:first]]
        free = [one for one in order if one.name not in taken | {now}]
        self.choose_by(lambda choices: replace(choices, posture=(free or order)[0]))
        self.tell(showing=False)

    def teach(self) -> None:
        """Begin a dressing of the chosen arm by hand."""
        choices = self.choices

        def job(order: int) -> None:
            self._told("the cloth settles")
            live = Live.by_hand(choices.posture, choices.config())
            self.guide = Guide.of(choices)
            self._begin(live)
            self._run(order)

        self._do(job)

    def take_over(self) -> None:
        """Lead by hand from the moment that is looked at."""

        def job(order: int) -> None:
            live = self._branch()
            live.take_over()
            self.guide = Guide.of(replace(self.choices, posture=live.dressing.posture))
            self._run(order)

        self._do(job)

    @property
    def hand(self) -> ByHand | None:
        """Who leads by hand now, if somebody does."""
        live = self.live
        if live is None or live.over or not isinstance(live.leader, ByHand):
            return None
        return live.leader

    @property
    def by_hand(self) -> bool:
        """Whether the dressing is led by hand and not over."""
        return self.hand is not None

    def lead(self, target: NDArray[np.float64]) -> None:
        """Lead the gripper straight to a place (3,) [m], if it is led by hand."""
        place, hand = real_vector(target, 3, "target has", "m"), self.hand
        if hand is not None:
            hand.lead(place)

    def point(self, eye: NDArray[np.float64], through: NDArray[np.float64]) -> None:
        """Lead the gripper to where somebody points: along the guide if they point at it.

        Args:
            eye: Where the ray begins, (3,) [m].
            through: Where it passes, and where the gripper goes if not along the guide, (3,) [m].
        """
        hand, guide = self.hand, self.guide
        if hand is None:
            return
        at = None if guide is None else guide.nearest(hand.target)
        to = None if guide is None or at is None else guide.pointed_at(eye, through, at)
        if to is None:
            hand.lead(through)
        else:
            self._lead_along(to)

    def follow_guide(self) -> None:
        """Lead the gripper along the guide to its end."""
        guide = self.guide
        if guide is not None:
            self._lead_along(len(guide.path.positions) - 1)

    @property
    def left(self) -> float | None:
        """Length of the guide that is left for whoever leads by hand [m]; None without."""
        live, guide = self.live, self.guide
        if live is None or guide is None or not self.by_hand:
            return None
        return guide.left(live.dressing.target)

    @property
    def arrived(self) -> bool:
        """Whether whoever leads by hand is at the end of the guide."""
        left = self.left
        return left is not None and left < _THERE

    def _lead_along(self, to: int) -> None:
        live, hand, guide = self.live, self.hand, self.guide
        if live is None or hand is None or guide is None:
            return
        tracking, at = live.dressing.config.tracking, guide.nearest(hand.target)
        if to != at:
            way = guide.way(hand.target, at, to, tracking.dt, tracking.max_speed)
            hand.lead_along(way)

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
        self.tell(error="", kept=live)

    def drop_take(self) -> None:
        """Drop the last take.

        Raises:
            InvalidInputError: There is none, or its file cannot be written.
        """
        self.lessons.drop(len(self.lessons.takes) - 1)
        self.tell(error="")

    def train(self) -> None:
        """Learn from the takes from now on: with the chosen policy, or the default if it cannot."""
        policy = self.choices.policy if learns(self.choices.policy_name) else DEFAULT
        self.choose(replace(self.choices, policy=policy, demonstrations=TAKES))
        self.tell(showing=False)

    @property
    def trained(self) -> bool:
        """Whether the chosen policy has learned from the takes that there are."""
        choices = self.choices
        return choices.demonstrations == TAKES and self.lessons.ready(choices) is not None

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
