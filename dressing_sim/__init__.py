"""dressing_sim: a simulated dressing-robot benchmark and its learning-from-demonstration library.

The public names below are loaded on first use, so that ``import dressing_sim`` and
``import dressing_sim.learning`` stay light: they need neither MuJoCo nor Pinocchio. Their types are
in ``__init__.pyi``, which a test holds against what is here.
"""

from importlib import import_module

__version__ = "0.2.0"

_PUBLIC = {
    "Demonstration": "dressing_sim.episode.demonstration",
    "Dressing": "dressing_sim.episode.dressing",
    "EpisodeConfig": "dressing_sim.episode.config",
    "Operator": "dressing_sim.episode.operator",
    "Outcome": "dressing_sim.episode.outcome",
    "Path": "dressing_sim.path",
    "Policy": "dressing_sim.learning",
    "Posture": "dressing_sim.arm",
    "demonstrate": "dressing_sim.by_name",
    "dress": "dressing_sim.by_name",
    "evaluate": "dressing_sim.benchmark.studies.evaluate",
    "load_demonstrations": "dressing_sim.episode.demonstration",
    "load_suite": "dressing_sim.suites.suites",
    "record": "dressing_sim.by_name",
    "sample_postures": "dressing_sim.suites.distribution",
    "save_demonstrations": "dressing_sim.episode.demonstration",
}

__all__ = sorted([*_PUBLIC, "__version__"])


def __getattr__(name: str) -> object:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'dressing_sim' has no attribute {name!r}")
    return getattr(import_module(_PUBLIC[name]), name)


def __dir__() -> list[str]:
    return __all__
