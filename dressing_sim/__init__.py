"""dressing_sim: a simulated dressing-robot benchmark and its learning-from-demonstration library.

The public names below are loaded on first use, so that ``import dressing_sim.learning`` stays
light: it needs neither MuJoCo nor Pinocchio.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_PUBLIC = {
    "Demonstration": "dressing_sim.episode.demonstration",
    "Outcome": "dressing_sim.episode.rules",
    "Policy": "dressing_sim.learning",
    "Posture": "dressing_sim.arm",
    "demonstrate": "dressing_sim.episode.record",
    "dress": "dressing_sim.episode.record",
    "load_demonstrations": "dressing_sim.episode.demonstration",
    "load_suite": "dressing_sim.suites.suites",
    "sample_postures": "dressing_sim.suites.distribution",
    "save_demonstrations": "dressing_sim.episode.demonstration",
}

__all__ = sorted([*_PUBLIC, "__version__"])


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'dressing_sim' has no attribute {name!r}")
    return getattr(import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    return __all__
