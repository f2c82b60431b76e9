"""A run that was measured before, to be looked at: its postures, its verdicts, its episodes."""

from __future__ import annotations

from pathlib import Path as File

from dressing_sim.benchmark.records import EpisodeResult, first_failure
from dressing_sim.benchmark.run.lines import parse_episode
from dressing_sim.benchmark.run.runner import Work, learned_source
from dressing_sim.benchmark.run.store import load_run
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.rules import RULES
from dressing_sim.errors import InvalidInputError
from dressing_sim.viewer.live import Live
from dressing_sim.world.robot import PANDA

#: Colours of an arm that is dressed, and of an episode that says nothing.
DRESSED, INVALID = "#009e73", "#b0b0b0"

#: Of each rule's failures: their colour, and how they are told.
_COLOURS = {rule.name: rule.colour for rule in RULES}
_TITLES = {rule.name: rule.title for rule in RULES}


def title_of(failure: Failure) -> str:
    """A failure in a few words."""
    return _TITLES.get(failure.reason, failure.reason.replace("_", " "))


def colour_of(outcome: Outcome) -> str:
    """The colour of a verdict, ``#rrggbb``: that of the rule which was broken first."""
    if outcome.success:
        return DRESSED
    failure = first_failure(outcome)
    if outcome.invalid is not None or failure is None:
        return INVALID
    colour = _COLOURS.get(failure.reason, INVALID)
    return "#404040" if colour == "#000000" else colour


def verdict_of(outcome: Outcome) -> str:
    """The verdict in a word or a few."""
    if outcome.success:
        return "dressed"
    failure = first_failure(outcome)
    if outcome.invalid is not None or failure is None:
        return outcome.verdict
    return title_of(failure)


class Past:
    """The episodes of a run's folder.

    Args:
        folder: What ``dressing-sim evaluate`` left.

    Attributes:
        rows: Labels of the table's rows that have episodes.

    Raises:
        InvalidInputError: There is no run, or its episodes cannot be repeated.
    """

    def __init__(self, folder: File) -> None:
        self._run = load_run(folder)
        plan = self._run.plan
        if plan.protocol.study != "success" or not self._run.finished:
            raise InvalidInputError(
                f"{folder}: a run of the study {plan.protocol.study!r} with "
                f"{len(self._run.finished)} episodes; valid is what 'dressing-sim evaluate' left"
            )
        robot = plan.config.world.robot
        if robot != PANDA:
            raise InvalidInputError(
                f"{folder}: {robot.name} dressed; valid is a run of the {PANDA.name}, which the "
                "page draws"
            )
        self._results = {r.index: r for r in (parse_episode(plan, v) for v in self._run.lines)}
        labels = dict.fromkeys(result.entry.label for result in self._results.values())
        self.rows = tuple(labels)

    @property
    def name(self) -> str:
        """What the run is called."""
        return self._run.path.name

    def episodes(self, row: str) -> list[EpisodeResult]:
        """The episodes of a row, in the order of the suite."""
        return [one for one in self._results.values() if one.entry.label == row]

    def episode(self, row: str, posture: str) -> EpisodeResult:
        """The episode of a row on a posture, by its name.

        Raises:
            InvalidInputError: There is none.
        """
        for one in self.episodes(row):
            if one.posture.name == posture:
                return one
        raise InvalidInputError(f"no episode of {row!r} on {posture!r}; valid is one of the run")

    def live(self, index: int) -> Live:
        """An episode anew, with a policy that learns again from the run's demonstrations.

        Raises:
            DressingSimError: A demonstration is missing, or the policy gives no answer.
        """
        job = self._run.plan.jobs[index]
        posture, config, _ = job.situation(self._run.plan.config)
        source = learned_source(self._run, job, Work())
        return Live.of_policy(source, posture, job.seed, config)

    def agrees(self, index: int, outcome: Outcome) -> bool:
        """Whether an outcome has the verdict and the reasons that the run recorded."""
        recorded = self._results[index].outcome
        return (recorded.success, recorded.reasons) == (outcome.success, outcome.reasons)
