"""Policies by name: built in, installed by others, or a class to import."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.metadata import entry_points

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Method, Policy
from dressing_sim.policies.paper import PaperSettings, settings_from_text, split_settings

#: The scripted operator; it sees the whole posture and learns nothing.
EXPERT = "expert"

#: Other packages register policies of theirs under this entry-point group.
ENTRY_POINT_GROUP = "dressing_sim.policies"

#: The paper's policies, and how Algorithm 1 makes synthetic demonstrations for each.
BUILT_IN: Mapping[str, Method | None] = {
    "tp-gmm": None,
    "tp-gmm-noise": "noise",
    "tp-gmm-rf": "rf",
    "tp-gmm-rf-noise": "rf+noise",
}

#: What `dressing-sim learn` uses and the name ``default`` stands for.
DEFAULT = "tp-gmm"


def known_name(name: str) -> str:
    """The name, perhaps with settings after it, with what ``default`` stands for in its place."""
    stem, mark, settings = name.partition("?")
    return f"{DEFAULT}{mark}{settings}" if stem == "default" else name


def is_built_in(name: str) -> bool:
    """Whether a name, perhaps with settings after it, is of a policy with `PaperSettings`."""
    return split_settings(known_name(name))[0] in BUILT_IN


def make_policy(name: str, seed: int = 0) -> Policy:
    """A new policy, not yet fitted.

    Args:
        name: A built-in name, ``default``, the name of an installed entry point, or
            ``module:Class`` with a class that needs no arguments but perhaps ``seed``. A built-in
            name may be followed by settings that differ from `PaperSettings`:
            ``tp-gmm-rf?position_floor=0.01&end_radius=0``.
        seed: Of the policy's own randomness; given to a class of others if it takes ``seed``.

    Raises:
        InvalidInputError: There is no such policy or setting, or the policy lacks `fit` or
            `generate`.
    """
    stem, settings = split_settings(known_name(name))
    if stem in BUILT_IN:
        try:
            chosen = PaperSettings() if settings is None else settings_from_text(settings)
            return chosen.policy(BUILT_IN[stem], seed)
        except InvalidInputError as error:
            raise InvalidInputError(f"policy {name!r}: {error}") from error
    factory = _find(stem)
    if settings is not None:
        raise InvalidInputError(
            f"policy {name!r}: {stem} takes no settings after '?'; valid for {', '.join(BUILT_IN)}"
        )
    try:
        policy = factory(seed=seed) if _takes_seed(factory) else factory()
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


def _find(name: str) -> Callable[..., object]:
    installed = {point.name: point for point in entry_points(group=ENTRY_POINT_GROUP)}
    if name in installed:
        factory: Callable[..., object] = installed[name].load()
        return factory
    if ":" in name:
        return _import(name)
    valid = ", ".join(["default", *BUILT_IN, *installed])
    raise InvalidInputError(f"unknown policy {name!r}; valid is one of {valid}, or module:Class")


def _takes_seed(factory: Callable[..., object]) -> bool:
    try:
        return "seed" in inspect.signature(factory).parameters
    except ValueError:  # a class written in C need not say what it takes
        return False


def _import(name: str) -> Callable[..., object]:
    module, _, attribute = name.partition(":")
    try:
        factory = getattr(import_module(module), attribute)
    except (ImportError, AttributeError, TypeError, ValueError) as error:
        raise InvalidInputError(f"policy {name!r}: {error}") from error
    if not callable(factory):
        raise InvalidInputError(f"policy {name!r}: not a class")
    return factory
