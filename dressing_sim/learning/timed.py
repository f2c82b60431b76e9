"""The paper's planar policy: a time-based TP-GMM."""

from collections.abc import Sequence
from copy import copy
from types import NoneType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import (
    LARGEST,
    listed,
    of_kind,
    real_array,
    real_number,
    real_vector,
    truth_value,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.costs import rms_cost
from dressing_sim.learning.demonstrations import (
    DemonstrationLike,
    SyntheticDemonstration,
    check_demonstrations,
    duration,
)
from dressing_sim.learning.density import definite_factors
from dressing_sim.learning.em import EMOptions, Initialisation
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.gmr import FusionOrder, check_fusion
from dressing_sim.learning.motion import Motion, check_draw, minimum_jerk
from dressing_sim.learning.phases import (
    Alignment,
    Clock,
    clock_from_state,
    clock_state,
    on_clock,
)
from dressing_sim.learning.remarks import tell
from dressing_sim.learning.tpgmm import TPGMM


class TimeTPGMM:
    """Time-based TP-GMM policy: positions as a function of time (paper, sections III and V).

    The defaults are the settings behind the paper's Table I.

    Args:
        n_components: K.
        fusion: ``"regression-then-product"`` or ``"product-then-regression"``, see ``gmr``.
        floor: added to every variance at every step of the fit; see ``TPGMM``.
        relative_floor: whether ``floor`` and ``ridge`` are fractions of the data's variance in each
            frame, rather than variances in the unit squared.
        time_scale: factor on time, which sets how time weighs against position.
        ridge: added to the conditional variances before the product over frames.
        blend: the share of the duration over which a path bends from a given start into the
            regression.
        shrinkage, initialisation, options, rng: see ``TPGMM``.
        alignment: how demonstrations are brought onto one clock before the fit, see ``phases``;
            None learns from them as they are. Costs are then of demonstrations on that clock.

    Attributes:
        dt: time between the samples of a generated path in [s], the shortest of the
            demonstrations', once fitted.
        model: the fitted ``TPGMM``.
        duration: mean duration of the demonstrations in [s], once fitted.
        clock: what demonstrations are aligned with, once fitted with an alignment.
    """

    def __init__(
        self,
        n_components: int = 8,
        *,
        fusion: FusionOrder = "regression-then-product",
        floor: float | tuple[float, float] = 1e-4,
        relative_floor: bool = False,
        time_scale: float = 0.1,
        shrinkage: bool = False,
        ridge: float = 1e-4,
        blend: float = 0.25,
        initialisation: Initialisation = "time-bins",
        options: EMOptions | None = None,
        rng: np.random.Generator | None = None,
        alignment: Alignment | None = None,
    ) -> None:
        of_kind(alignment, (Alignment, NoneType), "alignment", "an Alignment or None")
        real_number(ridge, "a time-based policy's ridge", 0.0, LARGEST)
        real_number(blend, "a time-based policy's blend", 0.0, 1.0, above=True)
        self.fusion = check_fusion(fusion)
        self.ridge = ridge
        self.blend = blend
        self.alignment = alignment
        self.clock: Clock | None = None
        self.model = TPGMM(
            n_components,
            encoding="time",
            floor=floor,
            relative_floor=relative_floor,
            shrinkage=shrinkage,
            time_scale=time_scale,
            initialisation=initialisation,
            options=options,
            rng=rng,
        )
        self.dt: float | None = None
        self.duration = 0.0

    def fit(
        self, demonstrations: Sequence[DemonstrationLike], weights: ArrayLike | None = None
    ) -> Self:
        """Learn from demonstrations of any lengths and sampling times; returns the policy itself.

        Args:
            demonstrations: one or more, with the same number of frames.
            weights: of each demonstration (M,), above zero, see ``TPGMM.fit``; the duration
                and the clock are those of all alike.

        Raises:
            InvalidInputError: demonstrations that cannot be learned from.
        """
        checked = check_demonstrations(demonstrations)
        self.clock = None if self.alignment is None else Clock.of(checked, self.alignment)
        if self.clock is None:
            tell(checked)
        checked = on_clock(self.clock, checked)
        self.model.fit(checked, weights=weights)
        self.dt = min(float(demonstration.dt) for demonstration in checked)
        self.duration = float(np.mean([duration(demonstration) for demonstration in checked]))
        return self

    def refit(self, demonstrations: Sequence[DemonstrationLike], warm: bool = True) -> Self:
        """A new policy learned from other demonstrations; this one stays as it is.

        Args:
            demonstrations: with the same number of frames.
            warm: whether expectation-maximisation starts from this policy's mixture.
        """
        truth_value(warm, "warm")
        other = copy(self)
        other.model = copy(self.model)
        seen = on_clock(self.clock, demonstrations)
        other.model.fit(seen, self.model.fitted() if warm else None)
        return other

    def at_times(self, frames: Sequence[Frame], times: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Mean positions (T, p) and covariances (T, p, p) in world coordinates.

        Args:
            frames: the situation.
            times: (T,) since the start in [s].
        """
        ridge: float | FloatArray = self.ridge
        if self.model.relative_floor and self.model.spread is not None:
            ridge = self.ridge * self.model.spread
        regression = self.model.regression(frames, self.fusion, ridge)
        return regression(
            real_array(times, ("T",), "times have", "s")[:, None] * self.model.time_scale
        )

    def generate(self, frames: Sequence[Frame], start: ArrayLike | None = None) -> FloatArray:
        """The motion for a situation, of the demonstrations' mean duration.

        Time alone does not know where the robot is. With ``start``, the path begins exactly there
        and the offset to the regression fades by a minimum-jerk blend over the first ``blend`` of
        the duration (a choice of this library); with None it is the regression itself, which is
        what the paper's costs are computed from.

        Args:
            frames: P frames, as in the demonstrations.
            start: position (p,) in world coordinates, or None.

        Returns:
            Positions (T, p) in world coordinates, ``dt`` apart.

        Raises:
            InvalidInputError: not fitted, other frames than learned from, or a start that is not
                finite.
        """
        self.model.fitted()
        assert self.dt is not None
        times = np.arange(round(self.duration / self.dt) + 1, dtype=np.float64) * self.dt
        path, _ = self.at_times(frames, times)
        return path if start is None else self._begun_at(start, path, times)

    def follow(
        self, situations: Sequence[Sequence[Frame]], start: ArrayLike | None = None
    ) -> FloatArray:
        """The motion for frames that move: at each time the regression in the frames of that time.

        What is learned is a path seen from frames, whether they stand still or not: Calinon (2016)
        writes A and b with a time index. A position knows the frames of its own time and no later
        one, so a path can be asked for piece by piece while a person moves.

        Args:
            situations: where the frames are at 0, ``dt``, 2 ``dt``, ...: as many as there are
                samples, at most those of the demonstrations' mean duration.
            start: as in ``generate``.

        Returns:
            Positions (T, p) in world coordinates, ``dt`` apart, one for each situation.

        Raises:
            InvalidInputError: not fitted, no situation or more than the motion takes, or what
                ``generate`` refuses.
        """
        self.model.fitted()
        assert self.dt is not None
        moments = listed(situations, "situations", "a sequence of situations")
        most = round(self.duration / self.dt) + 1
        if not 1 <= len(moments) <= most:
            raise InvalidInputError(f"there are {len(moments)} situations, valid is 1 to {most}")
        times = np.arange(len(moments), dtype=np.float64) * self.dt
        pairs = zip(moments, times[:, None], strict=True)
        path = np.concatenate([self.at_times(frames, time)[0] for frames, time in pairs])
        return path if start is None else self._begun_at(start, path, times)

    def _begun_at(self, start: ArrayLike, path: FloatArray, times: FloatArray) -> FloatArray:
        """A path (T, p) at times (T,) that begins at a start, which fades out."""
        p = path.shape[1]
        origin = real_vector(start, p, f"start must be {p} finite coordinates: it has")
        phase = np.minimum(times / (self.blend * self.duration), 1.0)
        fade = 1.0 - minimum_jerk(phase)
        blended = path + fade[:, None] * (origin - path[0])
        blended[0] = origin
        return blended

    def motion(self, frames: Sequence[Frame], start: ArrayLike | None = None) -> Motion:
        """The path of ``generate`` with how far it is from the regression.

        It always ends because its time is over: a path over time knows no other end.
        """
        path = self.generate(frames, start)
        assert self.dt is not None
        offsets, _ = self._whitened(frames, np.arange(len(path)) * self.dt, path)
        return Motion(path, self.dt, "time", np.linalg.norm(offsets, axis=1))

    def log_density(
        self, frames: Sequence[Frame], times: ArrayLike, points: ArrayLike
    ) -> FloatArray:
        """log p(x | t, frames) of where the motion is at some times: (T,).

        Args:
            frames: the situation.
            times: (T,) since the start in [s].
            points: (T, p) in world coordinates.
        """
        offsets, log_dets = self._whitened(frames, times, points)
        n_dims = offsets.shape[1]
        return -0.5 * (np.sum(offsets**2, axis=1) + log_dets + n_dims * np.log(2.0 * np.pi))

    def _whitened(
        self, frames: Sequence[Frame], times: ArrayLike, points: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """Points (T, p) from the mean in standard deviations (T, p), and log det S (T,)."""
        means, covariances = self.at_times(frames, times)
        values = real_array(points, means.shape, "points have")
        factors = definite_factors(covariances)
        offsets = np.asarray(np.linalg.solve(factors, (values - means)[..., None])[..., 0])
        return offsets, np.asarray(2.0 * np.log(np.diagonal(factors, axis1=1, axis2=2)).sum(axis=1))

    def sample(
        self, frames: Sequence[Frame], rng: np.random.Generator, count: int = 1
    ) -> FloatArray:
        """Paths (count, T, p) as likely as the model says, ``dt`` apart.

        The regression plus L(t) e, with L(t) L(t)^T its covariance and e drawn once for a path: at
        each time the paths are distributed as the model says, and each path is smooth, as
        demonstrations are. That they stay on one side throughout is a choice of this library; the
        model says nothing about it.

        Args:
            frames: the situation.
            rng: where the randomness comes from.
            count: how many.
        """
        check_draw(count, rng)
        path = self.generate(frames)
        assert self.dt is not None
        _, covariances = self.at_times(frames, np.arange(len(path)) * self.dt)
        normal = rng.standard_normal((count, path.shape[1]))
        return path + np.einsum("tij,nj->nti", definite_factors(covariances), normal)

    def reproduce(self, demonstration: DemonstrationLike) -> SyntheticDemonstration:
        """The regression in a demonstration's own situation, at its own sample times.

        With an alignment, at those it has on the policy's clock.
        """
        (seen,) = on_clock(self.clock, [demonstration])
        return self._reproduce(seen)

    def _reproduce(self, demonstration: DemonstrationLike) -> SyntheticDemonstration:
        times = np.arange(len(demonstration.positions)) * demonstration.dt
        path, _ = self.at_times(demonstration.frames, times)
        return SyntheticDemonstration(path, demonstration.dt, demonstration.frames)

    def synthesise(self, frames: Sequence[Frame]) -> SyntheticDemonstration:
        """The motion for a new situation as a demonstration, for Algorithm 1."""
        path = self.generate(frames)
        assert self.dt is not None
        return SyntheticDemonstration(path, self.dt, frames)

    def cost(self, demonstrations: Sequence[DemonstrationLike]) -> float:
        """Reproduction cost: ``rms_cost``, in the unit of the positions."""
        checked = on_clock(self.clock, demonstrations)
        return rms_cost(
            [self._reproduce(demonstration).positions for demonstration in checked],
            [np.asarray(demonstration.positions) for demonstration in checked],
        )

    def state(self) -> tuple[dict[str, Any], dict[str, FloatArray]]:
        """Settings and arrays for ``storage``."""
        model, arrays = self.model.state()
        alignment, clock = clock_state(self.clock)
        settings = {
            "model": model,
            "fusion": self.fusion,
            "ridge": self.ridge,
            "blend": self.blend,
            "dt": self.dt,
            "duration": self.duration,
            "alignment": alignment,
        }
        return settings, {**arrays, **clock}

    @classmethod
    def from_state(cls, settings: dict[str, Any], arrays: dict[str, FloatArray]) -> Self:
        """The policy that ``state`` came from."""
        names = ("fusion", "ridge", "blend")
        policy = cls(**{name: settings[name] for name in names})
        policy.model = TPGMM.from_state(settings["model"], arrays)
        policy.dt = real_number(settings["dt"], "dt", 0.0, above=True)
        policy.clock = clock_from_state(settings.get("alignment"), arrays)
        policy.alignment = None if policy.clock is None else policy.clock.alignment
        policy.duration = real_number(settings["duration"], "duration", 0.0, 1e6 * policy.dt)
        return policy
