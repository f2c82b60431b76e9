"""The study of confidence: whether policies know when they will fail.

Two finished runs of the same rows are read: one on training postures, which calibrates a judge for
each row, and one on others, on which the judges are tried. Policies learn again from the runs' own
demonstrations and make their paths again; nothing is simulated.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.benchmark.analysis.episodes import Rate
from dressing_sim.benchmark.analysis.forecasts import Forecasts, surest
from dressing_sim.benchmark.records import Entry, Json, Protocol
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.executors import Workers
from dressing_sim.benchmark.run.folder import EPISODES
from dressing_sim.benchmark.run.lines import parse_episode
from dressing_sim.benchmark.run.plan import Job, Plan
from dressing_sim.benchmark.run.progress import Progress
from dressing_sim.benchmark.run.runner import learned_from, learned_source
from dressing_sim.benchmark.run.store import OpenRun, RunFolder, load_run
from dressing_sim.benchmark.studies.confidence_document import confidence_document
from dressing_sim.benchmark.studies.study import Calls, Study, Summary
from dressing_sim.episode.record import DEFAULT_PATH_DT
from dressing_sim.episode.rules import UNANSWERED
from dressing_sim.errors import InvalidInputError, PolicyError
from dressing_sim.learning import Policy
from dressing_sim.learning.calibration import calibrated
from dressing_sim.path import policy_path
from dressing_sim.policies.confidence import FEATURES, Judge, PathFeatures
from dressing_sim.provenance import versions
from dressing_sim.world.scene import grip_start

#: What a run is for.
Part = Literal["training", "tested"]
PARTS: tuple[Part, ...] = ("training", "tested")

#: Shares of episodes of which the summary says how many of the surest succeed.
SHARES = (1.0, 0.9, 0.75, 0.5)

#: Seed of the bootstrap: the same episodes give the same summary.
_BOOTSTRAP_SEED = 0


@dataclass(frozen=True, slots=True)
class Seen:
    """An episode of a run, and what a judge looks at in it.

    Attributes:
        index: Its place in its run.
        success: Whether it was dressed.
        features: See `FEATURES`; none where the policy gave no answer.
    """

    index: int
    success: bool
    features: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Looking:
    """The paths of a policy to be looked at, and what was seen once they are.

    Attributes:
        index: Its place: rows by part and demonstration set.
        entry: Row of the protocol.
        part: Which of the two runs it is in.
        demonstration_set: What the policy learned from there.
        episodes: What was seen; void episodes are left out.
    """

    index: int
    entry: Entry
    part: Part
    demonstration_set: int
    episodes: tuple[Seen, ...] = ()


def confidence_plan(training: Path, tested: Path) -> Plan:
    """The plan of the study: the rows that both runs have and that learned something.

    Args:
        training: Folder of a finished run, on postures for training.
        tested: Folder of a finished run on other postures.

    Raises:
        InvalidInputError: No runs there, unfinished ones, ones with a posture in common, or without
            a common row.
    """
    runs = [load_run(training), load_run(tested)]
    for run in runs:
        if len(run.finished) < len(run.plan.jobs):
            raise InvalidInputError(
                f"{run.path}: has {len(run.finished)} of {len(run.plan.jobs)} episodes; valid is a "
                "finished run of policies that dress"
            )
    plans = [run.plan for run in runs]
    known = {_angles(posture): posture.name for posture in plans[0].tested}
    for posture in plans[1].tested:
        if _angles(posture) in known:
            raise InvalidInputError(
                f"{tested}: posture {posture.name!r} is in {training} too; valid is a run on "
                "postures that no judge was calibrated on"
            )
    both = [e for e in plans[1].protocol.entries if e in plans[0].protocol.entries]
    entries = tuple(entry for entry in both if entry.demonstrations is not None)
    if not entries:
        raise InvalidInputError(
            f"{tested} and {training} have no row in common that learned; valid are two runs of "
            "the same policies on the same demonstrations"
        )
    parts = dict(zip(PARTS, runs, strict=True))
    options: dict[str, Json] = {
        "folders": {part: str(run.path) for part, run in parts.items()},
        "suites": {part: run.plan.protocol.suite for part, run in parts.items()},
        "sha256": {
            part: hashlib.sha256((run.path / EPISODES).read_bytes()).hexdigest()
            for part, run in parts.items()
        },
    }
    suite = plans[1].protocol.suite
    protocol = Protocol("confidence", suite, entries, study="confidence")
    return replace(plans[1], protocol=protocol, options=options, own={}, own_files={})


def _angles(posture: Posture) -> tuple[float, ...]:
    return tuple(np.concatenate([posture.shoulder, posture.elbow, posture.wrist]).tolist())


def look(job: Looking, folder: Path) -> Looking:
    """Let a policy of a run learn and make its paths again, and look at them."""
    run, shown = load_run(folder), job.entry.demonstrations
    assert shown is not None
    jobs = [
        one
        for one in run.plan.jobs
        if one.entry == job.entry and one.demonstration_set == job.demonstration_set
    ]
    source = learned_source(run, jobs[0]) if jobs else None
    if source is None or callable(getattr(source, "act", None)):
        return job
    features = PathFeatures(learned_from(run, shown, job.demonstration_set))
    return replace(job, episodes=tuple(_seen(run, jobs, source, features)))


def _seen(
    run: RunFolder, jobs: Sequence[Job], source: Policy, features: PathFeatures
) -> Iterator[Seen]:
    for job in jobs:
        outcome = parse_episode(run.plan, run.line(job.index)).outcome
        if outcome.invalid is not None:
            continue
        if UNANSWERED.name in outcome.reasons or outcome.abstained is not None:
            yield Seen(job.index, outcome.success, ())  # whatever it would answer now
            continue
        posture, config, _ = job.situation(run.plan.config)
        start = grip_start(posture, config.world.sleeve)
        try:
            path = policy_path(source, posture, start, job.seed, DEFAULT_PATH_DT, config.time_limit)
        except PolicyError:
            yield Seen(job.index, outcome.success, ())
            continue
        found = features.of(posture.frames(), path.positions)
        yield Seen(job.index, outcome.success, tuple(found.tolist()))


@dataclass(frozen=True)
class Confidence(Study[Looking, Looking]):
    """How good a calibrated probability of success is, and what abstaining by it is worth."""

    stage = "policies"
    result = Looking

    def jobs(self, plan: Plan) -> Sequence[Looking]:
        """Each row with each demonstration set of each of the two runs."""
        sets = {part: load_run(_folder(plan, part)).plan.protocol for part in PARTS}
        places = [
            (entry, part, number)
            for entry in plan.protocol.entries
            for part in PARTS
            for number in range(sets[part].demonstration_sets)
        ]
        return [Looking(index, *place) for index, place in enumerate(places)]

    def calls(
        self, folder: OpenRun, jobs: Sequence[Looking], workers: Workers, progress: Progress
    ) -> Calls[Looking, Looking]:
        """Each job is a policy that learns and makes its paths."""
        return look, ((job, (job, _folder(folder.plan, job.part))) for job in jobs)

    def summarise(self, folder: RunFolder, results: Sequence[Looking]) -> dict[str, Any]:
        """What each row's judge is worth on the tested run.

        Returns:
            ``{"rows": [...], "left_out", "versions", "config"}``. A row has its entry's values,
            ``n_training``, ``pc_training``, ``n_episodes``, ``n_success``, ``pc_success``,
            ``pc_success_ci95``, ``n_unanswered``, ``brier`` with its ``miscalibration``,
            ``discrimination`` and ``uncertainty``, ``gain`` over telling the success rate in
            training and ``gain_ci95``, ``bins`` and ``coverage`` as from `Forecasts`, ``surest``
            (the best shares of `SHARES`) and ``judge``, as `Judge.to_dict`. Episodes without an
            answer are left out but counted.
            Rows without enough paths, such as of policies in closed loop, stand in ``left_out``.

        Raises:
            InvalidInputError: No row has enough paths.
        """
        plan = folder.plan
        suites = plan.options["suites"]
        assert isinstance(suites, dict)
        source = f"{suites['training']}, seed {plan.seed}"
        rows, left_out = [], []
        for entry in plan.protocol.entries:
            training, tested = (
                [
                    seen
                    for result in results
                    if result.entry == entry and result.part == part
                    for seen in result.episodes
                ]
                for part in PARTS
            )
            try:
                rows.append({**entry.to_dict(), **row_of(entry, training, tested, source)})
            except InvalidInputError as error:
                left_out.append(str(error))
        if not rows:
            raise InvalidInputError(left_out[0])
        return {
            "rows": rows,
            "left_out": left_out,
            "versions": versions(),
            "config": dict(plan.options),
        }

    def document(
        self, folder: RunFolder, results: Sequence[Looking], summary: Summary, command: str
    ) -> Document:
        """A table, a reliability diagram and a curve of success against coverage."""
        return confidence_document(summary, command)


def _folder(plan: Plan, part: Part) -> Path:
    folders = plan.options["folders"]
    assert isinstance(folders, dict)
    return Path(str(folders[part]))


def row_of(
    entry: Entry, training: Sequence[Seen], tested: Sequence[Seen], source: str
) -> dict[str, Any]:
    """Calibrate a judge on the training episodes and try it on the tested ones.

    Raises:
        InvalidInputError: Fewer than two episodes to calibrate on, or none to try it on.
    """
    known, asked = ([seen for seen in part if len(seen.features)] for part in (training, tested))
    if len(known) < 2 or not asked:
        raise InvalidInputError(
            f"row {entry.label}: has {len(known)} training and {len(asked)} tested episodes with a "
            "path; valid is 2 or more, and 1 or more"
        )
    happened = [seen.success for seen in known]
    judge = Judge(
        entry.policy,
        entry.demonstrations or "",
        calibrated(_matrix(known), happened),
        len(known),
        source,
    )
    forecasts = Forecasts.of(
        judge.model.probability(_matrix(asked)), [seen.success for seen in asked]
    )
    before, rate = Rate.of(happened), Rate.of(forecasts.successes.tolist())
    gain = forecasts.gain(before.n_success / before.n, np.random.default_rng(_BOOTSTRAP_SEED))
    parts, covered = forecasts.decomposition, forecasts.coverage()
    return {
        "n_training": before.n,
        "pc_training": before.percent,
        "n_episodes": rate.n,
        "n_success": rate.n_success,
        "pc_success": rate.percent,
        "pc_success_ci95": list(rate.interval),
        "n_unanswered": len(tested) - len(asked),
        "brier": forecasts.brier,
        "miscalibration": parts.miscalibration,
        "discrimination": parts.discrimination,
        "uncertainty": parts.uncertainty,
        "gain": gain.value,
        "gain_ci95": list(gain.interval),
        "bins": [one.to_dict() for one in forecasts.bins()],
        "coverage": [one.to_dict() for one in covered],
        "surest": [{"share": s, **surest(covered, s).to_dict()} for s in SHARES],
        "judge": judge.to_dict(),
    }


def _matrix(episodes: Sequence[Seen]) -> NDArray[np.float64]:
    """Features, (n, D)."""
    return np.array([seen.features for seen in episodes]).reshape(-1, len(FEATURES))
