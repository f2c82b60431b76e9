"""The study of agreement: do policies' verdicts come from the arm and the cloth, or from the mesh?

Policies dress in the default world; the same joint commands are played again in the reference, a
world with a finer mesh and a shorter step. What differs is the simulation alone.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from dressing_sim.arm import Posture
from dressing_sim.benchmark.analysis.statistics import mcnemar_p, wilson_interval
from dressing_sim.benchmark.records import Entry, EpisodeResult, Json, Protocol
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.lines import parse_outcome
from dressing_sim.benchmark.run.plan import Job, Plan, dressing_person, make_plan
from dressing_sim.benchmark.run.runner import Work, job_result, record_answer
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.benchmark.studies.agreement_document import agreement_document
from dressing_sim.benchmark.studies.study import EpisodeStudy, Summary
from dressing_sim.checks import of_kind
from dressing_sim.config import to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.judge import margins
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rollout import Observer, play
from dressing_sim.episode.rule import Evidence
from dressing_sim.episode.rules import RULES
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Policy
from dressing_sim.provenance import versions
from dressing_sim.suites.suites import load_suite
from dressing_sim.suites.wardrobe import world_with

#: Rows of the paper that are compared: with and without augmentation, and the baseline.
ENTRIES = (
    Entry("tp-gmm", "case_a"),
    Entry("tp-gmm-rf", "case_a"),
    Entry("tp-gmm-rf-noise", "case_a"),
    Entry("tp-gmm-rf", "case_b"),
    Entry("tp-gmm", "baseline7"),
)

#: Postures of the studies of the simulation unless others are named: the first of a suite.
SUITE, N_POSTURES = "val50", 15

#: The least share of verdicts in which the default world must agree with a finer one.
REQUIRED_AGREEMENT = 0.95

#: Rules whose margins hang on the cloth; the others' hang on the robot, which moves alike.
CLOTH_RULES = tuple(rule for rule in RULES if rule.name in ("stuck", "over_strain", "over_force"))

#: The reference's edges and physics step, by the default's. Coarser worlds that tell its error have
#: the default's edges, or the default's step.
FINE, SHORT = 6.0 / 7.0, 0.5

#: Richardson's estimates of what is left of the reference's error, by how much a coarser world
#: differs from it (Roache 1998): the error falls with the square of the edges, and with the step.
LEFT_OF_MESH = 1.0 / (FINE**-2 - 1.0)
LEFT_OF_STEP = 1.0 / (1.0 / SHORT - 1.0)

#: What an episode carries beyond its outcome.
REFERENCE, DECIDED, SECONDS = "reference", "decided", "seconds"


def reference(config: EpisodeConfig, edge: float = FINE, step: float = SHORT) -> EpisodeConfig:
    """The same with a finer mesh, a shorter physics step, and a solver that has converged.

    A contact heals in as many steps, so its lift by friction goes with the step.

    Args:
        config: The default world's.
        edge: Length of the mesh's edges, by the default's.
        step: The physics step, by the default's.
    """
    world = config.world
    sleeve = replace(
        world.sleeve,
        edge=edge * world.sleeve.edge,
        contact_time=step * world.sleeve.contact_time,
    )
    solver = replace(world.solver, timestep=step * world.solver.timestep, tolerance=1e-12)
    return replace(config, world=replace(world, sleeve=sleeve, solver=solver))


def agreement_plan(
    suite: str = SUITE,
    postures: int | None = None,
    seed: int = 0,
    garment: str | None = None,
    person: str | None = None,
) -> Plan:
    """The plan of the study: every row of `ENTRIES` on the first of a suite's postures.

    Garment and person are names or TOML files, see `load_garment` and `load_person`.
    """
    tested, config = first_postures(suite, postures), world_with(garment)
    plan = make_plan(Protocol("agreement", suite, ENTRIES, study="agreement"), seed, config)
    return dressing_person(replace(plan, tested=tested), person)


def first_postures(suite: str, postures: int | None) -> tuple[Posture, ...]:
    """The first postures of a suite; unless given all, of `SUITE` `N_POSTURES`.

    Raises:
        InvalidInputError: There is no such suite, or it has fewer.
    """
    arms = load_suite(suite)
    if postures is not None and not 1 <= postures <= len(arms):
        raise InvalidInputError(
            f"postures is {postures}, valid is 1 to {len(arms)}, as many as suite {suite!r} has"
        )
    few = N_POSTURES if suite == SUITE else len(arms)
    return tuple(arms[: few if postures is None else postures])


def dress_again(
    source: Policy, job: Job, config: EpisodeConfig, observer: Observer | None = None
) -> EpisodeResult:
    """Run one episode in the default world, and its commands in the reference.

    And, to tell how far the reference can be trusted, on a coarser mesh and with a longer step.
    """
    posture, varied, drawn = job.situation(config)
    begun = time.process_time()
    recording = fine = record_answer(source, posture, job.seed, varied, observer)
    seconds, sure = [time.process_time() - begun], True
    if recording.trajectory is not None:
        begun = time.process_time()
        fine = play(Dressing(posture, reference(varied)), recording.trajectory)
        seconds.append(time.process_time() - begun)
        worlds = reference(varied, edge=1.0), reference(varied, step=1.0)
        coarse, longer = (play(Dressing(posture, world), recording.trajectory) for world in worlds)
        sure = decided(fine, coarse, longer, varied.thresholds)
    extra: dict[str, Json] = {
        REFERENCE: fine.outcome.to_dict(),
        DECIDED: sure,
        SECONDS: seconds,
    }
    return job_result(job, posture, drawn, recording.outcome, extra)


def decided(fine: Recording, coarse: Recording, longer: Recording, thresholds: Thresholds) -> bool:
    """Whether the reference's verdict is beyond its own error.

    It is not if a coarser mesh or a longer step gives another verdict, nor if a success is nearer
    to one of the cloth's thresholds than Richardson's estimates of both errors together. (The
    margin of a failure is cut off by the protective stop, so it tells nothing.)

    Args:
        fine: Of the reference.
        coarse: On a coarser mesh.
        longer: With twice the step.
        thresholds: Of success.
    """
    if len({one.outcome.success for one in (fine, coarse, longer)}) > 1:
        return False
    if not fine.outcome.success:
        return True
    margin, of_mesh, of_step = (_margins(one, thresholds) for one in (fine, coarse, longer))
    return all(
        margin[name]
        >= LEFT_OF_MESH * abs(margin[name] - of_mesh[name])
        + LEFT_OF_STEP * abs(margin[name] - of_step[name])
        for name in margin
    )


def _margins(recording: Recording, thresholds: Thresholds) -> dict[str, float]:
    assert recording.trace is not None  # of a success
    return margins(Evidence(recording.trace, np.zeros(3), thresholds=thresholds), CLOTH_RULES)


@dataclass(frozen=True)
class Agreement(EpisodeStudy):
    """How often the default world and the reference give the same verdict."""

    work: Work = field(default_factory=lambda: Work(dress=dress_again))

    def other(self, plan: Plan) -> EpisodeConfig:
        """The world that verdicts are compared with."""
        return reference(plan.config)

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
                "reference": to_plain(self.other(plan)),
            },
        }

    def document(
        self, folder: RunFolder, results: Sequence[EpisodeResult], summary: Summary, command: str
    ) -> Document:
        """A sentence, a table of rows, and the episodes whose verdicts differ."""
        return agreement_document(results, summary, command)


def compared(results: Sequence[EpisodeResult]) -> dict[str, Any]:
    """How often two verdicts are the same.

    Episodes that are invalid in one of the worlds are counted apart, and so are undecided ones,
    whose verdict in the reference is within the reference's own error, see `decided`.

    Returns:
        ``{"n_episodes", "n_success", "n_success_reference", "n_agree", "agreement",
        "agreement_ci95", "n_only_default", "n_only_reference", "mcnemar_p", "undecided",
        "agreement_with_undecided", "n_void", "cost_ratio"}``: agreement is the share of the
        n_episodes valid and decided ones, from 0 to 1, with its Wilson interval; dressed only in
        the default world or only in the reference, with McNemar's p; cost_ratio is that of the CPU
        times of default and reference.
    """
    valid = [result for result in results if _valid(result)]
    sure = [result for result in valid if result.extra[DECIDED]]
    pairs = [(result.outcome.success, _reference(result).success) for result in sure]
    n_agree, n_same = len(pairs) - sum(map(_differs, sure)), len(valid) - sum(map(_differs, valid))
    default, other = sum(a > b for a, b in pairs), sum(a < b for a, b in pairs)
    costs = [result.extra[SECONDS] for result in results]
    both = [cost for cost in costs if isinstance(cost, list) and len(cost) == 2]
    here, there = (sum(float(cost[i]) for cost in both) for i in range(2))
    return {
        "n_episodes": len(sure),
        "n_success": sum(a for a, _ in pairs),
        "n_success_reference": sum(b for _, b in pairs),
        "n_agree": n_agree,
        "agreement": n_agree / len(sure) if sure else None,
        "agreement_ci95": list(wilson_interval(n_agree, len(sure))),
        "n_only_default": default,
        "n_only_reference": other,
        "mcnemar_p": mcnemar_p(default, other),
        "undecided": len(valid) - len(sure),
        "agreement_with_undecided": n_same / len(valid) if valid else None,
        "n_void": len(results) - len(valid),
        "cost_ratio": here / there if both else None,
    }


def _reference(result: EpisodeResult) -> Outcome:
    return parse_outcome(of_kind(result.extra[REFERENCE], dict, REFERENCE, "an outcome"))


def _valid(result: EpisodeResult) -> bool:
    return result.outcome.invalid is None and _reference(result).invalid is None


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
        "decided": result.extra[DECIDED],
    }
