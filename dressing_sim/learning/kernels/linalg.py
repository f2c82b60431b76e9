"""Small dense linear algebra, written as loops: a LAPACK call costs more than a 3 x 3 factor."""

import numpy as np

from dressing_sim.compiled import compiled


@compiled
def cholesky(matrix: np.ndarray, factor: np.ndarray) -> bool:
    """Lower factor L with L L^T = matrix, into ``factor``; False where it is not definite."""
    n = matrix.shape[0]
    for i in range(n):
        for j in range(i + 1):
            total = matrix[i, j]
            for m in range(j):
                total -= factor[i, m] * factor[j, m]
            if i == j:
                if not total > 0.0:
                    return False
                factor[i, i] = np.sqrt(total)
            else:
                factor[i, j] = total / factor[j, j]
        for j in range(i + 1, n):
            factor[i, j] = 0.0
    return True


@compiled
def invert_lower(factor: np.ndarray, inverse: np.ndarray) -> None:
    """Inverse of a lower triangular matrix, into ``inverse``."""
    n = factor.shape[0]
    for j in range(n):
        for i in range(j):
            inverse[i, j] = 0.0
        inverse[j, j] = 1.0 / factor[j, j]
        for i in range(j + 1, n):
            total = 0.0
            for m in range(j, i):
                total -= factor[i, m] * inverse[m, j]
            inverse[i, j] = total / factor[i, i]


@compiled
def invert_definite(matrix: np.ndarray, inverse: np.ndarray) -> float:
    """Inverse of a symmetric positive definite matrix, into ``inverse``.

    Returns the logarithm of the determinant, or NaN where the matrix is not definite.
    """
    n = matrix.shape[0]
    factor = np.empty((n, n))
    lower = np.empty((n, n))
    if not cholesky(matrix, factor):
        return np.nan
    invert_lower(factor, lower)
    log_determinant = 0.0
    for i in range(n):
        log_determinant += 2.0 * np.log(factor[i, i])
        for j in range(i + 1):
            total = 0.0
            for m in range(i, n):
                total += lower[m, i] * lower[m, j]
            inverse[i, j] = total
            inverse[j, i] = total
    return log_determinant
