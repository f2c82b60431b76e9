"""What policies learn from on the page: suites that are demonstrated, and the user's own takes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from pathlib import Path as File

import numpy as np

from dressing_sim.benchmark.records import Entry
from dressing_sim.benchmark.run.plan import fitting_seed
from dressing_sim.benchmark.run.runner import record_demonstration
from dressing_sim.checks import whole_number
from dressing_sim.config import to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.demonstration import (
    Demonstration,
    load_demonstrations,
    save_demonstrations,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import is_file
from dressing_sim.learning import Policy
from dressing_sim.policies.hosted import hosted_policy
from dressing_sim.policies.registry import learns
from dressing_sim.suites.suites import load_suite
from dressing_sim.viewer.choices import TAKES, Choices
from dressing_sim.viewer.live import Live

#: Policies and sets of demonstrations that are kept; the oldest goes.
_KEPT = 16

#: Told what is being done, in a few words.
Told = Callable[[str], None]


def demonstration_of(live: Live, seed: int = 0) -> Demonstration:
    """What the gripper did in a dressing, without the final hold, as a demonstration.

    Raises:
        InvalidInputError: The arm was not dressed, so there is nothing to learn from.
    """
    outcome = live.outcome
    if outcome is None or not outcome.success:
        why = "it is not over" if outcome is None else outcome.invalid or ", ".join(outcome.reasons)
        raise InvalidInputError(f"nothing to learn from ({why}); valid is a take that dresses")
    moved = [order.target is not None for order in live.orders]
    last = len(moved) - moved[::-1].index(True) if any(moved) else 0
    dressing = live.dressing
    places = [dressing.start, *(moment.row.tcp for moment in live.moments[1 : last + 1])]
    return Demonstration(
        positions=np.array(places),
        dt=dressing.config.tracking.dt,
        posture=dressing.posture,
        seed=seed,
        commands=np.array(live.commands[: last + 1]),
        settings={"episode": to_plain(dressing.config), "operator": {"led": "by hand"}},
        outcome=outcome,
    )


class Lessons:
    """Demonstrations and fitted policies by what was chosen; each is made once and kept.

    Args:
        file: Where takes are kept; those that are there already are there to learn from.

    Raises:
        InvalidInputError: The file is there, and none of demonstrations.
    """

    def __init__(self, file: File) -> None:
        self.file = file
        self._takes = load_demonstrations(file) if is_file(file) else []
        self._number = 0  # of changes to the takes
        self._sets: dict[tuple[str, str, int], list[Demonstration]] = {}
        self._policies: dict[tuple[str, str, str, int, int], Policy] = {}
        self._lock = threading.Lock()

    @property
    def takes(self) -> list[Demonstration]:
        """The user's own demonstrations."""
        with self._lock:
            return [*self._takes]

    def keep(self, take: Demonstration) -> None:
        """Keep a take, in the file too."""
        with self._lock:
            save_demonstrations(self.file, [*self._takes, take])
            self._takes.append(take)
            self._number += 1

    def drop(self, number: int) -> None:
        """Drop a take by its number, from 0; of the file too."""
        with self._lock:
            whole_number(number, "take", 0, len(self._takes) - 1)
            rest = [one for at, one in enumerate(self._takes) if at != number]
            save_demonstrations(self.file, rest)
            self._takes = rest
            self._number += 1

    def ready(self, choices: Choices) -> Policy | None:
        """The policy, if it has learned already, or has nothing to learn."""
        if not learns(choices.policy_name):
            return hosted_policy(choices.policy_name)
        with self._lock:
            return self._policies.get(self._key(choices))

    def demonstrations(
        self, choices: Choices, told: Told = lambda text: None
    ) -> Sequence[Demonstration]:
        """What a policy learns from: as ``dressing-sim dress`` has it for a suite.

        Raises:
            DressingSimError: A demonstration failed, or there is no take.
        """
        if choices.demonstrations == TAKES:
            if not self.takes:
                raise InvalidInputError("there are no takes yet; valid is to teach one first")
            return self.takes
        key = choices.demonstrations, choices.garment, choices.seed
        if key not in self._sets:
            config: EpisodeConfig = choices.nominal()
            made = []
            postures = load_suite(choices.demonstrations)
            for number, posture in enumerate(postures, start=1):
                told(f"demonstrating {number} of {len(postures)}, on {posture.name}")
                made.append(record_demonstration(choices.seed, posture, 0, config))
            self._keep(self._sets, key, made)
        return self._sets[key]

    def policy(self, choices: Choices, told: Told = lambda text: None) -> Policy:
        """The policy, which learns now unless it has.

        Raises:
            DressingSimError: It cannot learn from the demonstrations.
        """
        found = self.ready(choices)
        if found is not None:
            return found
        key, name = self._key(choices), choices.policy_name
        # The first set of a row in a table, as in ``dressing-sim dress``.
        seed = fitting_seed(choices.seed, Entry(name, choices.demonstrations), 0)
        policy = hosted_policy(name, seed)
        if learns(name):
            demonstrations = self.demonstrations(choices, told)
            told(f"{name} learns from {len(demonstrations)} demonstrations")
            policy = policy.fit(demonstrations)
        self._keep(self._policies, key, policy)
        return policy

    def _key(self, choices: Choices) -> tuple[str, str, str, int, int]:
        name = choices.policy_name
        if not learns(name):
            return name, "", "", 0, 0
        own = choices.demonstrations == TAKES
        number = self._number if own else 0
        garment = "" if own else choices.garment
        return name, choices.demonstrations, garment, choices.seed, number

    def _keep(self, kept: dict, key: tuple, value: object) -> None:
        with self._lock:
            kept[key] = value
            while len(kept) > _KEPT:
                del kept[next(iter(kept))]
