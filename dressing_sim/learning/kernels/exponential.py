"""An exponential that vectorises; a call of the C library's does not, and is half of an EM step."""

import numpy as np

from dressing_sim.compiled import compiled

NEGLIGIBLE = -40.0  # exp(-40) = 4e-18 of the largest term is lost in double precision anyway
INVERSE_LOG_2 = 1.4426950408889634
LOG_2_HIGH = 0.6931471803691238  # log 2 in two parts, the first with trailing zeros (Cody-Waite)
LOG_2_LOW = 1.9082149292705877e-10


@compiled
def exp_below_zero(values: np.ndarray, shift: np.ndarray, size: int) -> None:
    """exp(values - shift) in place for the first ``size``; 0 where the difference is negligible.

    exp(x) = 2^k exp(r), |r| <= log(2) / 2, with the Taylor series of degree 12: relative error
    below 2e-15. The differences must not be positive.
    """
    for n in range(size):
        difference = values[n] - shift[n]
        x = max(difference, NEGLIGIBLE)
        k = np.floor(x * INVERSE_LOG_2 + 0.5)
        r = x - k * LOG_2_HIGH - k * LOG_2_LOW
        p = 1.0 / 479001600.0
        p = p * r + 1.0 / 39916800.0
        p = p * r + 1.0 / 3628800.0
        p = p * r + 1.0 / 362880.0
        p = p * r + 1.0 / 40320.0
        p = p * r + 1.0 / 5040.0
        p = p * r + 1.0 / 720.0
        p = p * r + 1.0 / 120.0
        p = p * r + 1.0 / 24.0
        p = p * r + 1.0 / 6.0
        p = p * r + 0.5
        p = p * r + 1.0
        p = p * r + 1.0
        # 2^k by writing k into the exponent of a double.
        power = np.int64((np.int64(k) + np.int64(1023)) << np.int64(52)).view(np.float64)
        values[n] = p * power if difference > NEGLIGIBLE else 0.0
