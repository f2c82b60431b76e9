"""The study of agreement: do policies' verdicts come from the arm and the cloth, or from the mesh?

Policies dress in the default world; the same joint commands are played again in the reference, a
world with a finer mesh and a shorter step. What differs is the simulation alone.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from dressing_sim.arm import Posture
from dressing_sim.benchmark.analysis.statistics import mcnemar_p, wilson_interval
from dressing_sim.benchmark.records import Entry, EpisodeResult, Json, Protocol
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.lines import parse_outcome
from dressing_sim.benchmark.run.plan import Job, Plan, make_plan
from dressing_sim.benchmark.run.runner import Work, job_result, record_answer
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.benchmark.studies.agreement_document import agreement_document
from dressing_sim.benchmark.studies.study import EpisodeStudy, Summary
from dressing_sim.config import to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rollout import Observer, play
from dressing_sim.episode.rule import Evidence
from dressing_sim.episode.rules import RULES
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Policy
from dressing_sim.provenance import versions
from dressing_sim.suites.suites import load_suite

#: Rows of the paper that are compared: with and without augmentation, and the baseline.
ENTRIES = (
    Entry("tp-gmm", "case_a"),
    Entry("tp-gmm-rf", "case_a"),
    Entry("tp-gmm-rf-noise", "case_a"),
    Entry("tp-gmm-rf", "case_b"),
    Entry("tp-gmm", "baseline7"),
)

#: Postures of the studies of the simulation, from the first of the suite.
N_POSTURES = 15

#: The least share of verdicts in which the default world must agree with a finer one.
REQUIRED_AGREEMENT = 0.95

#: How far the reference itself is from the limit of fine meshes, by the rules whose margins hang
#: on the cloth; see docs/convergence.md.
REFERENCE_ERROR: Mapping[str, float] = {"over_force": 0.5, "over_strain": 0.01}

#: What an episode carries beyond its outcome.
REFERENCE, MARGIN, SECONDS = "reference", "reference_margin", "seconds"


def reference(config: EpisodeConfig) -> EpisodeConfig:
    """The same with a finer mesh, half the physics step and a solver that has converged.

    A contact heals in as many steps, so that its lift by friction is halved too.
    """
    world = config.world
    sleeve = replace(
        world.sleeve,
        edge=0.75 * world.sleeve.edge,
        contact_time=0.5 * world.sleeve.contact_time,
    )
    solver = replace(world.solver, timestep=0.5 * world.solver.timestep, tolerance=1e-12)
    return replace(config, world=replace(world, sleeve=sleeve, solver=solver))


def agreement_plan(suite: str = "val50", postures: int | None = None, seed: int = 0) -> Plan:
    """The plan of the study: every row of `ENTRIES` on the first of a suite's postures."""
    tested = first_postures(suite, postures)
    plan = make_plan(Protocol("agreement", suite, ENTRIES, study="agreement"), seed)
    return replace(plan, tested=tested)


def first_postures(suite: str, postures: int | None) -> tuple[Posture, ...]:
    """The first postures of a suite, `N_POSTURES` unless given.

    Raises:
        InvalidInputError: There is no such suite, or it has fewer.
    """
    arms = load_suite(suite)
    if postures is not None and not 1 <= postures <= len(arms):
        raise InvalidInputError(
            f"postures is {postures}, valid is 1 to {len(arms)}, as many as suite {suite!r} has"
        )
    return tuple(arms[: N_POSTURES if postures is None else postures])


def dress_twice(
    source: Policy, job: Job, config: EpisodeConfig, observer: Observer | None = None
) -> EpisodeResult:
    """Run one episode in the default world, and its commands in the reference."""
    posture, varied, drawn = job.situation(config)
    begun = time.process_time()
    recording = again = record_answer(source, posture, job.seed, varied, observer)
    seconds = [time.process_time() - begun]
    if recording.trajectory is not None:
        begun = time.process_time()
        again = play(Dressing(posture, reference(varied)), recording.trajectory)
        seconds.append(time.process_time() - begun)
    extra: dict[str, Json] = {
        REFERENCE: again.outcome.to_dict(),
        MARGIN: deciding_margin(again, recording, varied.thresholds),
        SECONDS: seconds,
    }
    return job_result(job, posture, drawn, recording.outcome, extra)


