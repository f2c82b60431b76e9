"""Fitting a mixture over frames: initialisation, covariance floor, expectation-maximisation.

One mixture describes the samples as seen from every frame at once. Sample n is in component k with
the responsibility

    gamma_nk  proportional to  pi_k prod_p N(x_np | mu_kp, Sigma_kp),

the same for every frame p, so that component k means the same part of the motion in all of them.
Source: Calinon (2016), "A tutorial on task-parameterized movement learning and retrieval",
Intelligent Service Robotics 9, doi:10.1007/s11370-015-0187-9.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from dressing_sim.checks import one_of, real_array, real_number, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.frame import FloatArray

#: More steps of expectation-maximisation are not meant.
MOST_STEPS = 1_000_000

Initialisation = Literal["time-bins", "k-means"]
Flooring = Literal["added", "prior"]

#: Below this fraction of it a log-likelihood falls by rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Mixture:
    """A Gaussian mixture in every frame, with common priors.

    Attributes:
        priors: (K,), sum to one.
        means: (K, P, D), in each frame's own coordinates.
        covariances: (K, P, D, D).
    """

    priors: FloatArray
    means: FloatArray
    covariances: FloatArray

    @property
    def n_components(self) -> int:
        """K"""
        return self.means.shape[0]

    @property
    def n_frames(self) -> int:
        """P"""
        return self.means.shape[1]

    @property
    def n_dims(self) -> int:
        """D"""
        return self.means.shape[2]

    def check(self) -> None:
        """Raise ``InvalidInputError`` unless shapes agree and all is finite."""
        for name in ("priors", "means", "covariances"):
            real_array(getattr(self, name), None, f"a mixture's {name} has", finite=False)
        if np.ndim(self.means) != 3:
            raise InvalidInputError("a mixture's means do not have the shape (K, P, D)")
        k, p, d = self.means.shape
        if self.priors.shape != (k,) or self.covariances.shape != (k, p, d, d):
            raise InvalidInputError("a mixture's priors, means and covariances do not match")
        if not all(np.isfinite(a).all() for a in (self.priors, self.means, self.covariances)):
            raise InvalidInputError("a mixture's parameters must be finite")


@dataclass(frozen=True)
class EMOptions:
    """When expectation-maximisation stops, and what a covariance floor means to it.

    The defaults are those of the authors' code (5 to 100 steps, 1e-5, the floor added).

    Attributes:
        min_steps: steps before the tolerance is looked at.
        max_steps: steps after which it stops in any case.
        tolerance: it stops once a step raises the objective by less, a mean log-likelihood.
        flooring: ``"added"``: the floor F_p is added to every covariance at every step. That does
            not maximise the likelihood, which may fall; EM then stops. ``"prior"``: the floor is
            the scale of a Wishart-like prior, and EM maximises the penalised likelihood

                log L - (N / 2 K) sum_kp tr(S_kp^-1 F_p),

            which never falls: S_kp is the sample covariance plus F_p N / (K N_k). A component with
            its fair share N_k = N / K of the samples has F_p added, one with fewer more.
    """

    min_steps: int = 5
    max_steps: int = 100
    tolerance: float = 1e-5
    flooring: Flooring = "added"

    def __post_init__(self) -> None:
        for name in ("min_steps", "max_steps"):
            whole_number(getattr(self, name), f"EM's {name}", 1, MOST_STEPS)
        if not self.min_steps <= self.max_steps:
            raise InvalidInputError(
                f"EM needs 1 <= min_steps <= max_steps, not {self.min_steps} and {self.max_steps}"
            )
        real_number(self.tolerance, "EM's tolerance", 0.0)
        one_of(self.flooring, "flooring", get_args(Flooring))


@dataclass(frozen=True, eq=False)
class EMRecord:
    """How expectation-maximisation went.

    Attributes:
        log_likelihoods: mean log-likelihood of a sample before each step (n_steps,).
        converged: whether it stopped because the objective hardly changed any more: neither rose
            nor fell by the tolerance.
        objectives: what is maximised, before each step (n_steps,): the mean log-likelihood, or with
            the floor as a prior the mean penalised one.
    """

    log_likelihoods: FloatArray
    converged: bool
    objectives: FloatArray

    @property
    def fell(self) -> bool:
        """Whether it stopped because the last step lowered the objective: a floor's doing."""
        return _falls(self.objectives, 0.0)

    @property
    def n_steps(self) -> int:
        """Number of steps taken."""
        return len(self.log_likelihoods)


