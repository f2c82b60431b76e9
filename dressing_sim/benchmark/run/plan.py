"""What a run consists of, worked out before it starts: postures, episodes and all their seeds."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import Entry, Json, Protocol
from dressing_sim.checks import of_kind, shown, whole_number
from dressing_sim.config import from_plain, to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.demonstration import load_demonstrations
from dressing_sim.episode.variation import check_factors, vary
from dressing_sim.errors import InvalidInputError
from dressing_sim.inputs import inputs_of
from dressing_sim.policies.expert import operator_of
from dressing_sim.policies.host import PolicyLimits
from dressing_sim.policies.hosted import hosted_policy
from dressing_sim.policies.hyperparameters import split_name
from dressing_sim.policies.registry import learns
from dressing_sim.provenance import versions
from dressing_sim.seeds import derived_seed
from dressing_sim.suites.people import as_person, load_person
from dressing_sim.suites.suites import load_suite


@dataclass(frozen=True, slots=True)
class Job:
    """One episode to be run.

    Attributes:
        index: Its place in the protocol: all test postures of the first entry, then of the next.
        entry: Row of the protocol.
        posture: The arm, before variation.
        demonstration_set: Which set of demonstrations the policy learned from.
        seed: Of the operator's variability.
        variation_seed: Of what is drawn anew for this episode.
    """

    index: int
    entry: Entry
    posture: Posture
    demonstration_set: int
    seed: int
    variation_seed: int

    def situation(self, config: EpisodeConfig) -> tuple[Posture, EpisodeConfig, Mapping[str, Any]]:
        """Posture and config with this episode's variation, and what was drawn by factor."""
        varied = vary(self.posture, config, self.entry.variation, self.variation_seed)
        return varied.posture, varied.config, varied.drawn


@dataclass(frozen=True, slots=True)
class Plan:
    """A protocol with everything that its results depend on.

    Attributes:
        protocol: What to measure.
        seed: Of the operator's variability, in demonstrations and where the expert is tested, of
            the policies' own randomness, and of variation.
        config: World, robot and rules.
        tested: Test postures.
        demonstrated: Postures to demonstrate on, by the name that entries use.
        options: What the study alone needs to know, plain values.
        policy_limits: What other people's policies may use.
        own: Demonstrations of the user's, a checksum by name; nobody demonstrates these.
        own_files: Where they are, until the run has them in its folder.
    """

    protocol: Protocol
    seed: int
    config: EpisodeConfig
    tested: tuple[Posture, ...]
    demonstrated: Mapping[str, tuple[Posture, ...]]
    options: Mapping[str, Json] = field(default_factory=dict)
    policy_limits: PolicyLimits = field(default_factory=PolicyLimits)
    own: Mapping[str, str] = field(default_factory=dict)
    own_files: Mapping[str, Path] = field(default_factory=dict, compare=False)

    @property
    def jobs(self) -> list[Job]:
        """All episodes in their order.

        Rows are paired: an episode's seeds depend on its posture, not on its row.
        """
        return [
            Job(
                index=row * len(self.tested) + column,
                entry=entry,
                posture=posture,
                demonstration_set=column % self.protocol.demonstration_sets,
                seed=posture_seed(self.seed, posture),
                variation_seed=variation_seed(self.seed, posture),
            )
            for row, entry in enumerate(self.protocol.entries)
            for column, posture in enumerate(self.tested)
        ]

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a file, with the versions of all that a result depends on."""
        return {
            "protocol": {
                **to_plain(self.protocol),
                "entries": [to_plain(entry) for entry in self.protocol.entries],
            },
            "seed": self.seed,
            "episode": to_plain(self.config),
            "tested": [posture.to_dict() for posture in self.tested],
            "demonstrated": {
                name: [posture.to_dict() for posture in postures]
                for name, postures in self.demonstrated.items()
            },
            "options": dict(self.options),
            "policy_limits": to_plain(self.policy_limits),
            "own_demonstrations": dict(self.own),
            "versions": versions(),
        }

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Plan:
        """The inverse of `to_dict`, but for the versions; damage is an InvalidInputError."""
        try:
            entries = tuple(from_plain(Entry, entry) for entry in values["protocol"]["entries"])
            return cls(
                protocol=from_plain(Protocol, {**values["protocol"], "entries": entries}),
                seed=whole_number(values["seed"], "config of a run: seed"),
                config=from_plain(EpisodeConfig, values["episode"]),
                tested=tuple(map(Posture.from_dict, values["tested"])),
                demonstrated={
                    name: tuple(map(Posture.from_dict, postures))
                    for name, postures in values["demonstrated"].items()
                },
                options=dict(values["options"]),
                policy_limits=from_plain(PolicyLimits, values.get("policy_limits", {})),
                own=_checksums(values.get("own_demonstrations", {})),
            )
        except (KeyError, TypeError, AttributeError) as error:
            raise InvalidInputError(f"config of a run: missing or damaged ({error})") from error


def _checksums(values: Mapping[str, Any]) -> dict[str, str]:
    """Checksums by name, of which files' names are made."""
    of_kind(values, Mapping, "config of a run: own_demonstrations", "checksums by name")
    for value in values.values():
        if not (isinstance(value, str) and re.fullmatch("[0-9a-f]{8,128}", value)):
            raise InvalidInputError(f"config of a run: {shown(value)}, valid is a checksum")
    return dict(values)


