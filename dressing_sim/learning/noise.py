"""White noise of a given signal-to-noise ratio."""

from numbers import Real
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import of_kind, one_of, real_array, real_number
from dressing_sim.learning.frame import FloatArray

NoiseReference = Literal["centred", "world"]

#: Beyond, either the noise or the signal is nothing but rounding [dB].
LARGEST_SNR_DB = 300.0


def noise_deviation(positions: ArrayLike, snr_db: float, reference: NoiseReference) -> float:
    """Standard deviation of the noise that has ``snr_db`` decibels against a path (T, p).

    sd^2 = P / 10^(snr / 10), P the power of the signal: its mean square over samples and
    coordinates.

    Args:
        positions: (T, p) in world coordinates.
        snr_db: signal-to-noise ratio in [dB]; infinity for no noise.
        reference: which signal. ``"centred"``: the positions less their mean over the path, which
            no shift or rotation of the world changes. ``"world"``: the positions themselves, so
            that the offset from the world's origin counts, as in the authors' code.

    Raises:
        InvalidInputError: another reference, or a ratio that is neither infinite nor within
            `LARGEST_SNR_DB`.
    """
    one_of(reference, "noise reference", get_args(NoiseReference))
    if not (isinstance(snr_db, Real) and snr_db == np.inf):
        real_number(
            snr_db, "the signal-to-noise ratio in decibels", -LARGEST_SNR_DB, LARGEST_SNR_DB
        )
    signal = real_array(positions, ("T", "p"), "a path to add noise to has", fewest=1)
    if reference == "centred":
        signal = signal - signal.mean(axis=0)
    return float(np.sqrt(np.mean(signal**2) / 10.0 ** (snr_db / 10.0)))


def add_white_noise(
    positions: ArrayLike,
    snr_db: float,
    rng: np.random.Generator,
    reference: NoiseReference = "centred",
) -> FloatArray:
    """A path (T, p) with Gaussian noise on every coordinate, see ``noise_deviation``."""
    signal = real_array(positions, ("T", "p"), "a path to add noise to has", fewest=1)
    of_kind(rng, np.random.Generator, "rng", "a random generator of numpy's")
    deviation = noise_deviation(signal, snr_db, reference)
    return signal + deviation * rng.standard_normal(signal.shape)
