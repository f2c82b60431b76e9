"""The picture on the sleeve: a knitted fabric, its hems and its seam."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Pixels around and along.
SIZE = (1024, 512)

#: Pixels from row to row of the knit, and from stitch to stitch.
_PITCH = (8, 6)

_BLUE = np.array([62.0, 112.0, 178.0])


def weave(hem: float) -> NDArray[np.uint8]:
    """A picture (along, around, 3) of the unrolled sleeve; it goes on at its left and right.

    Args:
        hem: Width of the hems, relative to the sleeve's length.
    """
    around, along = SIZE
    v, u = np.mgrid[0:along, 0:around]
    # Stocking stitch: columns of V, whose two legs lean against each other.
    leg = np.abs((u % _PITCH[0]) - 0.5 * _PITCH[0]) / (0.5 * _PITCH[0])
    height = np.sin(2.0 * np.pi * (v / _PITCH[1] + 0.5 * leg))
    light = 0.95 + 0.05 * height - 0.10 * (leg > 0.85)
    # Yarn is never even: streaks along the rows.
    streaks = np.random.default_rng(0).normal(size=(along // 2, around // 16))
    light += 0.018 * np.kron(streaks, np.ones((2, 16)))
    from_end = np.minimum(v, along - 1 - v) / along
    light *= np.where(from_end < hem, 0.90, 1.0)
    light *= np.where(np.abs(from_end - hem) < 0.005, 0.72, 1.0)
    dashes = (np.abs(from_end - 0.82 * hem) < 0.005) & (u % 12 < 8)
    light = np.where(dashes, 1.25, light)
    # The seam runs along the lower side, where the sleeve was sewn together.
    light *= np.where(np.abs(u - 0.5 * around) < 3.0, 0.78, 1.0)
    return np.clip(light[..., None] * _BLUE, 0.0, 255.0).astype(np.uint8)
