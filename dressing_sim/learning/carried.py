"""Transport regression: demonstrations carried to a new situation, and what they agree on there.

Every demonstration gives one path for every situation, by `Transport` along landmarks. Their answer
is a Bayesian regression over the demonstrations, phase by phase, on a feature of the situations.
With the prior that carried demonstrations agree, one demonstration gives its carried path, and
alike situations give the mean:

    y_m = c + b (z_m - mean z) + e,    e ~ N(0, s^2),    b ~ N(0, d^2),    c flat,

for each coordinate of each phase, where y_m is a point of demonstration m carried to the situation,
z_m the feature of its own situation, and d / s given. The answer at z has mean ``w . y`` and
variance ``s^2 v``, with z counted from the mean, r = d / s and g = r^2 z / (1 + r^2 sum z_m^2):

    w_m = 1 / M + g z_m,    v = 1 / M + g z.

s is the one for which what the demonstrations disagree by is most likely.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dressing_sim.checks import real_array, real_number
from dressing_sim.learning.frame import FloatArray
from dressing_sim.learning.registration import path_length
from dressing_sim.learning.transport import Transport


@dataclass(frozen=True, eq=False)
class Answer:
    """A path for a situation.

    Attributes:
        points: Positions (N, p) by phase.
        times: When they are passed, (N,), from zero [s].
        deviation: Standard deviation (N,) of each coordinate of a demonstration in this situation:
            of demonstrations among themselves, of their mean, of the slope and what is not straight
            about it, of the transport.
        carried: The demonstrations in this situation, (M, N, p).
    """

    points: FloatArray
    times: FloatArray
    deviation: FloatArray
    carried: FloatArray


@dataclass(frozen=True, eq=False)
class CarriedDemonstrations:
    """Demonstrations in phase, each with its situation, and the regression over them.

    Attributes:
        points: Positions by phase, (M, N, p).
        times: When they were passed, (M, N), from zero [s].
        landmarks: Of each situation, (M, K, p), the same ones in each.
        features: What distinguishes the situations, z, (M,).
        length: Over which displacements of landmarks are alike, in the unit of the positions.
        noise: See `Transport.between`.
        slope_to_noise: d / s, per unit of the feature; zero for the plain mean.
        curvature: How far the relation to the feature may be from a straight line, as a fraction of
            the standard deviation of the carried demonstrations at each phase.
    """

    points: FloatArray
    times: FloatArray
    landmarks: FloatArray
    features: FloatArray
    length: float
    noise: float
    slope_to_noise: float
    curvature: float = 0.0

    def __post_init__(self) -> None:
        points = real_array(self.points, ("M", "N", "p"), "demonstrations in phase have", fewest=1)
        m, n, p = points.shape
        real_array(self.times, (m, n), "times of phases have")
        real_array(self.landmarks, (m, "K", p), "landmarks have")
        real_array(self.features, (m,), "features have")
        real_number(self.slope_to_noise, "slope_to_noise", 0.0)

    def answer(self, landmarks: FloatArray, feature: float) -> Answer:
        """What the demonstrations say of a situation.

        Args:
            landmarks: Of the situation, (K, p).
            feature: Of the situation.
        """
        maps = [
            Transport.between(own, landmarks, self.length, self.noise) for own in self.landmarks
        ]
        pairs = list(zip(maps, self.points, strict=True))
        carried = np.stack([transport(points) for transport, points in pairs])
        unsure = np.stack([transport.deviation(points) for transport, points in pairs])
        weights, variance = self._regression(feature)
        spread = self._disagreement(carried) ** 2 * (1.0 + variance)
        curved = self.curvature**2 * np.mean(carried.var(axis=0), axis=1)
        # Transports from all demonstrations err alike, where no landmark is near.
        deviation = np.sqrt(spread + curved + (np.abs(weights) @ unsure) ** 2)
        points = np.einsum("m,mnp->np", weights, carried)
        return Answer(points, self._times(points), deviation, carried)

    def _regression(self, feature: float) -> tuple[FloatArray, float]:
        """Weights w (M,) and variance v of the answer at a feature."""
        mean, ratio = float(self.features.mean()), self.slope_to_noise**2
        centred, step = self.features - mean, feature - mean
        gain = ratio * step / (1.0 + ratio * float(centred @ centred))
        return 1.0 / len(centred) + gain * centred, 1.0 / len(centred) + gain * step

    def _disagreement(self, carried: FloatArray) -> float:
        """The most likely s, in the unit of the positions; zero for one demonstration."""
        if len(carried) == 1:
            return 0.0
        left = carried - carried.mean(axis=0)
        centred = self.features - self.features.mean()
        ratio = self.slope_to_noise**2
        along = np.einsum("m,mnp->np", centred, left)
        squares = np.sum(left**2) - ratio * np.sum(along**2) / (1.0 + ratio * (centred @ centred))
        return float(np.sqrt(squares / (left[0].size * (len(carried) - 1))))

    def _times(self, points: FloatArray) -> FloatArray:
        """The mean of each phase's share of a duration, of the duration that fits the length.

        The duration is the geometric mean of those demonstrated; a path that is longer than the
        demonstrated ones takes longer by as much.
        """
        durations = self.times[:, -1]
        shares = (self.times / durations[:, None]).mean(axis=0)
        lengths = np.array([path_length(path) for path in self.points])
        return shares * path_length(points) * float(np.exp(np.mean(np.log(durations / lengths))))
