"""Policies by name: built in, installed by others, or a class to import.

A policy of this package is one file in its folder, with ``POLICIES``: configurations by name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points, packages_distributions, version
from pkgutil import iter_modules
from typing import Any, Protocol, cast, runtime_checkable

from dressing_sim import policies
from dressing_sim.checks import of_kind, shown
from dressing_sim.errors import InvalidInputError, one_line
from dressing_sim.inputs import inputs_of
from dressing_sim.learning import Policy
from dressing_sim.path import takes_seed
from dressing_sim.policies.confidence import judged, split_judged
from dressing_sim.policies.expert import EXPERT, EXPERT_REPLAN
from dressing_sim.policies.hyperparameters import changed, keyword_arguments, split_name
from dressing_sim.provenance import source_hash

#: Other packages register policies of theirs under this entry-point group.
ENTRY_POINT_GROUP = "dressing_sim.policies"

#: What `dressing-sim learn` uses and the name ``default`` stands for.
DEFAULT = "transport"


@runtime_checkable
class PolicyConfig(Protocol):
    """The hyper-parameters of a policy, a frozen dataclass, and how it is built.

    Fields that its name decides may be named in a class attribute ``fixed``.
    """

    def make(self, seed: int = 0) -> Policy:
        """A new policy, not yet fitted; the seed is of the randomness of learning."""


@cache
def built_in() -> Mapping[str, PolicyConfig]:
    """The configurations of this package's policies by name."""
    found: dict[str, PolicyConfig] = {}
    for module in sorted(one.name for one in iter_modules(policies.__path__)):
        found |= getattr(import_module(f"{policies.__name__}.{module}"), "POLICIES", {})
    return found


def known_name(name: str) -> str:
    """The name, perhaps with more after it, with what ``default`` stands for in its place."""
    of_kind(name, str, "a policy", "the name of one, or module:Class")
    stem, mark, text = name.partition("?")
    return f"{DEFAULT}{mark}{text}" if stem == "default" else name


def learns(name: str) -> bool:
    """Whether a policy of this name needs demonstrations."""
    return split_name(name)[0] not in (EXPERT, EXPERT_REPLAN)


def make_policy(name: str, seed: int = 0) -> Policy:
    """A new policy, not yet fitted.

    Args:
        name: A built-in name, ``default``, the name of an installed entry point, or
            ``module:Class``. Hyper-parameters may follow: ``tp-gmm-rf?end_radius=0&snr_db=20``;
            a class of others is given them as keyword arguments, read by its annotations. Of any
            policy ``judge=FILE`` is a `Judge` of its paths, and ``abstain=P`` the least probability
            with which it tries, see `dressing_sim.policies.confidence`.
        seed: Of the randomness of learning; given to a class of others if it takes ``seed``.

    Raises:
        InvalidInputError: There is no such policy or hyper-parameter, or the policy lacks `fit` or
            `generate`.
    """
    plain, judge = split_judged(known_name(name))
    stem, text = split_name(plain)
    config = built_in().get(stem)
    factory = None if config is not None else _find(stem)
    try:
        if config is not None:
            fixed: frozenset[str] = getattr(config, "fixed", frozenset())
            ours = (config if text is None else changed(config, text, fixed)).make(seed)
            return ours if judge is None else judged(ours, plain, *judge)
        assert factory is not None
        policy = _made(factory, text, seed)
        acts = all(callable(getattr(policy, name, None)) for name in ("fit", "act"))
        if not (acts or isinstance(policy, Policy)):
            raise InvalidInputError(
                "valid is a class with fit(demonstrations) and generate(frames, start), or with "
                "act(observation)"
            )
        inputs_of(policy)
        theirs = cast(Policy, policy)
        return theirs if judge is None else judged(theirs, plain, *judge)
    except InvalidInputError as error:
        raise InvalidInputError(f"policy {shown(name, 400)}: {error}") from error


def _made(factory: Callable[..., object], text: str | None, seed: int) -> object:
    """What somebody else's class makes: a policy, or a configuration that does."""
    chosen = {} if text is None else keyword_arguments(factory, text)
    if takes_seed(factory):
        chosen["seed"] = seed
    try:
        made = factory(**chosen)
    except TypeError as error:
        raise InvalidInputError(
            f"{' '.join(str(error).split())}; valid is a class whose arguments have defaults or "
            "are given after a '?'"
        ) from error
    return made.make(seed) if isinstance(made, PolicyConfig) else made


def policy_origin(name: str) -> dict[str, str | None]:
    """Hash of the source of other people's policy, and version of the distribution it is from."""
    found = _find(split_name(known_name(name))[0])
    providers = packages_distributions().get(found.__module__.partition(".")[0], ())
    return {"sha256": source_hash(found), "version": version(providers[0]) if providers else None}


def _find(name: str) -> type:
    """A class with the methods of a policy, or a configuration that makes one."""
    installed = {point.name: point for point in entry_points(group=ENTRY_POINT_GROUP)}
    if name not in installed and ":" not in name:
        valid = ", ".join(dict.fromkeys([EXPERT, "default", *built_in(), *installed]))
        raise InvalidInputError(
            f"unknown policy {shown(name, 400)}; valid is one of module:Class, {valid}"
        )
    try:
        found = installed[name].load() if name in installed else _imported(name)
    except (Exception, SystemExit) as error:  # whatever a module of somebody else's does
        raise InvalidInputError(f"policy {name!r}: {one_line(str(error))}") from error
    methods = {one for one in ("fit", "generate", "act", "make") if hasattr(found, one)}
    if not isinstance(found, type) or not ("fit" in methods or "make" in methods):
        raise InvalidInputError(
            f"policy {name!r}: not a class with fit(demonstrations) and "
            "generate(frames, start), or with act(observation)"
        )
    return found


def _imported(name: str) -> Any:
    module, _, attribute = name.partition(":")
    if module.endswith(".py"):
        raise ImportError(f"valid is without .py, {module.removesuffix('.py')}:{attribute}")
    return getattr(import_module(module), attribute)
