"""The task-parameterized Gaussian mixture model: from demonstrations to a situation's regression.

A path is seen from every frame as samples of one of two kinds (paper, section III):

* ``"time"``: [t, x] in R^(1+p), t the time in [s] times ``time_scale``;
* ``"trajectory"``: [x, dx] in R^(2p), dx the displacement to the next sample, ``dt`` seconds later.
"""

from collections.abc import Sequence
from dataclasses import asdict
from types import NoneType
from typing import Any, Literal, Self, get_args

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import (
    LARGEST,
    listed,
    of_kind,
    one_of,
    real_array,
    real_number,
    truth_value,
    whole_number,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import em
from dressing_sim.learning.demonstrations import DemonstrationLike, check_weights
from dressing_sim.learning.density import GaussianMixture
from dressing_sim.learning.em import EMOptions, EMRecord, Initialisation, Mixture
from dressing_sim.learning.frame import FloatArray, Frame, situation
from dressing_sim.learning.gmr import (
    FusionOrder,
    Regression,
    WorldMixture,
    check_fusion,
    fused_ridge,
    lift,
    product,
    to_world,
    view_ridges,
)
from dressing_sim.learning.gmr import regression as prepare_regression
from dressing_sim.learning.phases import Alignment, Clock, clock_from_state, clock_state, on_clock
from dressing_sim.learning.samples import common_step_time, time_samples, trajectory_samples
from dressing_sim.learning.shrinkage import shrink_between

Encoding = Literal["trajectory", "time"]

MOST_COMPONENTS = 1000  # more are not meant


class TPGMM:
    """A Gaussian mixture over P frames: {pi_k, {mu_kp, Sigma_kp}_p}_k (paper, equation 2).

    Args:
        n_components: K, at least 1.
        encoding: ``"trajectory"`` or ``"time"``, see the module.
        floor: what is added to the diagonal of every covariance at every step, for the input block
            (time, or position) and the output block (position, or displacement); one number stands
            for both. 1e-4 is pbdlib's value.
        relative_floor: the floor is a fraction of the block's variance in the frame at hand, rather
            than a variance in its unit squared.
        dt: time between the samples in [s] that paths are resampled to, ``"trajectory"`` only; by
            default the demonstrations' own, which must then agree.
        time_scale: factor on time, ``"time"`` only; it sets how time weighs against position.
        shrinkage: whether the regression uses covariances that are shrunk for few demonstrations,
            see ``shrinkage``; the fit itself is the same. Not in the paper.
        initialisation: ``"time-bins"``, or ``"k-means"`` on the joint samples of all frames.
        options: when expectation-maximisation stops.
        rng: needed by ``"k-means"`` only.
        alignment: how demonstrations are brought onto one clock first, see ``phases``; None takes
            them as they are. The clock is kept for a warm start and for further demonstrations.

    Attributes:
        mixture: the fitted ``Mixture``; None before ``fit``.
        predictive: the ``Mixture`` that regression uses: ``mixture``, or its shrunk form.
        record: the ``EMRecord`` of the last fit; None before.
        spread: the outputs' variance in each frame (P,), mean over their axes, once fitted.
        clock: what demonstrations are aligned with, once fitted with an alignment.
        step_time: time in [s] that a displacement spans, once fitted; None for ``"time"``.

    Raises:
        InvalidInputError: a setting out of range.
    """

    def __init__(
        self,
        n_components: int,
        *,
        encoding: Encoding = "trajectory",
        floor: float | tuple[float, float] = 1e-4,
        relative_floor: bool = False,
        dt: float | None = None,
        time_scale: float = 1.0,
        shrinkage: bool = False,
        initialisation: Initialisation = "time-bins",
        options: EMOptions | None = None,
        rng: np.random.Generator | None = None,
        alignment: Alignment | None = None,
    ) -> None:
        whole_number(
            n_components, "a mixture needs n_components >= 1: n_components", 1, MOST_COMPONENTS
        )
        one_of(encoding, "encoding", get_args(Encoding))
        one_of(initialisation, "initialisation", get_args(Initialisation))
        real_number(time_scale, "time_scale", 0.0, LARGEST, above=True)
        real_number(1.0 if dt is None else dt, "dt", 0.0, LARGEST, above=True)
        for name, value in (("relative_floor", relative_floor), ("shrinkage", shrinkage)):
            truth_value(value, name)
        of_kind(options, (EMOptions, NoneType), "options", "EMOptions or None")
        of_kind(alignment, (Alignment, NoneType), "alignment", "an Alignment or None")
        of_kind(rng, (np.random.Generator, NoneType), "rng", "a random generator or None")
        pair = (floor, floor) if isinstance(floor, int | float | np.number) else floor
        floors = listed(pair, "floor", "numbers")
        for one in floors:
            real_number(one, "a covariance floor", 0.0, LARGEST)
        self.n_components = n_components
        self.encoding: Encoding = encoding
        self.floor = floors
        self.relative_floor = relative_floor
        self.dt = dt
        self.time_scale = time_scale
        self.shrinkage = shrinkage
        self.initialisation: Initialisation = initialisation
        self.options = options or EMOptions()
        self.rng = rng
        self.alignment = alignment
        self.clock: Clock | None = None
        self.mixture: Mixture | None = None
        self.predictive: Mixture | None = None
        self.record: EMRecord | None = None
        self.spread: FloatArray | None = None
        self.step_time: float | None = None

    def samples(self, demonstrations: Sequence[DemonstrationLike]) -> tuple[FloatArray, list[int]]:
        """The demonstrations as samples (P, D, N) in each frame, and each one's count.

        Raises:
            InvalidInputError: demonstrations that cannot be learned from.
        """
        checked = self._seen(demonstrations)
        if self.encoding == "time":
            parts = [time_samples(demonstration, self.time_scale) for demonstration in checked]
        else:
            step_time = self.dt or common_step_time(checked)
            parts = [trajectory_samples(demonstration, step_time) for demonstration in checked]
        return np.concatenate(parts, axis=2), [part.shape[2] for part in parts]

    def _seen(self, demonstrations: Sequence[DemonstrationLike]) -> tuple[DemonstrationLike, ...]:
        """The demonstrations as the model sees them, on its clock if it has an alignment."""
        clock = self.clock
        if clock is None and self.alignment is not None:
            clock = Clock.of(demonstrations, self.alignment)
        return on_clock(clock, demonstrations)

    def fit(
        self,
        demonstrations: Sequence[DemonstrationLike],
        warm_start: Mixture | None = None,
        weights: ArrayLike | None = None,
    ) -> Self:
        """Learn the mixture from demonstrations of any lengths and return the model itself.

        Args:
            demonstrations: one or more, with the same number of frames.
            warm_start: where expectation-maximisation starts, instead of the initialisation.
            weights: of each demonstration (M,), above zero: one of weight 2 counts as if it were
                there twice. Their scale does not matter; None counts all alike. The initialisation
                does not look at them.

        Raises:
            InvalidInputError: demonstrations that cannot be learned from, fewer samples than
                components need, or a covariance that became singular.
        """
        if self.alignment is not None and (warm_start is None or self.clock is None):
            self.clock = Clock.of(demonstrations, self.alignment)
        data, lengths = self.samples(demonstrations)
        blocks = self.blocks(data.shape[1])
        importance = None
        if weights is not None:
            importance = np.repeat(check_weights(weights, len(lengths)), lengths)
        floor = em.covariance_floor(data, blocks, self.floor, self.relative_floor, importance)
        if warm_start is not None:
            of_kind(warm_start, Mixture, "warm_start", "a Mixture or None")
            if warm_start.means.shape != (self.n_components, *data.shape[:2]):
                raise InvalidInputError("the warm start has other components, frames or dimensions")
            initial = warm_start
        elif self.initialisation == "k-means":
            if self.rng is None:
                raise InvalidInputError("k-means needs a random generator: pass rng=")
            initial = em.initialise_by_k_means(data, self.n_components, floor, self.rng)
        else:
            initial = em.initialise_by_time(data, lengths, self.n_components, floor)
        self.mixture, self.record = em.fit_mixture(data, initial, floor, self.options, importance)
        self.spread = em.variances(data[:, blocks[0] :], importance).mean(axis=1)
        self.predictive = self.mixture
        if self.shrinkage:
            self.predictive = shrink_between(self.mixture, data, lengths, blocks)
        if self.encoding == "trajectory":
            own = None if self.clock is None else self.clock.dt
            self.step_time = self.dt or own or common_step_time(demonstrations)
        return self

    def blocks(self, n_dims: int) -> tuple[int, int]:
        """Number of input and of output coordinates among ``n_dims``."""
        n_inputs = 1 if self.encoding == "time" else n_dims // 2
        return n_inputs, n_dims - n_inputs

    def fitted(self) -> Mixture:
        """The mixture.

        Raises:
            InvalidInputError: before ``fit``.
        """
        if self.mixture is None:
            raise InvalidInputError("the model has not been fitted: call fit(demonstrations) first")
        return self.mixture

    def log_likelihood(self, demonstrations: Sequence[DemonstrationLike]) -> float:
        """Sum over the samples of log sum_k pi_k prod_p N(x_p | mu_kp, Sigma_kp)."""
        data, _ = self.samples(demonstrations)
        return em.responsibilities(data, self.fitted())[1]

    def regression(
        self,
        frames: Sequence[Frame],
        fusion: FusionOrder = "regression-then-product",
        ridge: float | FloatArray = 0.0,
        shared: bool = False,
    ) -> Regression:
        """The regression of output on input in a situation, in world coordinates.

        Args:
            frames: the situation, as many frames as in the demonstrations.
            fusion: the order of regression and product, see ``gmr``.
            ridge: added to the diagonal of each conditional covariance, in the frame's coordinates
                (in the fused one for ``"product-then-regression"``); one number, or one a frame
                (P,), whose harmonic mean in world coordinates the fused one then gets.
            shared: ``"regression-then-product"`` with responsibilities common to all frames.

        Raises:
            InvalidInputError: not fitted, or another number or dimension of frames.
        """
        n_frames, n_dims = self.fitted().means.shape[1:]
        n_inputs, dimension = self.blocks(n_dims)
        if isinstance(ridge, np.ndarray):
            real_number(float(real_array(ridge, (n_frames,), "ridge has").min()), "ridge", 0.0)
        else:
            real_number(ridge, "ridge", 0.0, LARGEST)
        truth_value(shared, "shared")
        world, bases = self._in_world(frames)
        local = bases[:, -dimension:, -dimension:]
        if check_fusion(fusion) == "product-then-regression":
            return prepare_regression(product(world), n_inputs, fused_ridge(ridge, local))
        return prepare_regression(world, n_inputs, view_ridges(ridge, local), shared)

    def in_situation(self, frames: Sequence[Frame]) -> GaussianMixture:
        """What the model says of samples [t, x] or [x, dx] in a situation, in world coordinates.

        Its components are the products of the frames' own (paper, equation 5). It can be asked for
        the density of samples, and samples can be drawn from it.

        Args:
            frames: the situation, as many frames as in the demonstrations.

        Raises:
            InvalidInputError: not fitted, or another number or dimension of frames.
        """
        fused = product(self._in_world(frames)[0])
        return GaussianMixture(fused.priors, fused.means[0], fused.covariances[0])

    def _in_world(self, frames: Sequence[Frame]) -> tuple[WorldMixture, FloatArray]:
        """Each frame's components in world coordinates, and A_hat (P, D, D)."""
        self.fitted()
        mixture = self.predictive
        assert mixture is not None
        _, dimension = self.blocks(mixture.n_dims)
        frames = situation(frames)
        if len(frames) != mixture.n_frames or any(f.dimension != dimension for f in frames):
            raise InvalidInputError(
                f"the situation needs {mixture.n_frames} frames of dimension {dimension}, "
                f"not {[frame.dimension for frame in frames]}"
            )
        time = self.encoding == "time"
        bases, origins = lift(frames, n_time=int(time), n_copies=1 if time else 2)
        return to_world(mixture, bases, origins), bases

    def state(self) -> tuple[dict[str, Any], dict[str, FloatArray]]:
        """Settings and arrays for ``storage``."""
        mixture = self.fitted()
        assert self.record is not None
        assert self.predictive is not None
        settings = {
            "n_components": self.n_components,
            "encoding": self.encoding,
            "floor": list(self.floor),
            "relative_floor": self.relative_floor,
            "dt": self.dt,
            "time_scale": self.time_scale,
            "shrinkage": self.shrinkage,
            "initialisation": self.initialisation,
            "options": asdict(self.options),
            "step_time": self.step_time,
            "converged": self.record.converged,
        }
        arrays = {
            "priors": mixture.priors,
            "means": mixture.means,
            "covariances": mixture.covariances,
            "predictive_covariances": self.predictive.covariances,
            "log_likelihoods": self.record.log_likelihoods,
            "objectives": self.record.objectives,
        }
        if self.spread is not None:
            arrays["spread"] = self.spread
        settings["alignment"], clock = clock_state(self.clock)
        return settings, {**arrays, **clock}

    @classmethod
    def from_state(cls, settings: dict[str, Any], arrays: dict[str, FloatArray]) -> Self:
        """The model that ``state`` came from."""
        fields = dict(settings)
        step_time, converged = fields.pop("step_time"), bool(fields.pop("converged"))
        fields["floor"] = tuple(fields["floor"])
        fields["options"] = EMOptions(**fields["options"])
        clock = clock_from_state(fields.pop("alignment", None), arrays)
        model = cls(fields.pop("n_components"), **fields)
        model.clock, model.alignment = clock, None if clock is None else clock.alignment
        model.mixture = Mixture(arrays["priors"], arrays["means"], arrays["covariances"])
        model.mixture.check()
        model.predictive = Mixture(
            model.mixture.priors, model.mixture.means, arrays["predictive_covariances"]
        )
        model.predictive.check()
        if model.mixture.n_components != model.n_components:
            raise InvalidInputError("its number of components is not its arrays'")
        # Files of before have neither of these.
        objectives = "objectives" if "objectives" in arrays else "log_likelihoods"
        model.record = EMRecord(arrays["log_likelihoods"], converged, arrays[objectives])
        if "spread" in arrays:
            model.spread = real_array(arrays["spread"], (model.mixture.n_frames,), "its spread has")
        model.step_time = step_time
        return model
