"""Verdicts on an episode under every variant of the thresholds of success.

Each episode is simulated once, on after limits were exceeded, and judged many times, each time with
one threshold changed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, replace
from itertools import product
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.benchmark.run.plan import Job
from dressing_sim.benchmark.run.runner import job_result, record_answer
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.judge import judge, stopped
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rollout import Observer
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.learning import Policy
from dressing_sim.world.simulation import World
from dressing_sim.world.strain import StrainGauge

#: What each threshold is multiplied by.
FACTORS = (0.5, 0.65, 0.8, 0.9, 1.0, 1.1, 1.2, 1.35, 1.5, 2.0)

#: A threshold is acceptable if no factor from the first to the second turns the ranking of two
#: rows round beyond their intervals.
TOLERATED = (0.8, 1.2)

#: Thresholds that are scaled as a distance from here: the shoulder, and all of the cloth [%].
_ORIGINS: Mapping[str, float] = {"armscye_s": 2.0, "strain_percentile": 100.0}

#: Success by threshold and by the factor it is multiplied with, as text.
Verdicts: TypeAlias = Mapping[str, Mapping[str, bool]]

#: What they are called among what an episode carries beyond its outcome.
VERDICTS = "verdicts"

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
    for name, factor in product(NAMES, FACTORS):
        yield name, factor, scaled(rules, name, factor)


class StrainReader:
    """An observer of an episode that reads strain at several percentiles of the cloth's area [%].

    A trace holds strain at one percentile only.
    """

    def __init__(self, percentiles: Iterable[float]) -> None:
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
) -> Verdicts:
    """Judge one episode under every variant of the rules.

    Args:
        recording: An episode that is not void, and that no exceeded limit ended.
        shoulder: Shoulder joint (3,), in the robot's base frame [m].
        rules: The thresholds it was recorded with.
        strain: Strain after each control step, shape (n,), by percentile.

    Returns:
        Success by threshold and factor; False throughout if the robot never moved. Left out are
        variants that would not have stopped the robot before the simulation broke down.
    """
    trace = recording.trace
    found: dict[str, dict[str, bool]] = {name: {} for name in NAMES}
    for name, factor, variant in variants(rules):
        success = False
        if trace is not None:
            known = replace(trace, strain=strain[variant.strain_percentile])
            if recording.broke is not None and stopped(known, variant) is None:
                continue
            success = judge(known, shoulder, recording.finished, variant).success
        found[name][f"{factor:g}"] = success
    return found


def verdict_of(result: EpisodeResult, name: str, factor: float) -> bool | None:
    """Success of an episode with a threshold multiplied; None where it is not known."""
    found: Verdicts = result.extra.get(VERDICTS, {})  # type: ignore[assignment]  # from `verdicts`
    return found.get(name, {}).get(f"{factor:g}")


def dress_and_judge(
    source: Policy, job: Job, config: EpisodeConfig, observer: Observer | None = None
) -> EpisodeResult:
    """Run one episode; it carries the verdicts under every variant of the rules."""
    posture, varied, drawn = job.situation(config)
    rules = varied.thresholds
    reader = StrainReader(variant.strain_percentile for *_, variant in variants(rules))

    def observe(world: World) -> None:
        reader(world)
        if observer is not None:
            observer(world)

    recording = record_answer(source, posture, job.seed, varied, observe)
    extra = {}
    if recording.outcome.invalid is None:
        extra = {VERDICTS: verdicts(recording, posture.shoulder, rules, reader.columns)}
    return job_result(job, posture, drawn, recording.outcome, extra)