def _falls(objectives: FloatArray, tolerance: float) -> bool:
    """Whether the last step lowered the objective by more than a tolerance and rounding."""
    if len(objectives) < 2:
        return False
    rounding = _ROUNDING * (1.0 + abs(float(objectives[-1])))
    return bool(objectives[-1] < objectives[-2] - max(tolerance, rounding))


def variances(data: FloatArray, importance: FloatArray | None = None) -> FloatArray:
    """Variance (P, D) of samples (P, D, N), each counted as often as its ``importance`` (N,)."""
    if importance is None:
        return data.var(axis=2)
    centred = data - np.average(data, axis=2, weights=importance)[:, :, None]
    return np.asarray(np.average(centred**2, axis=2, weights=importance))


def covariance_floor(
    data: FloatArray,
    blocks: Sequence[int],
    floor: Sequence[float],
    relative: bool,
    importance: FloatArray | None = None,
) -> FloatArray:
    """The matrices (P, D, D) that are added to every covariance.

    Args:
        data: (P, D, N) samples in each frame.
        blocks: sizes of the groups of coordinates that share a unit; they sum to D.
        floor: one value a block. Absolute: a variance, in the block's unit squared. Relative: a
            fraction of the block's variance (mean over its axes), frame by frame.
        relative: which of the two.
        importance: (N,), how much each sample counts for the data's variance; None for all alike.

    Every block's floor is a multiple of the identity, so a rotated frame sees the same floor.
    """
    if len(floor) != len(blocks) or not all(np.isfinite(value) and value >= 0 for value in floor):
        raise InvalidInputError(
            f"a covariance floor needs {len(blocks)} values >= 0, not {list(floor)}"
        )
    n_frames, n_dims, _ = data.shape
    matrices = np.zeros((n_frames, n_dims, n_dims))
    begin = 0
    for size, value in zip(blocks, floor, strict=True):
        axes = np.arange(begin, begin + size)
        scale = np.ones(n_frames)
        if relative:
            scale = variances(data[:, axes], importance).mean(axis=1)
        matrices[:, axes, axes] = (value * scale)[:, None]
        begin += size
    return matrices


def _mixture_of_groups(data: FloatArray, labels: FloatArray, k: int, floor: FloatArray) -> Mixture:
    """Sample moments of each group of samples; label -1 is in no group."""
    n_frames, n_dims, _ = data.shape
    counts = np.array([(labels == group).sum() for group in range(k)])
    if counts.min() < 2:
        raise InvalidInputError(
            f"{data.shape[2]} samples are too few (or too alike) for {k} components"
        )
    means = np.empty((k, n_frames, n_dims))
    covariances = np.empty((k, n_frames, n_dims, n_dims))
    for group in range(k):
        members = data[:, :, labels == group]
        means[group] = members.mean(axis=2)
        centred = members - means[group][:, :, None]
        covariances[group] = centred @ centred.transpose(0, 2, 1) / (counts[group] - 1) + floor
    return Mixture(counts / counts.sum(), means, covariances)


