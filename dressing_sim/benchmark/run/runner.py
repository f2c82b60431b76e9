"""What workers do for a run: demonstrate, learn, dress; and what is done before episodes begin."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import EpisodeResult, Json
from dressing_sim.benchmark.run.cache import cached_demonstration
from dressing_sim.benchmark.run.executors import WorkerDied, Workers, completed
from dressing_sim.benchmark.run.plan import (
    Job,
    Plan,
    demonstration_seed,
    fitting_seed,
    style_of,
)
from dressing_sim.benchmark.run.progress import Progress, silent
from dressing_sim.benchmark.run.store import OpenRun, RunFolder
from dressing_sim.config import to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.demonstration import (
    Demonstration,
    load_demonstrations,
    save_demonstrations,
)
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.record import DemonstrationFailed, demonstrate, record
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rollout import Observer
from dressing_sim.episode.rules import UNANSWERED
from dressing_sim.errors import Abstained, DressingSimError, PolicyError
from dressing_sim.learning import Policy
from dressing_sim.policies.expert import operator_of
from dressing_sim.policies.host import PolicyLimits
from dressing_sim.policies.hosted import Unfit, hosted_policy

T = TypeVar("T")

#: How often a demonstration is tried, each time with another seed, before it is an error.
ATTEMPTS = 5


def record_demonstration(
    plan_seed: int,
    posture: Posture,
    demonstration_set: int,
    config: EpisodeConfig,
    style: str = "",
) -> Demonstration:
    """Demonstrate until it succeeds, as a person would; or as it was demonstrated before.

    The style is the operator's, see `dressing_sim.policies.expert.operator_of`.

    Raises:
        DressingSimError: It failed `ATTEMPTS` times.
    """
    place = plan_seed, posture, demonstration_set, config, style
    key = [plan_seed, posture.to_dict(), demonstration_set, to_plain(config), style]
    return cached_demonstration(key, partial(_record_demonstration, *place))


def _record_demonstration(
    plan_seed: int, posture: Posture, demonstration_set: int, config: EpisodeConfig, style: str
) -> Demonstration:
    operator = operator_of(style)
    for attempt in range(ATTEMPTS):
        seed = demonstration_seed(plan_seed, posture, demonstration_set, attempt)
        try:
            demonstration = demonstrate(posture, seed, operator, config)
        except DemonstrationFailed as error:
            outcome = error.outcome
            continue
        outcome = demonstration.outcome or Outcome(False)
        if outcome.success:
            return demonstration
    why = outcome.invalid or ", ".join(failure.detail for failure in outcome.failures)
    raise DressingSimError(
        f"the demonstration on posture {posture.name!r} with seed {plan_seed} failed {ATTEMPTS} "
        f"times: {why}; choose another seed or posture"
    )


def fit_policy(
    name: str,
    seed: int,
    demonstrations: Sequence[Demonstration],
    limits: PolicyLimits | None = None,
    log: Path | None = None,
) -> Policy:
    """A policy that has learned, or one that says in each episode why it could not."""
    try:
        return hosted_policy(name, seed, limits, log).fit(demonstrations)
    except PolicyError as error:
        return Unfit(name, str(error))


def dress_job(
    source: Policy, job: Job, config: EpisodeConfig, observer: Observer | None = None
) -> EpisodeResult:
    """Run one episode."""
    posture, varied, drawn = job.situation(config)
    recording = record_answer(source, posture, job.seed, varied, observer)
    return job_result(job, posture, drawn, recording.outcome)


def record_answer(
    source: Policy,
    posture: Posture,
    seed: int,
    config: EpisodeConfig,
    observer: Observer | None = None,
) -> Recording:
    """As `record`; a policy that gives no answer has failed, or abstained."""
    try:
        return record(source, posture, seed, config, observer)
    except Abstained as error:
        return Recording(Outcome(False, abstained=str(error)), None, None, np.empty((0, 3)))
    except PolicyError as error:
        outcome = Outcome(False, (UNANSWERED.unanswered(str(error)),))
        return Recording(outcome, None, None, np.empty((0, 3)))


def job_result(
    job: Job,
    posture: Posture,
    drawn: Mapping[str, Any],
    outcome: Outcome,
    extra: Mapping[str, Json] | None = None,
) -> EpisodeResult:
    """What became of a job: the arm after variation, what was drawn for it, and the verdict."""
    return EpisodeResult(
        job.index, job.entry, posture, job.demonstration_set, job.seed, drawn, outcome, extra or {}
    )


@dataclass(frozen=True, slots=True)
class Work:
    """What workers are asked to do; functions of modules, as other processes must find them."""

    demonstrate: Callable[..., Demonstration] = record_demonstration  # as `record_demonstration`
    fit: Callable[..., Policy] = fit_policy  # as `fit_policy`
    dress: Callable[..., EpisodeResult] = dress_job  # as `dress_job`
    prepare: Callable[[], None] | None = None  # one worker does it while others demonstrate


def record_demonstrations(
    folder: RunFolder, workers: Workers, progress: Progress = silent, work: Work | None = None
) -> dict[tuple[str, int], list[Demonstration]]:
    """Demonstrations by name and set; those in the folder are loaded, the others recorded into it.

    Raises:
        DressingSimError: A demonstration failed, or a worker died twice under it.
    """
    plan, work = folder.plan, work or Work()
    wanted = _demonstrated(plan)
    missing = [place for place in wanted if not folder.demonstration_file(*place).exists()]
    done = len(wanted) - len(missing)
    if wanted:
        progress("demonstrations", done, len(wanted), "")
    if missing and work.prepare is not None and workers.count > 1:
        workers.submit(work.prepare)
    calls = ((place, (plan.seed, *place[:2], plan.config, place[2])) for place in missing)
    for place, future in completed(workers, work.demonstrate, calls):
        demonstration = _value(future, f"demonstrating on posture {place[0].name!r}")
        save_demonstrations(folder.demonstration_file(*place), [demonstration])
        done += 1
        progress("demonstrations", done, len(wanted), "")
    # Fresh ones are read back too, so that a resumed run learns from the same bits.
    recorded = {place: folder.load_demonstration(*place) for place in wanted}
    return {
        (name, number): [recorded[posture, number, style_of(name)] for posture in suite]
        for name, suite in plan.demonstrated.items()
        for number in range(plan.protocol.demonstration_sets)
        if name not in plan.own
    } | {(name, 0): load_demonstrations(folder.own_file(name)) for name in plan.own}


def repeated_demonstrations(folder: RunFolder) -> list[dict[str, Any]]:
    """Demonstrations of a run that needed more than one attempt, as their seeds tell."""
    found = []
    for place in _demonstrated(folder.plan):
        posture, number, style = place
        seeds = [demonstration_seed(folder.plan.seed, posture, number, n) for n in range(ATTEMPTS)]
        seed = folder.load_demonstration(*place).seed
        if seed in seeds[1:]:
            attempts = seeds.index(seed) + 1
            told = {"posture": posture.name, "demonstration_set": number, "attempts": attempts}
            found.append({**told, "style": style} if style else told)
    return found


#: A demonstration of a run: the posture, the set, and the operator's style.
_Place: TypeAlias = tuple[Posture, int, str]


def _demonstrated(plan: Plan) -> list[_Place]:
    """All of a run; a posture that is in two suites is demonstrated once a set and style."""
    suites = {name: suite for name, suite in plan.demonstrated.items() if name not in plan.own}
    taught = dict.fromkeys(
        (posture, style_of(name)) for name, suite in suites.items() for posture in suite
    )
    sets = range(plan.protocol.demonstration_sets)
    return [(posture, n, style) for n in sets for posture, style in taught]


#: What a fitted policy depends on: its name, the demonstrations' name, and their set.
Learned: TypeAlias = tuple[str, str | None, int]


def learned_by(job: Job) -> Learned:
    """What the policy of a job depends on."""
    return job.entry.policy, job.entry.demonstrations, job.demonstration_set


def learned_sources(
    folder: OpenRun, jobs: Iterable[Job], workers: Workers, progress: Progress, work: Work
) -> dict[Learned, Policy]:
    """What dresses in each of the jobs, once all is demonstrated and learned.

    Raises:
        DressingSimError: A demonstration failed, so nothing can be learned from it, or a worker
            died twice under a demonstration or while a policy learned.
    """
    recorded = record_demonstrations(folder, workers, progress, work)
    sources: dict[Learned, Policy] = {}
    calls = {}
    for job in jobs:
        key = policy, demonstrations, number = learned_by(job)
        if demonstrations is None:
            sources[key] = hosted_policy(policy)
        else:
            seed = fitting_seed(folder.plan.seed, job.entry, number)
            limits = folder.plan.policy_limits
            calls[key] = policy, seed, recorded[demonstrations, number], limits, folder.policy_log
    if calls:
        progress("policies", 0, len(calls), "")
    for done, (key, future) in enumerate(completed(workers, work.fit, calls.items()), start=1):
        sources[key] = _value(future, f"fitting policy {key[0]!r} to {key[1]}")
        progress("policies", done, len(calls), "")
    return sources


def learned_source(folder: RunFolder, job: Job, work: Work | None = None) -> Policy:
    """What dresses in a job of a run: the operator, or the policy as it was, learned again."""
    if job.entry.demonstrations is None:
        return hosted_policy(job.entry.policy)
    seed = fitting_seed(folder.plan.seed, job.entry, job.demonstration_set)
    limits, fit = folder.plan.policy_limits, (work or Work()).fit
    demonstrations = learned_from(folder, job.entry.demonstrations, job.demonstration_set)
    return fit(job.entry.policy, seed, demonstrations, limits, folder.policy_log)


def learned_from(folder: RunFolder, suite: str, demonstration_set: int) -> list[Demonstration]:
    """Demonstrations of a run, by the name that its rows use and their set."""
    if suite in folder.plan.own:
        return load_demonstrations(folder.own_file(suite))
    style, postures = style_of(suite), folder.plan.demonstrated[suite]
    return [folder.load_demonstration(posture, demonstration_set, style) for posture in postures]


def _value(future: Future[T], doing: str) -> T:
    try:
        return future.result()
    except WorkerDied as death:
        raise DressingSimError(f"{doing}: {death}") from death