def make_plan(
    protocol: Protocol,
    seed: int = 0,
    config: EpisodeConfig | None = None,
    options: Mapping[str, Json] | None = None,
    policy_limits: PolicyLimits | None = None,
    demonstrations: Path | None = None,
) -> Plan:
    """Look up everything that a protocol names, so that mistakes show before anything runs.

    Args:
        protocol: What to measure.
        seed: See `Plan`.
        config: World, robot and rules.
        options: What the study alone needs to know.
        policy_limits: What other people's policies may use.
        demonstrations: File of demonstrations that all policies learn from, instead of the
            protocol's.

    Raises:
        InvalidInputError: An unknown suite, policy or factor of variation, or no rows.
    """
    own, own_files, known = {}, {}, {}
    if demonstrations is not None:
        recorded = load_demonstrations(demonstrations)
        checksum = hashlib.sha256(demonstrations.read_bytes()).hexdigest()
        # The same wherever the file is, and another one for other demonstrations.
        name = f"{demonstrations.stem}@{checksum[:8]}"
        own, own_files = {name: checksum}, {name: demonstrations}
        known[name] = tuple(one.posture for one in recorded)
        protocol = protocol.with_demonstrations(name)
    if not protocol.entries:
        raise InvalidInputError(f"protocol {protocol.name!r} has no rows; valid is one or more")
    entries = []
    for entry in protocol.entries:
        check_factors(entry.variation)
        policy = hosted_policy(entry.policy, limits=policy_limits)
        entries.append(replace(entry, inputs=inputs_of(policy)))
        if learns(entry.policy) and entry.demonstrations is None:
            raise InvalidInputError(
                f"protocol {protocol.name!r}: policy {entry.policy!r} has nothing to learn "
                "from; valid is a suite of demonstrations"
            )
    protocol = replace(protocol, entries=tuple(entries))
    suites = dict.fromkeys(e.demonstrations for e in protocol.entries if e.demonstrations)
    for name in suites.keys() - known:
        operator_of(style_of(name))
    return Plan(
        protocol,
        seed,
        config or EpisodeConfig(),
        tuple(load_suite(protocol.suite)),
        {n: known[n] if n in known else _postures(n) for n in suites},
        options or {},
        policy_limits or PolicyLimits(),
        own,
        own_files,
    )


def style_of(demonstrations: str) -> str:
    """How the operator demonstrates: in ``case_a?speed=0.16`` what stands after the ``?``.

    The text is as for `dressing_sim.policies.expert.operator_of`: empty for the usual style.
    """
    return split_name(demonstrations)[1] or ""


def _postures(demonstrations: str) -> tuple[Posture, ...]:
    return tuple(load_suite(split_name(demonstrations)[0]))


def dressing_person(plan: Plan, person: str | None) -> Plan:
    """The same plan with the arm of a person under test, see `load_person`, or as it is."""
    if person is None:
        return plan
    return replace(plan, tested=tuple(as_person(plan.tested, load_person(person))))


def posture_seed(seed: int, posture: Posture) -> int:
    """Seed of the operator on a posture, so that no two postures get the same variability.

    It depends on both arguments and on nothing else: not on the order, nor on the other postures.
    """
    return derived_seed(f"{seed} {posture.name}")


def demonstration_seed(seed: int, posture: Posture, demonstration_set: int, attempt: int) -> int:
    """Seed of the operator when a posture is demonstrated for a set, at each attempt another."""
    if demonstration_set == attempt == 0:
        return posture_seed(seed, posture)
    return derived_seed(f"{seed}/demonstration/{demonstration_set}/{attempt} {posture.name}")


def fitting_seed(seed: int, entry: Entry, demonstration_set: int) -> int:
    """Seed of a policy's own randomness; the same under every variation."""
    return derived_seed(f"{seed}/fit/{demonstration_set}/{entry.demonstrations} {entry.policy}")


def variation_seed(seed: int, posture: Posture) -> int:
    """Seed of what is drawn anew for an episode; the same for every policy."""
    return derived_seed(f"{seed}/variation {posture.name}")
