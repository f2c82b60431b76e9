"""Policies by name: built in, installed by others, or a class to import."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from importlib import import_module
from importlib.metadata import entry_points

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Policy, TrajectoryTPGMM

#: The scripted operator; it sees the whole posture and learns nothing.
EXPERT = "expert"

#: Other packages register policies of theirs under this entry-point group.
ENTRY_POINT_GROUP = "dressing_sim.policies"

BUILT_IN: Mapping[str, Callable[[], Policy]] = {
    "tp-gmm": partial(TrajectoryTPGMM, n_components=4),
}

#: What `dressing-sim learn` uses and the name ``default`` stands for.
DEFAULT = "tp-gmm"


def make_policy(name: str) -> Policy:
    """A new policy, not yet fitted.

    Args:
        name: A built-in name, ``default``, the name of an installed entry point, or
            ``module:Class`` with a class that needs no arguments.

    Raises:
        InvalidInputError: There is no such policy, or it lacks `fit` or `generate`.
    """
    name = DEFAULT if name == "default" else name
    installed = {point.name: point for point in entry_points(group=ENTRY_POINT_GROUP)}
    if name in BUILT_IN:
        factory: Callable[[], object] = BUILT_IN[name]
    elif name in installed:
        factory = installed[name].load()
    elif ":" in name:
        factory = _import(name)
    else:
        valid = ", ".join(["default", *BUILT_IN, *installed])
        raise InvalidInputError(
            f"unknown policy {name!r}; valid is one of {valid}, or module:Class"
        )
    try:
        policy = factory()
    except TypeError as error:
        raise InvalidInputError(
            f"policy {name!r}: {error}; valid is a class that needs no arguments"
        ) from error
    if not isinstance(policy, Policy):
        raise InvalidInputError(
            f"policy {name!r}: valid is a class with fit(demonstrations) and "
            "generate(frames, start)"
        )
    return policy


def _import(name: str) -> Callable[[], object]:
    module, _, attribute = name.partition(":")
    try:
        factory = getattr(import_module(module), attribute)
    except (ImportError, AttributeError, TypeError, ValueError) as error:
        raise InvalidInputError(f"policy {name!r}: {error}") from error
    if not callable(factory):
        raise InvalidInputError(f"policy {name!r}: not a class")
    return factory
