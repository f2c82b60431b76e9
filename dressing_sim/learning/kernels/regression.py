"""Gaussian mixture regression in several frames at once, and its integration to a path.

A ``mixture`` is a `dressing_sim.learning.gmr.Regression` of P views, K components, i inputs and o
outputs; a ``memory`` is what `memory_of` sets aside for it.
"""

from typing import Any

import numpy as np

from dressing_sim.compiled import compiled
from dressing_sim.learning.kernels.linalg import invert_definite


@compiled
def memory_of(mixture: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Working memory: logs (P, K), components' means (K, o), moments (3, o, o), vectors (2, o)."""
    n_frames, n_components, n_outputs = mixture.output_means.shape
    return (
        np.empty((n_frames, n_components)),
        np.empty((n_components, n_outputs)),
        np.empty((3, n_outputs, n_outputs)),
        np.empty((2, n_outputs)),
    )


@compiled
def log_densities(query: np.ndarray, mixture: Any, logs: np.ndarray) -> None:
    """log(pi_k N(query | input marginal of k)) of each frame into ``logs`` (P, K)."""
    n_frames, n_components, n_inputs = mixture.input_means.shape
    for p in range(n_frames):
        for k in range(n_components):
            mean = mixture.input_means[p, k]
            precision = mixture.precisions[p, k]
            distance = 0.0
            for i in range(n_inputs):
                row = 0.0
                for j in range(n_inputs):
                    row += precision[i, j] * (query[j] - mean[j])
                distance += row * (query[i] - mean[i])
            logs[p, k] = mixture.log_weights[p, k] - 0.5 * distance
    if mixture.shared:
        for k in range(n_components):
            total = 0.0
            for p in range(n_frames):
                total += logs[p, k]
            for p in range(n_frames):
                logs[p, k] = total


@compiled
def condition_view(
    p: int,
    query: np.ndarray,
    mixture: Any,
    weights: np.ndarray,
    component: np.ndarray,
    centre: np.ndarray,
    local: np.ndarray,
) -> None:
    """Conditional mean into ``centre`` (o,) and covariance into ``local`` (o, o) of view ``p``.

    ``weights`` (K,) holds the logarithms of the responsibilities, up to a constant, and is changed.
    """
    n_components, n_outputs = component.shape
    largest = weights.max()
    total = 0.0
    for k in range(n_components):
        weights[k] = np.exp(weights[k] - largest)
        total += weights[k]
    centre[:] = 0.0
    for k in range(n_components):
        weights[k] = weights[k] / total
        for o in range(n_outputs):
            value = mixture.output_means[p, k, o]
            for i in range(len(query)):
                value += mixture.gains[p, k, o, i] * (query[i] - mixture.input_means[p, k, i])
            component[k, o] = value
            centre[o] += weights[k] * value
    local[:] = mixture.ridge[p]
    for k in range(n_components):
        for o in range(n_outputs):
            for q in range(o + 1):
                spread = (component[k, o] - centre[o]) * (component[k, q] - centre[q])
                value = weights[k] * (mixture.residuals[p, k, o, q] + spread)
                local[o, q] += value
                if q != o:
                    local[q, o] += value


@compiled
def condition(
    query: np.ndarray, mixture: Any, memory: Any, mean: np.ndarray, covariance: np.ndarray
) -> None:
    """Conditional mean (o,) and covariance (o, o) of the output given ``query``, fused over views.

    Both are NaN where a view's conditional covariance is not definite.
    """
    logs, component, moments, vectors = memory
    local, inverse, precision = moments[0], moments[1], moments[2]
    centre, weighted = vectors[0], vectors[1]
    n_frames, n_outputs = len(logs), len(centre)
    precision[:] = 0.0
    weighted[:] = 0.0
    log_densities(query, mixture, logs)
    for p in range(n_frames):
        condition_view(p, query, mixture, logs[p], component, centre, local)
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


@compiled
def regress(queries: np.ndarray, mixture: Any) -> tuple[np.ndarray, np.ndarray]:
    """Means (T, o) and covariances (T, o, o) for queries (T, i)."""
    n_outputs = mixture.output_means.shape[2]
    memory = memory_of(mixture)
    means = np.empty((len(queries), n_outputs))
    covariances = np.empty((len(queries), n_outputs, n_outputs))
    for t in range(len(queries)):
        condition(queries[t], mixture, memory, means[t], covariances[t])
    return means, covariances


@compiled
def integrate(
    start: np.ndarray,
    mixture: Any,
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
    n_outputs = len(start)
    memory = memory_of(mixture)
    step = np.empty(n_outputs)
    covariance = np.empty((n_outputs, n_outputs))
    path = np.empty((max_steps + 1, n_outputs))
    path[0] = start
    quiet = 0
    for t in range(max_steps):
        condition(path[t], mixture, memory, step, covariance)
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