def deciding_margin(
    reference: Recording, default: Recording, thresholds: Thresholds
) -> float | None:
    """How near the verdict is to turning, in units of the reference's own error.

    The stop cuts its own margin off, and says nothing of how much harder the cloth would have been
    pulled; then the other world's margin tells, and if the robot was stopped in both, none.
    """
    for recording in (reference, default):
        known = REFERENCE_ERROR.keys()
        if recording.trace is not None and known.isdisjoint(recording.outcome.reasons):
            evidence = Evidence(recording.trace, np.zeros(3), thresholds=thresholds)
            return min(
                abs(rule.margin(evidence)) / REFERENCE_ERROR[rule.name]
                for rule in RULES
                if rule.name in known
            )
    return None


@dataclass(frozen=True)
class Agreement(EpisodeStudy):
    """How often the default world and the reference give the same verdict."""

    work: Work = field(default_factory=lambda: Work(dress=dress_twice))

    def summarise(self, folder: RunFolder, results: Sequence[EpisodeResult]) -> dict[str, Any]:
        """The share of equal verdicts, and which differ."""
        plan = folder.plan
        return {
            "policies": compared(results),
            "rows": [
                {**entry.to_dict(), **compared([r for r in results if r.entry == entry])}
                for entry in plan.protocol.entries
            ],
            "differing": [_difference(result) for result in results if _differs(result)],
            "versions": versions(),
            "config": {
                "suite": plan.protocol.suite,
                "postures": len(plan.tested),
                "seed": plan.seed,
                "episode": to_plain(plan.config),
                "reference": to_plain(reference(plan.config)),
            },
        }

    def document(
        self, folder: RunFolder, results: Sequence[EpisodeResult], summary: Summary, command: str
    ) -> Document:
        """A sentence, a table of rows, and the episodes whose verdicts differ."""
        return agreement_document(results, summary, command)


def compared(results: Sequence[EpisodeResult]) -> dict[str, Any]:
    """How often two verdicts are the same.

    Episodes that are invalid in one of the worlds are counted apart, and so are undecided ones:
    those whose verdict in the reference is nearer to turning than the reference's own error.

    Returns:
        ``{"n_episodes", "n_agree", "agreement", "agreement_ci95", "n_only_default",
        "n_only_reference", "mcnemar_p", "undecided", "n_agree_decided", "n_void", "cost_ratio"}``:
        agreement is of all valid episodes, undecided ones included, from 0 to 1, with its Wilson
        interval; dressed only in the default world or only in the reference, with McNemar's p;
        cost_ratio is that of the CPU times of default and reference.
    """
    valid = [result for result in results if _valid(result)]
    pairs = [(result.outcome.success, _reference(result).success) for result in valid]
    n_agree = sum(a == b for a, b in pairs)
    default, other = sum(a > b for a, b in pairs), sum(a < b for a, b in pairs)
    decided = [_decided(result) for result in valid]
    costs = [result.extra[SECONDS] for result in results]
    twice = [cost for cost in costs if isinstance(cost, Sequence) and len(cost) == 2]
    slower = sum(cost[1] for cost in twice)  # type: ignore[misc]
    return {
        "n_episodes": len(valid),
        "n_success": sum(a for a, _ in pairs),
        "n_success_reference": sum(b for _, b in pairs),
        "n_agree": n_agree,
        "agreement": n_agree / len(valid) if valid else None,
        "agreement_ci95": list(wilson_interval(n_agree, len(valid))),
        "n_only_default": default,
        "n_only_reference": other,
        "mcnemar_p": mcnemar_p(default, other),
        "undecided": sum(not one for one in decided),
        "n_agree_decided": sum(a == b for (a, b), one in zip(pairs, decided, strict=True) if one),
        "n_void": len(results) - len(valid),
        "cost_ratio": sum(cost[0] for cost in twice) / slower if slower else None,  # type: ignore[misc]
    }


def _reference(result: EpisodeResult) -> Any:
    return parse_outcome(result.extra[REFERENCE])  # type: ignore[arg-type]


def _valid(result: EpisodeResult) -> bool:
    return result.outcome.invalid is None and _reference(result).invalid is None


def _decided(result: EpisodeResult) -> bool:
    margin = result.extra[MARGIN]
    return not isinstance(margin, float) or margin >= 1.0


def _differs(result: EpisodeResult) -> bool:
    return _valid(result) and result.outcome.success != _reference(result).success


def _difference(result: EpisodeResult) -> dict[str, Any]:
    other = _reference(result)
    return {
        **result.entry.to_dict(),
        "posture": result.posture.name,
        "default": list(result.outcome.reasons),
        "reference": list(other.reasons),
        "grip_force": [one.metrics.get("grip_force") for one in (result.outcome, other)],
        "strain": [one.metrics.get("strain") for one in (result.outcome, other)],
        "decided": _decided(result),
    }
