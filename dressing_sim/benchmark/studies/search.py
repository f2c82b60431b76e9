"""A search for hyper-parameters with the same budget for every method: successive halving.

Trials are a Sobol design over a policy's open hyper-parameters, the first one the policy as it is.
All dress the first postures of the validation suite; the better quarter of them dresses more, and
the best few of those all of it. Where that costs too much, trials are screened before: by the paths
they draw on that suite, without physics. Never is a test suite used.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence, Set
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import qmc

from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.plan import Job, Plan, make_plan
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.benchmark.studies.search_document import search_document
from dressing_sim.benchmark.studies.study import EpisodeStudy, Summary
from dressing_sim.checks import whole_number
from dressing_sim.config import from_plain, to_plain
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.search_spaces import named, space_of
from dressing_sim.provenance import versions

#: Where hyper-parameters may be chosen, and what policies learn from while they are.
SUITE, CASES = "val50", ("case_a", "case_b")

#: Arm coordinate of the shoulder.
_SHOULDER = 2.0

#: How many postures, from the first, the trials of a rung dress, and which share of them goes on.
POSTURES, GOES_ON = (5, 16, 50), 0.25

#: The same where trials were screened, and how many of them dress at all.
SCREENED_POSTURES, SCREENED = (8, 50), 8


@dataclass(frozen=True, slots=True)
class Search:
    """What is searched for, and how much it may cost.

    Attributes:
        policy: Its name.
        trials: How many sets of hyper-parameters are tried, the policy as it is among them.
        seed: Of the design, and of the operator's variability.
        cases: What each trial learns from; its score is the mean over these.
        postures: How many of the suite's postures each rung dresses, ever more.
        screened: All trials, the best by their paths first; empty if they were not screened.
        path_scores: Mean scores of their paths, see `PathMetrics.score`.

    Raises:
        InvalidInputError: Nothing is tried, or postures that do not rise.
    """

    policy: str
    trials: int = 60
    seed: int = 0
    cases: tuple[str, ...] = CASES
    postures: tuple[int, ...] = POSTURES
    screened: tuple[str, ...] = ()
    path_scores: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        whole_number(self.trials, "trials", 1, 4096)
        if list(self.postures) != sorted(set(self.postures)) or not self.postures:
            raise InvalidInputError(f"postures are {self.postures}, valid are ever more")

    @classmethod
    def of(cls, plan: Plan) -> Search:
        """The inverse of `plan`."""
        return from_plain(cls, {**plan.options, "seed": plan.seed})

    def names(self) -> list[str]:
        """The policies that dress, by their names; the first is the policy as it is."""
        if self.screened:
            others = [name for name in self.screened if name != self.policy]
            return [self.policy, *others[: SCREENED - 1]]
        return self.design()

    def design(self) -> list[str]:
        """The policies that are tried, by their names; the first is the policy as it is."""
        space = space_of(self.policy)
        design = qmc.Sobol(len(space), scramble=True, rng=np.random.default_rng(self.seed))
        shares = design.random(1 << (self.trials - 1).bit_length())[: self.trials - 1]
        return [self.policy, *(named(self.policy, space, row) for row in shares)]

    def screening(self) -> Plan:
        """The plan of the study `Tuning` that draws every trial's paths on all postures.

        Raises:
            InvalidInputError: The policy has no ranges to search in.
        """
        entries = tuple(Entry(name, case) for name in self.design() for case in self.cases)
        protocol = Protocol(f"screening-{self.policy}", SUITE, entries, study="tuning")
        return make_plan(protocol, self.seed)

    def after(self, screening: Summary) -> Search:
        """The search among those whose paths were the best, by the summary of `screening`."""
        scores: dict[str, list[float]] = {}
        for row in screening["rows"]:
            scores.setdefault(row["policy"], []).append(row["score"])
        means = {name: float(np.mean(own)) for name, own in scores.items()}
        ranked = tuple(sorted(means, key=lambda name: -means[name]))
        return replace(
            self,
            postures=SCREENED_POSTURES,
            screened=ranked,
            path_scores=tuple(means[name] for name in ranked),
        )

    def plan(self) -> Plan:
        """Every trial on every posture, of which rungs leave most out.

        Raises:
            InvalidInputError: The policy has no ranges to search in.
        """
        entries = tuple(Entry(name, case) for name in self.names() for case in self.cases)
        protocol = Protocol(f"search-{self.policy}", SUITE, entries, study="search")
        options = {name: value for name, value in to_plain(self).items() if name != "seed"}
        plan = make_plan(protocol, self.seed, options=options)
        return replace(plan, tested=plan.tested[: self.postures[-1]])


@dataclass(frozen=True, slots=True)
class Trial:
    """One set of hyper-parameters.

    Attributes:
        policy: Its name with them.
        rung: How far it got, from 0.
        n_episodes: How many of its episodes counted.
        n_success: How many of those dressed.
        score: See `score`.
    """

    policy: str
    rung: int
    n_episodes: int
    n_success: int
    score: float


@dataclass(frozen=True)
class Ladder:
    """Where the trials of a search stand.

    Attributes:
        rungs: Those that are in each rung with what is known of them then, the best first.
    """

    rungs: tuple[tuple[Trial, ...], ...]

    @classmethod
    def of(cls, plan: Plan, results: Sequence[EpisodeResult]) -> Ladder:
        """The rungs whose episodes are among the results, in whatever order these are."""
        what, n = Search.of(plan), len(plan.tested)
        inside: list[list[EpisodeResult]] = [[] for _ in what.postures]
        for result in sorted(results, key=lambda result: result.index):
            inside[int(np.searchsorted(what.postures, result.index % n, side="right"))] += [result]
        names, rungs = list(dict.fromkeys(e.policy for e in plan.protocol.entries)), []
        for rung in range(sum(map(bool, inside))):
            known = [result for part in inside[: rung + 1] for result in part]
            trials = {name: trial_of(name, rung, known) for name in names}
            ranked = best(trials.values())
            rungs.append(tuple(ranked))
            names = _going_on(ranked)
        return cls(tuple(rungs))

    @property
    def go_on(self) -> list[str]:
        """Who goes on to the next rung, by their names."""
        return _going_on(self.rungs[-1])


@dataclass(frozen=True)
class SearchStudy(EpisodeStudy):
    """A search: each rung dresses the postures that the rungs before have not."""

    def jobs(self, plan: Plan) -> Sequence[Job]:
        """All trials on the first postures."""
        return _rung(plan, {entry.policy for entry in plan.protocol.entries}, 0)

    def more(self, plan: Plan, results: Sequence[EpisodeResult]) -> Sequence[Job]:
        """The best trials on more postures."""
        ladder = Ladder.of(plan, results)
        return _rung(plan, set(ladder.go_on), len(ladder.rungs))

    def summarise(self, folder: RunFolder, results: Sequence[EpisodeResult]) -> dict[str, Any]:
        """What was found.

        Returns:
            ``{"policy", "chosen", "trials", "best_so_far", "n_episodes", "search", "versions"}``:
            the name of the best of those that dressed all postures, every trial with its score,
            the best score of the first n trials in the rung that all of them are in.
        """
        what, ladder = Search.of(folder.plan), Ladder.of(folder.plan, results)
        known = {trial.policy: trial for rung in ladder.rungs for trial in rung}
        first = {trial.policy: trial.score for trial in ladder.rungs[0]}
        names = list(dict.fromkeys(entry.policy for entry in folder.plan.protocol.entries))
        best_so_far = np.maximum.accumulate([0.0, *(first[name] for name in names)])[1:]
        return {
            "policy": what.policy,
            "chosen": ladder.rungs[-1][0].policy,
            "trials": [asdict(known[name]) for name in names],
            "best_so_far": best_so_far.tolist(),
            "n_episodes": len(results),
            "search": to_plain(what),
            "versions": versions(),
        }

    def document(
        self, folder: RunFolder, results: Sequence[EpisodeResult], summary: Summary, command: str
    ) -> Document:
        """The best trials, and the curve of the best so far."""
        return search_document(summary, command)


def _rung(plan: Plan, names: Set[str], rung: int) -> list[Job]:
    """The jobs of a rung; none beyond the last."""
    postures = Search.of(plan).postures
    if rung == len(postures):
        return []
    columns = range(postures[rung - 1] if rung else 0, postures[rung])
    return [
        job
        for job in plan.jobs
        if job.entry.policy in names and job.index % len(plan.tested) in columns
    ]


def _going_on(ranked: Sequence[Trial]) -> list[str]:
    return [trial.policy for trial in ranked[: max(1, round(GOES_ON * len(ranked)))]]


def best(trials: Iterable[Trial]) -> list[Trial]:
    """Trials, the best first; of equals those tried first."""
    return sorted(trials, key=lambda trial: -trial.score)


def trial_of(policy: str, rung: int, results: Sequence[EpisodeResult]) -> Trial:
    """What a trial's episodes, void ones aside, say of it."""
    own = [r for r in results if r.entry.policy == policy and r.outcome.invalid is None]
    success = sum(result.outcome.success for result in own)
    scores = list(map(score, own))
    return Trial(policy, rung, len(own), success, float(np.mean(scores)) if scores else 0.0)


def score(result: EpisodeResult) -> float:
    """How good an episode was, 0 to 1: half for success, and half for its smallest margin.

    Margins are shares, from -1 to 1: of the limits of pull and strain, and of the way from where
    the armscye must come to the shoulder. Successes alone would not tell ten episodes apart.
    """
    margin = min(_margins(result), default=-1.0)
    return 0.5 * result.outcome.success + 0.25 * (1.0 + float(np.clip(margin, -1.0, 1.0)))


def smallest_margin(result: EpisodeResult) -> float:
    """The smallest margin of an episode, -1 to 1; it failed by something else than these: -1."""
    margin = float(np.clip(min(_margins(result), default=-1.0), -1.0, 1.0))
    return margin if result.outcome.success or margin < 0.0 else -1.0


def _margins(result: EpisodeResult) -> Iterator[float]:
    limits, metrics = Thresholds(), result.outcome.metrics
    if "strain" in metrics:
        yield 1.0 - metrics["strain"] / limits.strain
        yield 1.0 - metrics["grip_force"] / limits.grip_force
        yield (metrics["armscye_s"] - limits.armscye_s) / (_SHOULDER - limits.armscye_s)
