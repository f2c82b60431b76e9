"""Learned policies in files: those of the library, and those that know an arm."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Policy, load_model, save_model
from dressing_sim.learning.storage import Storable
from dressing_sim.policies.rivals import RivalPolicy
from dressing_sim.policies.transported import TransportPolicy

#: Policies that can be saved besides those of `dressing_sim.learning`, by what files call them.
KINDS: Mapping[str, type[Storable]] = {
    "transport": TransportPolicy,
    "rival": RivalPolicy,
}


def save_policy(policy: Storable, path: str | Path) -> Path:
    """Save a fitted policy; returns the path.

    Raises:
        InvalidInputError: A policy of another kind, or one that is not fitted.
    """
    return save_model(policy, path, KINDS)


def load_policy(path: str | Path) -> Policy:
    """The policy that `save_policy` wrote: it generates the same paths, bit for bit.

    Raises:
        InvalidInputError: No such file, not a saved policy, or one whose parts do not fit together.
    """
    loaded = load_model(path, KINDS)
    if not isinstance(loaded, Policy):
        raise InvalidInputError(f"policy {path}: holds a model that cannot generate a path")
    return loaded
