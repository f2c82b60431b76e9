"""How good estimated probabilities of success are, and what abstaining by them is worth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import isotonic_regression

from dressing_sim.benchmark.analysis.episodes import Rate
from dressing_sim.checks import real_array
from dressing_sim.errors import InvalidInputError

_RESAMPLES = 10_000


@dataclass(frozen=True, eq=False)
class Forecasts:
    """Probabilities of success, and what came true.

    Attributes:
        probabilities: (N,), each from 0 to 1.
        successes: (N,), whether it succeeded.

    Raises:
        InvalidInputError: No episode, shapes that do not fit, or what is no probability.
    """

    probabilities: NDArray[np.float64]
    successes: NDArray[np.bool_]

    def __post_init__(self) -> None:
        p = real_array(self.probabilities, ("N",), "probabilities have", fewest=1)
        if p.min() < 0.0 or p.max() > 1.0:
            raise InvalidInputError(
                f"probabilities are {p.min():g} to {p.max():g}, valid is 0 to 1"
            )
        if self.successes.shape != p.shape:
            raise InvalidInputError(
                f"successes have shape {self.successes.shape}, valid is {p.shape}, as probabilities"
            )

    @classmethod
    def of(cls, probabilities: ArrayLike, successes: ArrayLike) -> Forecasts:
        """From lists or arrays (N,)."""
        return cls(
            np.asarray(probabilities, dtype=np.float64), np.asarray(successes, dtype=np.bool_)
        )

    def __len__(self) -> int:
        return len(self.probabilities)

    @property
    def losses(self) -> NDArray[np.float64]:
        """Squared error of each, (N,)."""
        return np.asarray((self.probabilities - self.successes) ** 2)

    @property
    def brier(self) -> float:
        """Mean squared error (Brier 1950); 0 is perfect, 0.25 a coin that says one half."""
        return float(self.losses.mean())

    @property
    def recalibrated(self) -> NDArray[np.float64]:
        """The best probabilities (N,) that never fall where the given ones rise.

        Isotonic regression by pooling adjacent violators; equal ones stay equal.
        """
        _, place = np.unique(self.probabilities, return_inverse=True)
        weights = np.bincount(place)
        rates = np.bincount(place, self.successes) / weights
        return np.asarray(isotonic_regression(rates, weights=weights).x[place], dtype=np.float64)

    @property
    def decomposition(self) -> Decomposition:
        """What the Brier score is made of."""
        recalibrated = float(((self.recalibrated - self.successes) ** 2).mean())
        rate = float(self.successes.mean())
        uncertainty = rate * (1.0 - rate)
        return Decomposition(self.brier - recalibrated, uncertainty - recalibrated, uncertainty)

    def gain(self, constant: float, rng: np.random.Generator) -> Gain:
        """Against the same probability for all, such as the success rate in training.

        Args:
            constant: That probability.
            rng: Of the bootstrap over episodes.
        """
        saved = (constant - self.successes) ** 2 - self.losses
        drawn = saved[rng.integers(len(saved), size=(_RESAMPLES, len(saved)))].mean(axis=1)
        low, high = np.percentile(drawn, [2.5, 97.5])
        return Gain(float(saved.mean()), (float(low), float(high)))

    def bins(self, most: int = 10) -> list[Bin]:
        """Episodes by probability in bins of about equal size; equal ones are in the same bin."""
        order = np.argsort(self.probabilities, kind="stable")
        p = self.probabilities[order]
        edges = np.linspace(0, len(p), min(most, len(p)) + 1).astype(int)
        starts = np.unique(np.searchsorted(p, p[edges[:-1]], side="left"))
        parts = np.split(order, starts[1:])
        return [
            Bin(float(self.probabilities[part].mean()), Rate.of(self.successes[part].tolist()))
            for part in parts
        ]

    def coverage(self) -> list[Covered]:
        """Success of those attempted, from all to the surest alone, by a falling number of them.

        Those with the same probability are attempted or left together.
        """
        thresholds = np.unique(self.probabilities)
        return [
            Covered(float(t), Rate.of(self.successes[self.probabilities >= t].tolist()), len(self))
            for t in thresholds
        ]


@dataclass(frozen=True, slots=True)
class Decomposition:
    """A Brier score: miscalibration - discrimination + uncertainty.

    With isotonic recalibration, so that no choice of bins has a part in it (Dimitriadis, Gneiting
    and Jordan 2021, doi:10.1073/pnas.2016191118).

    Attributes:
        miscalibration: What recalibrating would save; 0 is perfect.
        discrimination: What telling episodes apart saves, beyond their mean; the more the better.
        uncertainty: Of the episodes: the score of their own success rate, told of all of them.
    """

    miscalibration: float
    discrimination: float
    uncertainty: float

    @property
    def score(self) -> float:
        """The Brier score."""
        return self.miscalibration - self.discrimination + self.uncertainty


@dataclass(frozen=True, slots=True)
class Gain:
    """By how much a Brier score is below another one.

    Attributes:
        value: Above 0 it is better.
        interval: Its 95 % bootstrap interval over episodes.
    """

    value: float
    interval: tuple[float, float]


@dataclass(frozen=True, slots=True)
class Bin:
    """Episodes of about the same probability.

    Attributes:
        probability: Their mean probability.
        rate: How many succeeded.
    """

    probability: float
    rate: Rate

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a summary."""
        return {"probability": self.probability, **_plain(self.rate)}


@dataclass(frozen=True, slots=True)
class Covered:
    """The episodes that are attempted with one threshold.

    Attributes:
        threshold: The least probability that is attempted.
        rate: How many of those attempted succeeded.
        n: All episodes, those left included.
    """

    threshold: float
    rate: Rate
    n: int

    @property
    def share(self) -> float:
        """How many are attempted, of all."""
        return self.rate.n / self.n

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a summary."""
        return {"threshold": self.threshold, "pc_coverage": 100.0 * self.share, **_plain(self.rate)}


def surest(covered: Sequence[Covered], share: float) -> Covered:
    """The fewest attempted that are still at least this share of all."""
    return min((one for one in covered if one.share >= share), key=lambda one: one.share)


def _plain(rate: Rate) -> dict[str, Any]:
    return {
        "n_episodes": rate.n,
        "n_success": rate.n_success,
        "pc_success": rate.percent,
        "pc_success_ci95": list(rate.interval),
    }
