"""What is open in each policy: hyper-parameters and the ranges in which they are searched.

A range is where a user would look: from values that the sources use to where a method plainly
breaks. What a method's source fixes is no hyper-parameter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from dressing_sim.errors import InvalidInputError


@dataclass(frozen=True, slots=True)
class Span:
    """Numbers from low to high, evenly or, with `log`, evenly in their logarithm."""

    low: float
    high: float
    log: bool = False
    whole: bool = False

    def at(self, share: float) -> str:
        """The value at a share, 0 to 1, of the range, as text."""
        if self.whole:
            return str(min(int(self.high), int(self.low + share * (self.high - self.low + 1.0))))
        if self.log:
            return f"{self.low * (self.high / self.low) ** share:.3g}"
        return f"{self.low + share * (self.high - self.low):.3g}"


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several values."""

    values: tuple[str, ...]

    def at(self, share: float) -> str:
        """The value at a share, 0 to 1, of the list."""
        return self.values[min(len(self.values) - 1, int(share * len(self.values)))]


#: Ranges by a hyper-parameter's name.
Space: TypeAlias = Mapping[str, Span | Choice]

_TP_GMM: Space = {
    "n_components": Span(2, 8, whole=True),
    "position_floor": Span(1e-3, 0.3, log=True),
    "displacement_floor": Span(1e-3, 0.3, log=True),
    "relative_floor": Choice(("true",)),
    "fusion": Choice(("regression-then-product", "product-then-regression")),
    "end_radius": Span(0.0, 0.4),
    "aligned": Choice(("true",)),
    "clearance": Choice(("false", "true")),
}
_RANDOM: Space = {
    "angle_margin_deg": Span(0.0, 40.0),
    "translation_margin": Span(0.0, 0.6),
    "situations": Choice(("arms", "frames")),
}
_AUGMENTED: Space = {**_TP_GMM, "max_demonstrations": Span(3, 12, whole=True)}

_MIXTURE: Space = {"components": Span(2, 14, whole=True), "floor": Span(1e-5, 0.1, log=True)}
_INCREMENTAL: Space = {**_MIXTURE, "steps": Span(0, 60, whole=True)}

#: Of the rivals; `nearest`, `straight` and `via-oracle` are for reference, `warp` leaves nothing
#: open.
_RIVALS: Mapping[str, Space] = {
    "gmr-world": _MIXTURE,
    "gmr-frame": {**_MIXTURE, "frame": Choice(("first", "last"))},
    "dmp": {
        "weights": Span(5, 60, whole=True),
        "ridge": Span(1e-9, 1e-2, log=True),
        "demonstration": Choice(("mean", "nearest")),
        "smooth_scaling": Choice(("false", "true")),
    },
    "promp": {
        "weights": Span(5, 40, whole=True),
        "prior": Span(1e-5, 1.0, log=True),
        "via_points": Span(2, 8, whole=True),
    },
    "tp-gmr": _MIXTURE,
    "tp-gmr-learned": {
        **_MIXTURE,
        "updates": Span(5, 40, whole=True),
        "rollouts": Span(5, 20, whole=True),
        "exploration": Span(0.05, 2.0, log=True),
    },
    "tp-gmr-inferred": {**_MIXTURE, "ridge": Span(1e-4, 1.0, log=True)},
    "tp-gmr-bic": {
        "criterion": Choice(("bic", "dirichlet-process")),
        "most": Span(4, 25, whole=True),
        "floor": Span(1e-5, 0.1, log=True),
    },
    "ds-gmr": _MIXTURE,
    "frame-weighted": {
        "basis": Span(4, 30, whole=True),
        "reference": Choice(("first", "nearest")),
        "iterations": Span(5, 60, whole=True),
    },
    "tp-dmp": {**_MIXTURE, "width": Span(0.1, 2.0, log=True)},
    "kmp": {
        **_MIXTURE,
        "references": Span(15, 80, whole=True),
        "kernel": Span(1.0, 300.0, log=True),
        "trust": Span(0.01, 100.0, log=True),
        "spread": Span(1.0, 1000.0, log=True),
    },
    "tp-hsmm": {
        "states": Span(3, 20, whole=True),
        "floor": Span(1e-5, 0.1, log=True),
        "effort": Span(1e-7, 1e-1, log=True),
        "steps": Span(0, 60, whole=True),
    },
    "tp-gmr-generative": _INCREMENTAL,
    "tp-gmr-addition": _INCREMENTAL,
    "tp-gmr-direct": _INCREMENTAL,
    "gp-transport": {"reach": Span(0.1, 3.0, log=True), "noise": Span(1e-3, 0.3, log=True)},
    "vmp": {
        "basis": Span(5, 40, whole=True),
        "via_points": Span(0, 5, whole=True),
        "known": Span(0.3, 10.0, log=True),
    },
    "cnmp": {
        "hidden": Span(16, 128, whole=True),
        "steps": Span(500, 4000, whole=True),
        "rate": Span(1e-3, 2e-2, log=True),
        "observed": Span(2, 10, whole=True),
    },
}

#: Of the policies that can be searched.
SPACES: Mapping[str, Space] = {
    "tp-gmm": _TP_GMM,
    "tp-gmm-noise": {**_AUGMENTED, "snr_db": Span(15.0, 40.0)},
    "tp-gmm-rf": {**_AUGMENTED, **_RANDOM},
    "tp-gmm-rf-noise": {**_AUGMENTED, **_RANDOM, "snr_db": Span(15.0, 40.0)},
    "transport": {
        "slope_to_noise": Span(1.0, 20.0, log=True),
        "curvature": Span(0.2, 5.0, log=True),
        "length": Span(0.2, 1.0),
        "landmark_noise": Span(0.01, 0.2, log=True),
        "height": Span(0.05, 0.3),
        "ahead": Span(0.2, 0.8),
        "dip": Span(0.0, 0.6),
        "hand": Span(0.0, 0.35),
    },
    **_RIVALS,
}


def space_of(policy: str) -> Space:
    """The hyper-parameters that are searched, by a policy's name.

    Raises:
        InvalidInputError: Nothing is known to be open in it.
    """
    if policy not in SPACES:
        raise InvalidInputError(
            f"policy {policy!r} has no ranges to search in; valid is one of {', '.join(SPACES)}"
        )
    return SPACES[policy]


def named(policy: str, space: Space, shares: Sequence[float] | NDArray[np.float64]) -> str:
    """A policy's name with hyper-parameters at shares (d,), 0 to 1, of their ranges."""
    chosen = (f"{name}={one.at(s)}" for (name, one), s in zip(space.items(), shares, strict=True))
    return f"{policy}{'&' if '?' in policy else '?'}{'&'.join(chosen)}"
