"""Whether a submitted result comes out again: some of its episodes, drawn at random, are rerun."""

from __future__ import annotations

import math
import secrets
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dressing_sim.benchmark.run.agreement import Agreement
from dressing_sim.benchmark.run.executors import WorkerDied, Workers, completed
from dressing_sim.benchmark.run.origin import Origin
from dressing_sim.benchmark.run.progress import Progress, silent
from dressing_sim.benchmark.run.replay import replay_episode
from dressing_sim.benchmark.run.runner import learned_from, record_demonstrations
from dressing_sim.benchmark.run.store import RunFolder, load_run
from dressing_sim.benchmark.scoreboard.rules import others_policies
from dressing_sim.benchmark.scoreboard.submission import Submission, taught_digest
from dressing_sim.benchmark.studies import find_study
from dressing_sim.benchmark.studies.study import EpisodeStudy
from dressing_sim.checks import real_number, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.inputs import inputs_of
from dressing_sim.numerics import numerics
from dressing_sim.policies.hosted import hosted_policy

#: So many episodes are run again at least, if there are as many: of a tenth of few, chance alone
#: would hide much.
FEWEST = 10


@dataclass(frozen=True, slots=True)
class Verification:
    """How a submitted result compares with what came out now.

    Attributes:
        n_episodes: How many it has.
        tried: Indices of those that were run again.
        seed: With which they were drawn.
        differing: Where it differs, lines by what they are about; empty if it was reproduced.
        identical: Whether every bit of the episodes is the same.
        largest: The largest difference of two numbers in relation to their size.
        numerics: In what these differ from the recorded ones; empty if they do not.
        changed: What has other code now, a line each.
    """

    n_episodes: int
    tried: tuple[int, ...]
    seed: int
    differing: Mapping[str, Sequence[str]]
    identical: bool
    largest: float
    numerics: str
    changed: Sequence[str]

    @property
    def holds(self) -> bool:
        """Whether it was reproduced."""
        return not self.differing

    def told(self) -> str:
        """In one sentence."""
        drawn = f"of {len(self.tried)} episodes run again, drawn from {self.n_episodes} with seed"
        if not self.holds:
            return f"not reproduced: {drawn} {self.seed}, or what they need: {self._names()} differ"
        same = "is as recorded, to the bit"
        if not self.identical:
            same = (
                f"has its verdict again, and its numbers within {self.largest:.1g} of their size "
                f"(other numerics: {self.numerics})"
            )
        return f"verified: {drawn} {self.seed}, each {same}"

    def _names(self) -> str:
        names = list(self.differing)
        return ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {
            "verified": self.holds,
            "identical": self.identical,
            "n_episodes": self.n_episodes,
            "tried": list(self.tried),
            "seed": self.seed,
            "differing": {name: list(lines) for name, lines in self.differing.items()},
            "largest_difference": self.largest,
            "numerics": self.numerics,
            "changed": list(self.changed),
        }


def verify(
    submission: Submission,
    workers: Workers,
    *,
    share: float = 0.1,
    seed: int | None = None,
    trust: bool = False,
    fewest: int = FEWEST,
    progress: Progress = silent,
) -> Verification:
    """Record the demonstrations again, let the policies learn, and run some episodes again.

    Args:
        submission: What is verified.
        workers: Where episodes run.
        share: How many of its episodes, from 0 to 1.
        seed: With which they are drawn; one that nobody can foresee if None.
        trust: Whether other people's policies may be imported, which is to run their code.
        fewest: So many at least, if there are as many.
        progress: Told after each demonstration and each episode.

    Raises:
        InvalidInputError: An argument is not valid, or a policy is not installed or not trusted.
        DressingSimError: A demonstration failed.
    """
    real_number(share, "share", 0.0, 1.0)
    chosen = secrets.randbits(32) if seed is None else whole_number(seed, "seed")
    theirs = others_policies(submission.run.plan)
    if theirs and not trust:
        raise InvalidInputError(
            f"policy {theirs[0]} is other people's code, from {submission.statement.package}; "
            "read it, install it, and add --trust"
        )
    study = find_study("success")
    assert isinstance(study, EpisodeStudy)
    with submission.unpacked() as run:
        differing = dict(_other_classes(run, submission.statement.package))
        record_demonstrations(run, workers, progress, study.work)
        other = run.origin.other_numerics(numerics())
        differing |= dict(_other_demonstrations(run, submission, other))
        n = len(run.finished)
        size = min(n, max(fewest, math.ceil(share * n)))
        drawn = np.random.default_rng(chosen).choice(n, size, replace=False)
        tried = tuple(sorted(drawn.tolist()))
        again = _run_again(run, tried, workers, progress)
        for index in tried:
            job, agreement = run.plan.jobs[index], again[index]
            if not agreement.holds:
                name = f"episode {index} ({job.entry.label}, {job.posture.name})"
                differing[name] = agreement.beyond
        changed = run.origin.changed(Origin.here(run.plan, numerics()))
    return Verification(
        n_episodes=n,
        tried=tried,
        seed=chosen,
        differing=differing,
        identical=not any(one.differences for one in again.values()),
        largest=max((one.largest for one in again.values()), default=0.0),
        numerics=other,
        changed=changed,
    )


def _run_again(
    run: RunFolder, tried: Sequence[int], workers: Workers, progress: Progress
) -> dict[int, Agreement]:
    """How episodes compare with their lines, by index."""
    found: dict[int, Agreement] = {}
    calls = ((index, (run.path, index)) for index in tried)
    for done, (index, future) in enumerate(completed(workers, _again, calls), start=1):
        try:
            found[index] = future.result()
        except WorkerDied as death:
            found[index] = Agreement([str(death)], [str(death)], 0.0, "")
        progress("episodes", done, len(tried), "")
    return found


def _again(folder: Path, index: int) -> Agreement:
    """How an episode of a run comes out in this process."""
    run = load_run(folder)
    return replay_episode(find_study(run.plan.protocol.study), run, index).agreement


def _other_classes(run: RunFolder, package: str) -> Iterator[tuple[str, list[str]]]:
    """Policies that are asked with more, or less, than their row says."""
    for entry in run.plan.protocol.entries:
        try:
            found = inputs_of(hosted_policy(entry.policy, limits=run.plan.policy_limits))
        except InvalidInputError as error:
            raise InvalidInputError(f"{error}; is {package} installed?") from error
        if found != entry.inputs:
            yield f"inputs of {entry.policy}", [f"{entry.inputs} recorded, {found} now"]


def _other_demonstrations(
    run: RunFolder, submission: Submission, other: str
) -> Iterator[tuple[str, list[str]]]:
    """Demonstrations that are not those that were learned from."""
    for name, taught in submission.demonstrations.items():
        if name in run.plan.own:
            arms = tuple(one.posture for one in learned_from(run, name, 0))
            if arms != run.plan.demonstrated[name]:
                yield f"demonstrations {name}", ["postures are not those of config"]
        elif other:  # the last bits may differ; whether that matters the episodes tell
            continue
        now = taught_digest(run, name)
        if now != taught.sha256:
            yield f"demonstrations {name}", [f"sha256: {taught.sha256} recorded, {now} now"]
