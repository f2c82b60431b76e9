"""How verdicts hang on the thresholds of success.

Each episode is simulated once, on after limits were exceeded, and judged many times, each time with
one threshold changed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace

import numpy as np
from numpy.typing import NDArray

from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.run.plan import Job
from dressing_sim.benchmark.run.runner import job_result
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.record import Observer, record
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rules import Thresholds, judge, stopped
from dressing_sim.learning import Policy
from dressing_sim.policies.registry import EXPERT
from dressing_sim.world.simulation import World
from dressing_sim.world.strain import StrainGauge

#: What each threshold is multiplied by.
FACTORS = (0.5, 0.65, 0.8, 0.9, 1.0, 1.1, 1.2, 1.35, 1.5)

#: A threshold is acceptable if no factor from the first to the second turns the ranking of two
#: rows round beyond their intervals.
TOLERATED = (0.8, 1.2)

PROTOCOL = Protocol(
    "thresholds",
    "val50",
    (
        Entry(EXPERT),
        Entry("tp-gmm", "case_a"),
        Entry("tp-gmm-rf", "case_a"),
        Entry("tp-gmm-rf-noise", "case_a"),
        Entry("tp-gmm", "case_b"),
        Entry("tp-gmm-rf-noise", "case_b"),
        Entry("tp-gmm", "baseline7"),
    ),
    demonstration_sets=5,
)

#: Thresholds that are scaled as a distance from here: the shoulder, and all of the cloth [%].
_ORIGINS: Mapping[str, float] = {"armscye_s": 2.0, "strain_percentile": 100.0}

NAMES = tuple(field.name for field in fields(Thresholds))


def scaled(rules: Thresholds, name: str, factor: float) -> Thresholds:
    """The rules with one threshold multiplied.

    Of ``armscye_s`` the distance to the shoulder at s = 2 is multiplied, of ``strain_percentile``
    the part of the cloth that is not judged.
    """
    origin = _ORIGINS.get(name, 0.0)
    return replace(rules, **{name: origin + factor * (getattr(rules, name) - origin)})


def variants(rules: Thresholds) -> Iterator[tuple[str, float, Thresholds]]:
    """Each threshold, each factor, and the rules with this one changed."""
    for name in NAMES:
        for factor in FACTORS:
            yield name, factor, scaled(rules, name, factor)


class StrainReader:
    """An observer of an episode that reads strain at several percentiles of the cloth's area.

    A trace holds strain at one percentile only.

    Args:
        percentiles: Which ones [%].
    """

    def __init__(self, percentiles: Sequence[float]) -> None:
        self._percentiles = tuple(dict.fromkeys(percentiles))
        self._gauge: StrainGauge | None = None
        self._rows: list[list[float]] = []

    def __call__(self, world: World) -> None:
        """Read strain now."""
        self._gauge = self._gauge or StrainGauge(world.mesh)
        strain = self._gauge.principal(world.cloth)
        self._rows.append([self._gauge.percentile(strain, p) for p in self._percentiles])

    @property
    def columns(self) -> dict[float, NDArray[np.float64]]:
        """Strain after each control step, shape (n,), by percentile."""
        rows = np.array(self._rows).reshape(-1, len(self._percentiles))
        return dict(zip(self._percentiles, rows.T, strict=True))


def verdicts(
    recording: Recording,
    shoulder: NDArray[np.float64],
    rules: Thresholds,
    strain: Mapping[float, NDArray[np.float64]],
) -> dict[str, float]:
    """Judge one episode under every variant of the rules.

    Args:
        recording: An episode that is not void, and that no exceeded limit ended.
        shoulder: Shoulder joint (3,), in the robot's base frame [m].
        rules: The thresholds it was recorded with.
        strain: Strain after each control step, shape (n,), by percentile.

    Returns:
        1 for a success, else 0, by `verdict_name`; 0 throughout if the robot never moved. Left out
        are variants that would not have stopped the robot before the simulation broke down.
    """
    trace = recording.trace
    found = {}
    for name, factor, variant in variants(rules):
        success = False
        if trace is not None:
            known = replace(trace, strain=strain[variant.strain_percentile])
            if recording.broke is not None and stopped(known, variant) is None:
                continue
            success = judge(known, shoulder, recording.finished, variant).success
        found[verdict_name(name, factor)] = float(success)
    return found


def verdict_name(name: str, factor: float) -> str:
    """What the verdict with a threshold multiplied is called among an episode's figures."""
    return f"success with {name} x {factor:g}"


def dress_job(
    source: Policy, job: Job, config: EpisodeConfig, observer: Observer | None = None
) -> EpisodeResult:
    """Run one episode; its figures hold the verdicts under every variant of the rules."""
    posture, varied, drawn = job.situation(config)
    rules = varied.thresholds
    reader = StrainReader([variant.strain_percentile for *_, variant in variants(rules)])

    def observe(world: World) -> None:
        reader(world)
        if observer is not None:
            observer(world)

    recording = record(source, posture, job.seed, varied, observe)
    outcome = recording.outcome
    if outcome.invalid is None:
        judged = verdicts(recording, posture.shoulder, rules, reader.columns)
        outcome = replace(outcome, metrics={**outcome.metrics, **judged})
    return job_result(job, posture, drawn, outcome)
