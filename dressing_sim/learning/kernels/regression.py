"""Gaussian mixture regression in several frames at once, and its integration to a path."""

import numpy as np
from numba import njit

from dressing_sim.learning.kernels.linalg import invert_definite


@njit(cache=True, error_model="numpy")
def log_densities(
    query: np.ndarray,
    log_weights: np.ndarray,
    input_means: np.ndarray,
    precisions: np.ndarray,
    shared: bool,
    logs: np.ndarray,
) -> None:
    """log(pi_k N(query | input marginal of k)) of each frame into ``logs`` (P, K)."""
    n_frames, n_components, n_inputs = input_means.shape
    for p in range(n_frames):
        for k in range(n_components):
            mean = input_means[p, k]
            precision = precisions[p, k]
            distance = 0.0
            for i in range(n_inputs):
                row = 0.0
                for j in range(n_inputs):
                    row += precision[i, j] * (query[j] - mean[j])
                distance += row * (query[i] - mean[i])
            logs[p, k] = log_weights[p, k] - 0.5 * distance
    if shared:
        for k in range(n_components):
            total = 0.0
            for p in range(n_frames):
                total += logs[p, k]
            for p in range(n_frames):
                logs[p, k] = total


@njit(cache=True, error_model="numpy")
def condition(
    query: np.ndarray,
    log_weights: np.ndarray,
    input_means: np.ndarray,
    precisions: np.ndarray,
    output_means: np.ndarray,
    gains: np.ndarray,
    residuals: np.ndarray,
    ridge: np.ndarray,
    shared: bool,
    logs: np.ndarray,
    component: np.ndarray,
    moments: np.ndarray,
    mean: np.ndarray,
    covariance: np.ndarray,
) -> None:
    """Conditional mean and covariance of the output given ``query``, fused over the frames.

    Both are NaN where a frame's conditional covariance is not definite.

    ``logs`` (P, K), ``component`` (K, o) and ``moments`` (4, o, o) are working memory.
    """
    n_frames, n_components, n_inputs = input_means.shape
    n_outputs = output_means.shape[2]
    local, inverse, precision = moments[0], moments[1], moments[2]
    centre, weighted = moments[3, 0], np.zeros(n_outputs)
    precision[:] = 0.0
    log_densities(query, log_weights, input_means, precisions, shared, logs)
    for p in range(n_frames):
        largest = logs[p].max()
        total = 0.0
        for k in range(n_components):
            logs[p, k] = np.exp(logs[p, k] - largest)
            total += logs[p, k]
        for o in range(n_outputs):
            centre[o] = 0.0
        for k in range(n_components):
            weight = logs[p, k] / total
            for o in range(n_outputs):
                value = output_means[p, k, o]
                for i in range(n_inputs):
                    value += gains[p, k, o, i] * (query[i] - input_means[p, k, i])
                component[k, o] = value
                centre[o] += weight * value
        local[:] = ridge[p]
        for k in range(n_components):
            weight = logs[p, k] / total
            for o in range(n_outputs):
                for q in range(o + 1):
                    spread = (component[k, o] - centre[o]) * (component[k, q] - centre[q])
                    value = weight * (residuals[p, k, o, q] + spread)
                    local[o, q] += value
                    if q != o:
                        local[q, o] += value
        if n_frames == 1:
            mean[:] = centre
            covariance[:] = local
            return
        if np.isnan(invert_definite(local, inverse)):
            mean[:] = np.nan
            covariance[:] = np.nan
            return
        for o in range(n_outputs):
            for q in range(n_outputs):
                precision[o, q] += inverse[o, q]
                weighted[o] += inverse[o, q] * centre[q]
    if np.isnan(invert_definite(precision, covariance)):
        mean[:] = np.nan
        covariance[:] = np.nan
        return
    for o in range(n_outputs):
        value = 0.0
        for q in range(n_outputs):
            value += covariance[o, q] * weighted[q]
        mean[o] = value


@njit(cache=True, error_model="numpy")
def regress(
    queries: np.ndarray,
    log_weights: np.ndarray,
    input_means: np.ndarray,
    precisions: np.ndarray,
    output_means: np.ndarray,
    gains: np.ndarray,
    residuals: np.ndarray,
    ridge: np.ndarray,
    shared: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """Means (T, o) and covariances (T, o, o) for queries (T, i)."""
    n_frames, n_components, n_outputs = output_means.shape
    logs = np.empty((n_frames, n_components))
    component = np.empty((n_components, n_outputs))
    moments = np.empty((4, n_outputs, n_outputs))
    means = np.empty((len(queries), n_outputs))
    covariances = np.empty((len(queries), n_outputs, n_outputs))
    for t in range(len(queries)):
        condition(
            queries[t],
            log_weights,
            input_means,
            precisions,
            output_means,
            gains,
            residuals,
            ridge,
            shared,
            logs,
            component,
            moments,
            means[t],
            covariances[t],
        )
    return means, covariances


@njit(cache=True, error_model="numpy")
def integrate(
    start: np.ndarray,
    log_weights: np.ndarray,
    input_means: np.ndarray,
    precisions: np.ndarray,
    output_means: np.ndarray,
    gains: np.ndarray,
    residuals: np.ndarray,
    ridge: np.ndarray,
    shared: bool,
    max_steps: int,
    min_steps: int,
    longest_step: float,
    rest_step: float,
    rest_count: int,
    end: np.ndarray,
    end_radius: float,
) -> np.ndarray:
    """The path x_{t+1} = x_t + E[dx | x_t], no step longer than ``longest_step``.

    It ends, from step ``min_steps`` on, before a step that leads away from ``end`` from within
    ``end_radius`` of it, or after ``rest_count`` steps in a row shorter than ``rest_step``; else
    after ``max_steps``.
    """
    n_frames, n_components, n_outputs = output_means.shape
    logs = np.empty((n_frames, n_components))
    component = np.empty((n_components, n_outputs))
    moments = np.empty((4, n_outputs, n_outputs))
    step = np.empty(n_outputs)
    covariance = np.empty((n_outputs, n_outputs))
    path = np.empty((max_steps + 1, n_outputs))
    path[0] = start
    quiet = 0
    for t in range(max_steps):
        condition(
            path[t],
            log_weights,
            input_means,
            precisions,
            output_means,
            gains,
            residuals,
            ridge,
            shared,
            logs,
            component,
            moments,
            step,
            covariance,
        )
        length = 0.0
        distance = 0.0
        away = 0.0
        for o in range(n_outputs):
            offset = path[t, o] - end[o]
            length += step[o] ** 2
            distance += offset**2
            away += offset * step[o]
        length = np.sqrt(length)
        if away > 0.0 and distance < end_radius**2 and t >= min_steps:
            return path[: t + 1]
        scale = longest_step / length if length > longest_step else 1.0
        for o in range(n_outputs):
            path[t + 1, o] = path[t, o] + scale * step[o]
        quiet = quiet + 1 if length < rest_step else 0
        if quiet >= rest_count and t + 1 >= min_steps:
            return path[: t + 2]
    return path
