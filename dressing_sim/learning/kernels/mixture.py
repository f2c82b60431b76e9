"""Expectation-maximisation for a Gaussian mixture whose responsibilities are shared by frames."""

import numpy as np

from dressing_sim.compiled import compiled
from dressing_sim.learning.kernels.exponential import exp_below_zero
from dressing_sim.learning.kernels.linalg import cholesky, invert_lower

BLOCK = 128  # samples worked on at a time, so that the buffers stay in the first-level cache


@compiled
def whiten(
    priors: np.ndarray, covariances: np.ndarray, whitening: np.ndarray, constants: np.ndarray
) -> bool:
    """Inverse Cholesky factor of each covariance, and the constant part of each log density."""
    n_components, n_frames, n_dims = covariances.shape[:3]
    factor = np.empty((n_dims, n_dims))
    for k in range(n_components):
        constants[k] = np.log(priors[k])
        for p in range(n_frames):
            if not cholesky(covariances[k, p], factor):
                return False
            invert_lower(factor, whitening[k, p])
            constants[k] -= 0.5 * n_dims * np.log(2.0 * np.pi)
            for i in range(n_dims):
                constants[k] -= np.log(factor[i, i])
    return True


@compiled
def block_responsibilities(
    data: np.ndarray,
    importance: np.ndarray,
    begin: int,
    size: int,
    means: np.ndarray,
    whitening: np.ndarray,
    constants: np.ndarray,
    work: np.ndarray,
    logs: np.ndarray,
) -> float:
    """Responsibilities of ``size`` samples into ``logs`` (K, BLOCK); returns their log-likelihood.

    Both are times each sample's ``importance`` (N,). Log-sum-exp over the components, so a sample
    far from all of them still gets sound weights.
    """
    n_components, n_frames, n_dims = means.shape
    largest, total = work[0], work[1]
    for n in range(size):
        largest[n] = -np.inf
        total[n] = 0.0
    row = work[2]
    for k in range(n_components):
        log = logs[k]
        for n in range(size):
            log[n] = constants[k]
        for p in range(n_frames):
            for i in range(n_dims):
                shift = 0.0
                for j in range(i + 1):
                    shift += whitening[k, p, i, j] * means[k, p, j]
                for n in range(size):
                    row[n] = -shift
                for j in range(i + 1):
                    weight = whitening[k, p, i, j]
                    x = data[p, j, begin : begin + size]
                    for n in range(size):
                        row[n] += weight * x[n]
                for n in range(size):
                    log[n] -= 0.5 * row[n] * row[n]
        for n in range(size):
            largest[n] = max(largest[n], log[n])
    for k in range(n_components):
        log = logs[k]
        exp_below_zero(log, largest, size)
        for n in range(size):
            total[n] += log[n]
    log_likelihood = 0.0
    for n in range(size):
        log_likelihood += importance[begin + n] * (largest[n] + np.log(total[n]))
        total[n] = importance[begin + n] / total[n]
    for k in range(n_components):
        log = logs[k]
        for n in range(size):
            log[n] *= total[n]
    return log_likelihood


@compiled
def accumulate(
    data: np.ndarray,
    begin: int,
    size: int,
    means: np.ndarray,
    weights: np.ndarray,
    row: np.ndarray,
    mass: np.ndarray,
    first: np.ndarray,
    second: np.ndarray,
) -> None:
    """Weighted moments about the old means: no cancellation, and no second pass over the data."""
    n_components, n_frames, n_dims = means.shape
    for k in range(n_components):
        weight = weights[k]
        block_mass = 0.0
        for n in range(size):
            block_mass += weight[n]
        if block_mass == 0.0:
            continue
        mass[k] += block_mass
        for p in range(n_frames):
            for i in range(n_dims):
                x = data[p, i, begin : begin + size]
                centre = means[k, p, i]
                total = 0.0
                for n in range(size):
                    row[n] = weight[n] * (x[n] - centre)
                    total += row[n]
                first[k, p, i] += total
                for j in range(i + 1):
                    y = data[p, j, begin : begin + size]
                    centre = means[k, p, j]
                    total = 0.0
                    for n in range(size):
                        total += row[n] * (y[n] - centre)
                    second[k, p, i, j] += total


