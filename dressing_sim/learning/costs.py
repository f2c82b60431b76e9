"""How far reproductions are from what was demonstrated: the cost J of Algorithm 1."""

from collections.abc import Sequence

import numpy as np

from dressing_sim.checks import listed, real_array
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.dtw import dtw_distance
from dressing_sim.learning.frame import FloatArray


def rms_cost(reproductions: Sequence[FloatArray], demonstrated: Sequence[FloatArray]) -> float:
    """Cost of a time-based model: mean over the demonstrations of sqrt(sum_t ||y_t - xi_t||^2).

    Not divided by the number of samples: that is how the paper's Table I was computed, where
    equation 7 prints (1 / mu) sum_i sqrt(||y_i - xi_i||).

    Args:
        reproductions: paths y, each of the shape (T, p) of its counterpart.
        demonstrated: paths xi.

    Returns:
        The cost, in the unit of the positions.

    Raises:
        InvalidInputError: no path, one that is not finite, or shapes that differ.
    """
    errors = []
    for index, (path, expert) in enumerate(_pairs(reproductions, demonstrated)):
        if path.shape != expert.shape:
            raise InvalidInputError(
                f"reproduction {index} has the shape {path.shape}, its demonstration {expert.shape}"
            )
        errors.append(np.linalg.norm(path - expert))
    return float(np.mean(errors))


def dtw_cost(reproductions: Sequence[FloatArray], demonstrated: Sequence[FloatArray]) -> float:
    """Cost of a trajectory-based model: mean normalised warping distance (paper, equation 10).

    Args:
        reproductions: paths (N_i, p).
        demonstrated: paths (M_i, p), of any lengths.

    Returns:
        The cost, in the unit of the positions.

    Raises:
        InvalidInputError: no path, or paths that cannot be warped.
    """
    pairs = _pairs(reproductions, demonstrated)
    return float(np.mean([dtw_distance(path, expert) for path, expert in pairs]))


def _pairs(
    reproductions: Sequence[FloatArray], demonstrated: Sequence[FloatArray]
) -> list[tuple[FloatArray, FloatArray]]:
    """Each reproduction with its demonstration, as arrays."""
    paths, experts = (
        listed(some, "the paths of a cost", "a sequence of paths")
        for some in (reproductions, demonstrated)
    )
    if len(experts) == 0 or len(paths) != len(experts):
        raise InvalidInputError(
            f"a cost needs one reproduction a demonstration and at least one, "
            f"not {len(paths)} and {len(experts)}"
        )
    arrays = (
        [real_array(path, None, "a cost: a path has") for path in some] for some in (paths, experts)
    )
    return list(zip(*arrays, strict=True))