def initialise_by_time(
    data: FloatArray, lengths: Sequence[int], n_components: int, floor: FloatArray
) -> Mixture:
    """One component for each of K equal parts of the demonstrations' duration.

    Args:
        data: (P, D, N) samples, one demonstration after the other.
        lengths: number of samples of each demonstration; they sum to N.
        n_components: K.
        floor: (P, D, D), added to every covariance.

    The bins are half-open, so a demonstration's last sample is in none, and their edges are
    rounded: that is what the published numbers were computed with. Where a bin would have fewer
    than two samples for these reasons, the samples are counted out instead, equally many a bin.
    """
    labels = np.concatenate(
        [np.floor(n_components * np.linspace(0.0, 1.0, length)) for length in lengths]
    )
    labels[labels == n_components] = -1
    if min((labels == group).sum() for group in range(n_components)) < 2:
        labels = np.concatenate([n_components * np.arange(n) // n for n in lengths])
    return _mixture_of_groups(data, labels, n_components, floor)


def initialise_by_k_means(
    data: FloatArray,
    n_components: int,
    floor: FloatArray,
    rng: np.random.Generator,
    max_steps: int = 100,
) -> Mixture:
    """k-means++ on the joint samples of all frames (N, P D), each coordinate of unit variance.

    Never a k-means per frame: its components would not correspond from one frame to the next.
    Source: Arthur and Vassilvitskii (2007), "k-means++: the advantages of careful seeding".
    """
    n_samples = data.shape[2]
    joint = data.reshape(-1, n_samples).T
    joint = (joint - joint.mean(axis=0)) / np.maximum(joint.std(axis=0), 1e-12)
    centres = joint[[rng.integers(n_samples)]]
    nearest = ((joint - centres[0]) ** 2).sum(axis=1)
    for _ in range(1, n_components):
        total = nearest.sum()
        if not total > 0:
            raise InvalidInputError(f"fewer than {n_components} distinct samples")
        centres = np.vstack([centres, joint[rng.choice(n_samples, p=nearest / total)]])
        nearest = np.minimum(nearest, ((joint - centres[-1]) ** 2).sum(axis=1))
    labels = np.full(n_samples, -1)
    for _ in range(max_steps):
        distances = ((joint[:, None] - centres[None]) ** 2).sum(axis=2)
        new_labels = distances.argmin(axis=1)
        if np.array_equal(labels, new_labels):
            break
        labels = new_labels
        for k in range(n_components):
            if (labels == k).any():
                centres[k] = joint[labels == k].mean(axis=0)
    return _mixture_of_groups(data, labels, n_components, floor)


def fit_mixture(
    data: FloatArray,
    initial: Mixture,
    floor: FloatArray,
    options: EMOptions,
    importance: FloatArray | None = None,
) -> tuple[Mixture, EMRecord]:
    """Expectation-maximisation from ``initial``, which is left as it is.

    With an importance w_n, whose scale does not matter, it maximises sum_n w_n log p(x_n): a sample
    of importance 2 is as two samples.

    Args:
        data: (P, D, N) samples in each frame.
        initial: where to start; the current model for a warm start.
        floor: (P, D, D), added to every covariance at every step, or the scale of a prior.
        options: when to stop, and which of the two.
        importance: (N,) above zero, how much each sample counts; None for all alike.

    Raises:
        InvalidInputError: a covariance became singular, which a larger floor prevents.
    """
    from dressing_sim.learning.kernels.mixture import expectation_maximisation

    priors, means = initial.priors.copy(), initial.means.copy()
    covariances = initial.covariances.copy()
    n_samples = data.shape[2]
    counted = (
        np.ones(n_samples) if importance is None else importance * (n_samples / importance.sum())
    )
    record, stopped, sound = expectation_maximisation(
        np.ascontiguousarray(data, dtype=np.float64),
        np.ascontiguousarray(counted, dtype=np.float64),
        floor,
        priors,
        means,
        covariances,
        options.min_steps,
        options.max_steps,
        options.tolerance,
        options.flooring == "prior",
    )
    if not (sound and np.isfinite(means).all() and _definite(covariances)):
        raise InvalidInputError(
            "a component's covariance became singular: use a larger covariance floor, "
            "fewer components or more varied demonstrations"
        )
    converged = stopped and not _falls(record[1], options.tolerance)
    return Mixture(priors, means, covariances), EMRecord(
        record[0].copy(), converged, record[1].copy()
    )


def _definite(covariances: FloatArray) -> bool:
    """Whether all covariances (K, P, D, D) are finite and positive definite."""
    try:
        return bool(np.isfinite(np.linalg.cholesky(covariances)).all())
    except np.linalg.LinAlgError:
        return False


def responsibilities(data: FloatArray, mixture: Mixture) -> tuple[FloatArray, float]:
    """Responsibilities (K, N) of samples (P, D, N), and the sum of their log-likelihoods."""
    from dressing_sim.learning.kernels import mixture as kernel

    weights, log_likelihood = kernel.responsibilities(
        np.ascontiguousarray(data, dtype=np.float64),
        mixture.priors,
        mixture.means,
        mixture.covariances,
    )
    if not np.isfinite(log_likelihood):
        raise InvalidInputError("the mixture has a singular covariance")
    return weights, float(log_likelihood)