@compiled
def maximise(
    n_samples: int,
    floor: np.ndarray,
    as_prior: bool,
    mass: np.ndarray,
    first: np.ndarray,
    second: np.ndarray,
    priors: np.ndarray,
    means: np.ndarray,
    covariances: np.ndarray,
) -> None:
    """Priors, means and covariances from the moments; an empty component keeps its place.

    As a prior the floor is what a component's fair share of the samples, N / K, would add.
    """
    n_components, n_frames, n_dims = means.shape
    for k in range(n_components):
        priors[k] = mass[k] / n_samples
        if mass[k] < 1e-10:
            continue
        share = n_samples / (n_components * mass[k]) if as_prior else 1.0
        for p in range(n_frames):
            for i in range(n_dims):
                for j in range(i + 1):
                    value = second[k, p, i, j] / mass[k]
                    value -= first[k, p, i] * first[k, p, j] / mass[k] ** 2
                    covariances[k, p, i, j] = value + share * floor[p, i, j]
                    covariances[k, p, j, i] = value + share * floor[p, i, j]
            for i in range(n_dims):
                means[k, p, i] += first[k, p, i] / mass[k]


@compiled
def penalty(whitening: np.ndarray, floor: np.ndarray) -> float:
    """sum_kp tr(S_kp^-1 F_p) / 2 K, from the inverse factors W with S^-1 = W^T W."""
    n_components, n_frames, n_dims = whitening.shape[:3]
    total = 0.0
    for k in range(n_components):
        for p in range(n_frames):
            for i in range(n_dims):
                for j in range(i + 1):
                    row = 0.0
                    for m in range(i + 1):
                        row += floor[p, j, m] * whitening[k, p, i, m]
                    total += whitening[k, p, i, j] * row
    return 0.5 * total / n_components


@compiled
def expectation_maximisation(
    data: np.ndarray,
    importance: np.ndarray,
    floor: np.ndarray,
    priors: np.ndarray,
    means: np.ndarray,
    covariances: np.ndarray,
    min_steps: int,
    max_steps: int,
    tolerance: float,
    as_prior: bool,
) -> tuple[np.ndarray, bool, bool]:
    """EM in place on ``priors`` (K,), ``means`` (K, P, D), ``covariances`` (K, P, D, D).

    ``data`` is (P, D, N), samples last, and ``importance`` (N,) how much each counts; it sums to N.
    Returns the mean log-likelihood and the objective before each step (2, n_steps), whether the
    objective rose by less than the tolerance in the end, and whether every covariance stayed
    positive definite.
    """
    n_samples = data.shape[2]
    n_components = priors.shape[0]
    whitening = np.empty_like(covariances)
    constants = np.empty(n_components)
    work = np.empty((3, BLOCK))
    weights = np.empty((n_components, BLOCK))
    mass = np.empty(n_components)
    first = np.empty_like(means)
    second = np.empty_like(covariances)
    record = np.empty((2, max_steps))
    for step in range(max_steps):
        if not whiten(priors, covariances, whitening, constants):
            return record[:, :step], False, False
        mass[:] = 0.0
        first[:] = 0.0
        second[:] = 0.0
        log_likelihood = 0.0
        for begin in range(0, n_samples, BLOCK):
            size = min(BLOCK, n_samples - begin)
            log_likelihood += block_responsibilities(
                data, importance, begin, size, means, whitening, constants, work, weights
            )
            accumulate(data, begin, size, means, weights, work[2], mass, first, second)
        maximise(n_samples, floor, as_prior, mass, first, second, priors, means, covariances)
        record[0, step] = log_likelihood / n_samples
        record[1, step] = record[0, step]
        if as_prior:
            record[1, step] -= penalty(whitening, floor)
        if step >= min_steps and record[1, step] - record[1, step - 1] < tolerance:
            return record[:, : step + 1], True, True
    return record, False, True


@compiled
def responsibilities(
    data: np.ndarray, priors: np.ndarray, means: np.ndarray, covariances: np.ndarray
) -> tuple[np.ndarray, float]:
    """Responsibilities (K, N) of samples (P, D, N), and their log-likelihood (NaN if singular)."""
    n_samples = data.shape[2]
    n_components = priors.shape[0]
    whitening = np.empty_like(covariances)
    constants = np.empty(n_components)
    result = np.empty((n_components, n_samples))
    if not whiten(priors, covariances, whitening, constants):
        return result, np.nan
    work = np.empty((3, BLOCK))
    weights = np.empty((n_components, BLOCK))
    importance = np.ones(n_samples)
    log_likelihood = 0.0
    for begin in range(0, n_samples, BLOCK):
        size = min(BLOCK, n_samples - begin)
        log_likelihood += block_responsibilities(
            data, importance, begin, size, means, whitening, constants, work, weights
        )
        result[:, begin : begin + size] = weights[:, :size]
    return result, log_likelihood
