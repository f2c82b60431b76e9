"""The paper's dressing policy: a trajectory-based TP-GMM, integrated from where the robot is.

The mixture is over [x, dx] in R^(2p), with A_hat = blockdiag(A, A) and b_hat = [b; 0]; the motion
is x_{t+1} = x_t + E[dx | x_t] (Zhu, Gienger and Kober 2022, section VI, equation 14).
"""

from collections.abc import Sequence
from copy import copy
from types import NoneType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import (
    LARGEST,
    of_kind,
    real_number,
    real_vector,
    truth_value,
    whole_number,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.components import bic
from dressing_sim.learning.costs import dtw_cost
from dressing_sim.learning.demonstrations import (
    DemonstrationLike,
    SyntheticDemonstration,
    check_demonstrations,
    duration,
)
from dressing_sim.learning.em import EMOptions, Initialisation
from dressing_sim.learning.endpoint import Endpoint
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.gmr import FusionOrder, check_finite, check_fusion
from dressing_sim.learning.motion import Ending, Motion, drawn_paths
from dressing_sim.learning.phases import (
    Alignment,
    Clock,
    clock_from_state,
    clock_state,
    on_clock,
)
from dressing_sim.learning.remarks import tell
from dressing_sim.learning.tpgmm import TPGMM

_SETTINGS = (
    "fusion",
    "samples",
    "shared",
    "end_radius",
    "rest_speed",
    "rest_count",
    "step_limit",
    "outside",
    "stop_outside",
)
#: Settings that files did not hold at first; they were as by default.
_LATER = frozenset({"outside", "stop_outside"})

#: In a demonstration, once resampled; more are not meant.
MOST_SAMPLES = 100_000

_LEARNED = ("dt", "max_samples", "_rest_from", "_mean_step", "_longest_step", "_mean_length")


class TrajectoryTPGMM:
    """Trajectory-based TP-GMM policy.

    The paper fixes ``n_components`` = 4 for dressing. The other defaults are choices of this
    library (``docs/learning.md`` has the measurements behind them).

    Args:
        n_components: K.
        fusion: ``"regression-then-product"`` or ``"product-then-regression"``, see ``gmr``.
        position_floor: added to the variance of the positions at every step of the fit. It limits
            how steeply the displacement may depend on where the path is, and so what happens off
            the demonstrated paths.
        displacement_floor: the same for the displacements.
        relative_floor: the floors are fractions of the data's variance in each frame (True), or
            variances in the positions' unit squared (False).
        samples: samples in a demonstration of mean duration, once resampled; it sets ``dt``.
        shared: one set of responsibilities for all frames when regressing frame by frame.
        end_radius: the motion is over once its next step would lead away from the predicted end
            (see ``endpoint``) and it is nearer to that end than this fraction of the mean
            demonstrated length. 0 leaves only the rest criterion, as in the paper.
        rest_speed: the motion has come to rest once it is slower than this fraction of the mean
            demonstrated speed for ``rest_count`` samples. Neither criterion is looked at before
            half of the shortest demonstration's duration.
        rest_count: see ``rest_speed``.
        step_limit: the path has at most this many times the longest demonstration's samples.
        outside: a position has left the data once it is this many standard deviations from every
            component's mean in the situation, see ``motion``.
        stop_outside: whether a motion ends there; the paper's goes on.
        shrinkage, initialisation, options, rng: see ``TPGMM``.
        alignment: how demonstrations are brought onto one clock before the fit, see ``phases``;
            None learns from them as they are. Costs are then of demonstrations on that clock.

    Attributes:
        dt: time between the samples of a generated path in [s], once fitted.
        model: the fitted ``TPGMM``.
        max_samples: the step limit in samples, once fitted.
        start_point, end_point: ``Endpoint`` models of where demonstrations start and end.
        clock: what demonstrations are aligned with, once fitted with an alignment.

    Raises:
        InvalidInputError: a setting out of range.
    """

    _rest_from: int = 0
    _mean_step: float = 0.0
    _longest_step: float = 0.0
    _mean_length: float = 0.0

    def __init__(
        self,
        n_components: int = 4,
        *,
        fusion: FusionOrder = "regression-then-product",
        position_floor: float = 0.1,
        displacement_floor: float = 0.1,
        relative_floor: bool = True,
        samples: int = 200,
        shrinkage: bool = False,
        shared: bool = True,
        end_radius: float = 0.2,
        rest_speed: float = 0.02,
        rest_count: int = 5,
        step_limit: float = 2.0,
        outside: float = 8.0,
        stop_outside: bool = False,
        initialisation: Initialisation = "time-bins",
        options: EMOptions | None = None,
        rng: np.random.Generator | None = None,
        alignment: Alignment | None = None,
    ) -> None:
        of_kind(alignment, (Alignment, NoneType), "alignment", "an Alignment or None")
        for name, count, fewest in (("samples", samples, 3), ("rest_count", rest_count, 1)):
            whole_number(count, f"a trajectory policy's {name}", fewest, MOST_SAMPLES)
        for name, value, low, high in (
            ("step_limit", step_limit, 1, 1000),
            ("rest_speed", rest_speed, 0, LARGEST),
            ("end_radius", end_radius, 0, LARGEST),
            ("outside", outside, 0, LARGEST),
        ):
            real_number(value, f"a trajectory policy needs {name} >= {low}: {name}", low, high)
        truth_value(shared, "shared")
        truth_value(stop_outside, "stop_outside")
        self.fusion = check_fusion(fusion)
        self.samples = samples
        self.shared = shared
        self.end_radius = end_radius
        self.rest_speed = rest_speed
        self.rest_count = rest_count
        self.step_limit = step_limit
        self.outside = outside
        self.stop_outside = stop_outside
        self.alignment = alignment
        self.clock: Clock | None = None
        self.model = TPGMM(
            n_components,
            encoding="trajectory",
            floor=(position_floor, displacement_floor),
            relative_floor=relative_floor,
            shrinkage=shrinkage,
            initialisation=initialisation,
            options=options,
            rng=rng,
        )
        self.dt: float | None = None
        self.max_samples = 0
        self.start_point: Endpoint | None = None
        self.end_point: Endpoint | None = None

    def fit(
        self, demonstrations: Sequence[DemonstrationLike], weights: ArrayLike | None = None
    ) -> Self:
        """Learn from demonstrations of any lengths and sampling times; returns the policy itself.

        Args:
            demonstrations: one or more, with the same number of frames.
            weights: of each demonstration (M,), above zero, see ``TPGMM.fit``; durations and
                the clock are those of all alike.

        Raises:
            InvalidInputError: demonstrations that cannot be learned from.
        """
        checked = check_demonstrations(demonstrations)
        self.clock = None if self.alignment is None else Clock.of(checked, self.alignment)
        if self.clock is None:
            tell(checked)
        checked = on_clock(self.clock, checked)
        durations = [duration(demonstration) for demonstration in checked]
        self.dt = float(np.mean(durations)) / (self.samples - 1)
        self.max_samples = int(np.ceil(self.step_limit * max(durations) / self.dt)) + 1
        self._rest_from = int(0.5 * min(durations) / self.dt)
        steps = [
            np.linalg.norm(np.diff(d.positions, axis=0), axis=1) * (self.dt / d.dt) for d in checked
        ]
        self._mean_step = float(np.mean([step.mean() for step in steps]))
        self._longest_step = float(max(step.max() for step in steps))
        self._mean_length = float(
            np.mean([step.sum() * d.dt / self.dt for step, d in zip(steps, checked, strict=True)])
        )
        self.start_point = Endpoint.of(checked, 0, weights)
        self.end_point = Endpoint.of(checked, -1, weights)
        self.model.dt = self.dt
        self.model.fit(checked, weights=weights)
        return self

    def refit(
        self,
        demonstrations: Sequence[DemonstrationLike],
        warm: bool = True,
        weights: ArrayLike | None = None,
    ) -> Self:
        """A new policy learned from other demonstrations; this one stays as it is.

        ``dt``, the step limit and what is known of the motion's start and end are kept.

        Args:
            demonstrations: with the same number of frames.
            warm: whether expectation-maximisation starts from this policy's mixture.
            weights: of each demonstration (M,), above zero, see ``TPGMM.fit``.
        """
        truth_value(warm, "warm")
        other = copy(self)
        other.model = copy(self.model)
        seen = on_clock(self.clock, demonstrations)
        other.model.fit(seen, self.model.fitted() if warm else None, weights)
        return other

    def larger(self, demonstrations: Sequence[DemonstrationLike]) -> Self | None:
        """The policy with one component more, None where the BIC of these demonstrations rises.

        Like ``refit``, but from the initialisation.

        Raises:
            InvalidInputError: too few samples for so many components.
        """
        seen = on_clock(self.clock, demonstrations)
        other = copy(self)
        other.model = copy(self.model)
        other.model.n_components += 1
        other.model.fit(seen)
        return other if bic(other.model, seen) < bic(self.model, seen) else None

    def generate(self, frames: Sequence[Frame], start: ArrayLike) -> FloatArray:
        """The motion for a situation, from exactly ``start``.

        No step is longer than the longest demonstrated one, so the path is finite whatever the
        situation. It ends where the demonstrations end or when the motion has come to rest, and
        after ``max_samples`` samples at the latest.

        Args:
            frames: P frames, as in the demonstrations.
            start: position (p,) in world coordinates.

        Returns:
            Positions (T, p) in world coordinates, ``dt`` apart.

        Raises:
            InvalidInputError: not fitted, other frames than learned from, a start that is not
                finite, or a floor so low that the regression is singular.
        """
        from dressing_sim.learning.kernels.regression import integrate

        regression = self.model.regression(frames, self.fusion, shared=self.shared)
        end_point = self.end_point
        assert end_point is not None
        p = frames[0].dimension
        origin = real_vector(start, p, f"start must be {p} finite coordinates: it has")
        arguments = (
            regression,
            self.max_samples - 1,
            self._rest_from,
            self._longest_step,
            self.rest_speed * self._mean_step,
            self.rest_count,
            end_point.predict(frames),
            self.end_radius * self._mean_length,
        )
        path = check_finite(integrate(origin, *arguments))
        if self.stop_outside:
            beyond = self._deviations(frames, path) > self.outside
            path = path[: int(np.argmax(beyond)) + 1] if beyond.any() else path
        return path

    def motion(self, frames: Sequence[Frame], start: ArrayLike) -> Motion:
        """The path of ``generate`` with why it ended, and how far from the data it went."""
        path = self.generate(frames, start)
        deviations = self._deviations(frames, path)
        left = bool(deviations[-1] > self.outside)
        lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
        quiet = lengths[-self.rest_count :] < self.rest_speed * self._mean_step
        resting = len(lengths) >= max(self._rest_from, self.rest_count) and bool(quiet.all())
        early = not resting and len(path) < self.max_samples
        ended: Ending
        if early and not (left and self.stop_outside):
            ended = "end"
        else:
            ended = "left" if left else "rest" if resting else "time"
        assert self.dt is not None
        return Motion(path, self.dt, ended, deviations)

    def _deviations(self, frames: Sequence[Frame], path: FloatArray) -> FloatArray:
        """How many standard deviations positions are from the nearest component's mean (T,)."""
        return self.model.in_situation(frames).marginal(path.shape[1]).deviations(path)

    def log_density(self, frames: Sequence[Frame], points: ArrayLike) -> FloatArray:
        """log p(x | frames) of positions (T, p) in world coordinates: (T,).

        How sure the model is of itself at a position: of the mixture of positions that the frames'
        components give by their product, see ``TPGMM.in_situation``.
        """
        fused = self.model.in_situation(frames)
        return fused.marginal(fused.means.shape[1] // 2).log_density(points)

    def sample(
        self,
        frames: Sequence[Frame],
        start: ArrayLike,
        rng: np.random.Generator,
        count: int = 1,
    ) -> FloatArray:
        """Paths (count, T, p) whose every step is drawn from p(dx | x, frames), not its mean.

        They have as many samples as the motion of ``generate``, ``dt`` apart.

        Args:
            frames: the situation.
            start: of all paths, (p,) in world coordinates.
            rng: where the randomness comes from.
            count: how many.
        """
        path = self.generate(frames, start)
        regression = self.model.regression(frames, self.fusion, shared=self.shared)
        return drawn_paths(regression, path[0], len(path), self._longest_step, count, rng)

    def reproduce(self, demonstration: DemonstrationLike) -> SyntheticDemonstration:
        """The motion for a demonstration's own situation, from its own first position."""
        frames = demonstration.frames
        path = self.generate(frames, np.asarray(demonstration.positions)[0])
        assert self.dt is not None
        return SyntheticDemonstration(path, self.dt, frames)

    def synthesise(self, frames: Sequence[Frame]) -> SyntheticDemonstration:
        """The motion for a new situation as a demonstration, for Algorithm 1.

        It starts where the demonstrations' starts predict it for that situation, never at a
        demonstration's own start.
        """
        self.model.fitted()
        assert self.start_point is not None
        assert self.dt is not None
        path = self.generate(frames, self.start_point.predict(frames))
        return SyntheticDemonstration(path, self.dt, frames)

    def cost(self, demonstrations: Sequence[DemonstrationLike]) -> float:
        """Reproduction cost: ``dtw_cost``, in the unit of the positions."""
        checked = on_clock(self.clock, demonstrations)
        return dtw_cost(
            [self.reproduce(demonstration).positions for demonstration in checked],
            [np.asarray(demonstration.positions) for demonstration in checked],
        )

    def state(self) -> tuple[dict[str, Any], dict[str, FloatArray]]:
        """Settings and arrays for ``storage``."""
        model, arrays = self.model.state()
        assert self.start_point is not None
        assert self.end_point is not None
        alignment, clock = clock_state(self.clock)
        settings = {
            "model": model,
            "alignment": alignment,
            "settings": {name: getattr(self, name) for name in _SETTINGS},
            "learned": {name: getattr(self, name) for name in _LEARNED},
        }
        points = {
            "start_means": self.start_point.means,
            "start_covariances": self.start_point.covariances,
            "end_means": self.end_point.means,
            "end_covariances": self.end_point.covariances,
        }
        return settings, {**arrays, **points, **clock}

    @classmethod
    def from_state(cls, settings: dict[str, Any], arrays: dict[str, FloatArray]) -> Self:
        """The policy that ``state`` came from."""
        kept = settings["settings"]
        names = [name for name in _SETTINGS if name in kept or name not in _LATER]
        policy = cls(**{name: kept[name] for name in names})
        policy.model = TPGMM.from_state(settings["model"], arrays)
        for name in _LEARNED:
            setattr(policy, name, real_number(settings["learned"][name], name, 0.0, 1e9))
        policy.max_samples = whole_number(
            settings["learned"]["max_samples"], "max_samples", 2, 10**9
        )
        policy._rest_from = whole_number(settings["learned"]["_rest_from"], "_rest_from", 0, 10**9)
        policy.clock = clock_from_state(settings.get("alignment"), arrays)
        policy.alignment = None if policy.clock is None else policy.clock.alignment
        policy.start_point = Endpoint(arrays["start_means"], arrays["start_covariances"])
        policy.end_point = Endpoint(arrays["end_means"], arrays["end_covariances"])
        mixture = policy.model.fitted()
        shape = mixture.n_frames, mixture.n_dims // 2
        for point in (policy.start_point, policy.end_point):
            if point.means.shape != shape or point.covariances.shape != (*shape, shape[1]):
                raise InvalidInputError("its mixture, start and end have different shapes")
        return policy
