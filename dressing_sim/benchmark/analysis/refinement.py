"""What a quantity tends to as a simulation is refined, and how far it still is from that.

Numbers in, numbers out; the procedure of Celik et al. 2008 (Journal of Fluids Engineering 130,
078001), after Roache.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from dressing_sim.errors import InvalidInputError

#: Roache's factors of safety: with an order observed on three levels, and with none.
SAFETY, SAFETY_UNKNOWN = 1.25, 3.0

#: An observed order beyond these tells of noise, not of the discretisation.
LEAST_ORDER, GREATEST_ORDER = 0.2, 8.0


@dataclass(frozen=True, slots=True)
class Refinement:
    """How a quantity depends on the size of cells or steps.

    Attributes:
        order: Observed order p of the error, ``c h^p``; None where the three values do not tell
            one, as they rise and fall, or change ever more.
        limit: Richardson's extrapolation to size zero; the finest value where there is no order.
        index: Grid convergence index of the finest level, its relative error with a factor of
            safety, as a share.
    """

    order: float | None
    limit: float
    index: float


def refine(sizes: Sequence[float], values: Sequence[float]) -> Refinement:
    """The order, the limit and the error of a quantity on three levels.

    Args:
        sizes: Of cells or steps, the finest first.
        values: The quantity on each level.

    Raises:
        InvalidInputError: Not three sizes above zero that grow, or not three finite values.
    """
    h, f = np.asarray(sizes, dtype=float), np.asarray(values, dtype=float)
    if h.shape != (3,) or not (0.0 < h[0] < h[1] < h[2] < np.inf):
        raise InvalidInputError(f"sizes are {list(sizes)}, valid are three above zero that grow")
    if f.shape != (3,) or not np.isfinite(f).all():
        raise InvalidInputError(f"values are {list(values)}, valid are three finite numbers")
    near, far = f[1] - f[0], f[2] - f[1]
    scale = abs(f[0]) or 1.0
    if near == 0.0:
        return Refinement(None, float(f[0]), 0.0)
    order = _order(h, far / near)
    if order is None:
        return Refinement(None, float(f[0]), float(SAFETY_UNKNOWN * abs(near) / scale))
    left = near / ((h[1] / h[0]) ** order - 1.0)
    return Refinement(order, float(f[0] - left), float(SAFETY * abs(left) / scale))


def _order(h: NDArray[np.float64], ratio: float) -> float | None:
    """The p of ``(h3^p - h2^p) / (h2^p - h1^p) = ratio``, which grows with p; None if beyond."""
    second, third = h[1:] / h[0]

    def excess(p: float) -> float:
        return float((third**p - second**p) - ratio * (second**p - 1.0))

    if excess(LEAST_ORDER) > 0.0 or excess(GREATEST_ORDER) < 0.0:
        return None
    return float(brentq(excess, LEAST_ORDER, GREATEST_ORDER))
