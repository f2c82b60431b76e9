"""A search for hyper-parameters with the same budget for every method: successive halving.

Trials are a Sobol design over a policy's open hyper-parameters, the first one the policy as it is.
All dress the first postures of the validation suite; the better quarter of them dresses more, and
the best few of those all of it. Never is a test suite used.

A rung of the ladder is an ordinary run, with its folder; it goes on where it was cut short.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.run.executors import Workers
from dressing_sim.benchmark.run.plan import Plan, make_plan
from dressing_sim.benchmark.run.progress import Progress, silent
from dressing_sim.benchmark.studies.study import run_study
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.checks import whole_number
from dressing_sim.config import to_plain
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


@dataclass(frozen=True, slots=True)
class Search:
    """What is searched for, and how much it may cost.

    Attributes:
        policy: Its name.
        trials: How many sets of hyper-parameters are tried, the policy as it is among them.
        seed: Of the design, and of the operator's variability.
        cases: What each trial learns from; its score is the mean over these.
        postures: How many of the suite's postures each rung dresses, ever more.
    """

    policy: str
    trials: int = 60
    seed: int = 0
    cases: tuple[str, ...] = CASES
    postures: tuple[int, ...] = POSTURES

    def __post_init__(self) -> None:
        whole_number(self.trials, "trials", 1, 4096)
        if list(self.postures) != sorted(set(self.postures)) or not self.postures:
            raise InvalidInputError(f"postures are {self.postures}, valid are ever more")

    def names(self) -> list[str]:
        """The policies that are tried, by their names; the first is the policy as it is."""
        space = space_of(self.policy)
        design = qmc.Sobol(len(space), scramble=True, rng=np.random.default_rng(self.seed))
        shares = design.random(1 << (self.trials - 1).bit_length())[: self.trials - 1]
        return [self.policy, *(named(self.policy, space, row) for row in shares)]

    def plan(self, names: Sequence[str], rung: int) -> Plan:
        """The run of a rung: the postures that the rungs before have not dressed."""
        entries = tuple(Entry(name, case) for name in names for case in self.cases)
        plan = make_plan(Protocol(f"search-{self.policy}-{rung}", SUITE, entries), self.seed)
        before = self.postures[rung - 1] if rung else 0
        return replace(plan, tested=plan.tested[before : self.postures[rung]])


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


def search(
    what: Search,
    workers: Workers,
    out: Path,
    resume: bool = False,
    force: bool = False,
    progress: Progress = silent,
    study: Success | None = None,
) -> dict[str, Any]:
    """Carry a search out.

    Args:
        what: What is searched for.
        workers: Where episodes run.
        out: Folder; each rung has a run's folder in it.
        resume: Continue the rungs that are there.
        force: Begin anew whatever the rungs' folders hold.
        progress: Told after each episode.
        study: What a rung measures; success unless given.

    Returns:
        ``{"policy", "chosen", "trials", "best_so_far", "n_episodes", "search", "versions"}``:
        the name of the best of those that dressed all postures, every trial with its score, the
        best score of the first n trials in the rung that all of them are in.
    """
    study = study or Success()
    names, first = what.names(), [0.0]
    results: list[EpisodeResult] = []
    trials: dict[str, Trial] = {}
    for rung in range(len(what.postures)):
        plan = what.plan(names, rung)
        where = out / str(rung)
        run = run_study(study, plan, workers, where, resume=resume, force=force, progress=progress)
        results += run.results
        trials |= {name: trial_of(name, rung, results) for name in names}
        if rung == 0:
            first = [trials[name].score for name in names]
        names = best(names, trials, max(1, round(GOES_ON * len(names))))
    best_so_far = np.maximum.accumulate(first)
    return {
        "policy": what.policy,
        "chosen": names[0],
        "trials": list(map(asdict, trials.values())),
        "best_so_far": best_so_far.tolist(),
        "n_episodes": len(results),
        "search": to_plain(what),
        "versions": versions(),
    }


def best(names: Sequence[str], trials: Mapping[str, Trial], n: int) -> list[str]:
    """The best n trials, best first; of equals those tried first."""
    return sorted(names, key=lambda name: -trials[name].score)[:n]


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


def _margins(result: EpisodeResult) -> Iterator[float]:
    limits, metrics = Thresholds(), result.outcome.metrics
    if "strain" in metrics:
        yield 1.0 - metrics["strain"] / limits.strain
        yield 1.0 - metrics["grip_force"] / limits.grip_force
        yield (metrics["armscye_s"] - limits.armscye_s) / (_SHOULDER - limits.armscye_s)
