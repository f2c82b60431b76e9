"""Where a run's episodes come from, and whether this process may go on with them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

from dressing_sim.benchmark.run.agreement import differences
from dressing_sim.benchmark.run.plan import Plan
from dressing_sim.checks import listed, of_kind
from dressing_sim.errors import InvalidInputError
from dressing_sim.numerics import unlike
from dressing_sim.policies.hosted import policy_origins
from dressing_sim.provenance import provenance, versions

#: In the config of a run.
_KEY = "provenance"

#: Within it: numerics, and code, that a run went on with, each with how many episodes were there
#: before.
_LATER, _LATER_CODE = "later_numerics", "later_code"


@dataclass(frozen=True, slots=True)
class Accept:
    """With what else than it began a run may go on."""

    numerics: bool = False
    """A processor that computes other bits."""
    changes: bool = False
    """Other versions of packages and of other people's policies."""


@dataclass(frozen=True, slots=True)
class Origin:
    """What a run's folder says of its origin.

    Attributes:
        provenance: As `provenance.provenance` gives it; empty in a folder of an earlier version.
        versions: Versions of all that the results depend on.
    """

    provenance: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, config: Mapping[str, Any]) -> Self:
        """From the config of a run."""
        found = [config.get(key, {}) for key in (_KEY, "versions")]
        for name, value in zip((_KEY, "versions"), found, strict=True):
            of_kind(value, Mapping, f"config of a run: {name}", "an object")
        made = cls(*found)
        for key, needed in ((_LATER, ("numerics",)), (_LATER_CODE, ("versions", "sources"))):
            steps = listed(made.provenance.get(key, ()), f"config of a run: {key}", "a list")
            for step in steps:
                of_kind(step, Mapping, f"config of a run: {key}", "objects")
                for name in needed:
                    of_kind(step.get(name), Mapping, f"config of a run: {name}", "an object")
        sources = made.provenance.get("sources", {})
        of_kind(sources, Mapping, "config of a run: sources", "an object")
        for one in made.numerics:
            of_kind(one, Mapping, "config of a run: numerics", "an object")
            of_kind(one.get("fingerprint"), str, "config of a run: fingerprint", "a text")
        return made

    @classmethod
    def here(cls, plan: Plan, numerics: Mapping[str, str]) -> Self:
        """Of a run that begins now, on workers with these numerics."""
        names = (entry.policy for entry in plan.protocol.entries)
        sources = policy_origins(names, plan.policy_limits)
        return cls({**provenance(sources), "numerics": dict(numerics)}, versions())

    @property
    def numerics(self) -> list[Mapping[str, str]]:
        """All that its episodes were made with; none if the folder does not say."""
        steps = [self.provenance, *self.provenance.get(_LATER, ())]
        return [step["numerics"] for step in steps if step.get("numerics")]

    def other_numerics(self, now: Mapping[str, str]) -> str:
        """In what these numerics differ from recorded ones, in a line; empty if they do not.

        It is empty too where other versions explain a difference, or nothing is recorded.
        """
        if dict(self.latest.versions) != versions():
            return ""
        return next(filter(None, (unlike(n, now, "recorded", "now") for n in self.numerics)), "")

    def changed(self, now: Origin) -> list[str]:
        """What has other code now: packages and other people's policies, a line each."""
        # What one of the two does not say cannot be compared.
        known = ("sources",) if self.provenance and now.provenance else ()
        then, here = (
            {"versions": dict(one.versions), **{key: one.provenance.get(key, {}) for key in known}}
            for one in (self.latest, now)
        )
        return differences(then, here, "then", "now")

    @property
    def latest(self) -> Origin:
        """With the code that the run last went on with."""
        later = self.provenance.get(_LATER_CODE)
        if not later:
            return self
        code = {"sources": later[-1]["sources"]}
        return Origin({**self.provenance, **code}, later[-1]["versions"])

    def mixed(self, policy: str) -> bool:
        """Whether episodes of a policy were made with more than one version of its code."""
        first = {"versions": dict(self.versions), "sources": self.provenance.get("sources", {})}
        stem = policy.partition("?")[0]
        steps = [first, *self.provenance.get(_LATER_CODE, ())]
        codes = [(one["versions"], one["sources"].get(stem)) for one in steps]
        return any(code != codes[0] for code in codes)

    def joined(self, now: Origin, n_episodes: int) -> Origin:
        """This one, with what is other if the run goes on from another after n episodes."""
        told = dict(self.provenance)
        before = {"episodes_before": n_episodes}
        if self.numerics and unlike(self.numerics[-1], now.numerics[0], "", ""):
            step = {**before, "numerics": dict(now.numerics[0])}
            told[_LATER] = [*told.get(_LATER, ()), step]
        if self.changed(now):
            sources = now.provenance.get("sources", {})
            step = {**before, "versions": dict(now.versions), "sources": sources}
            told[_LATER_CODE] = [*told.get(_LATER_CODE, ()), step]
        return Origin(told, self.versions)

    def into(self, config: Mapping[str, Any]) -> dict[str, Any]:
        """The config of a run with this origin, as its last key."""
        return {**config, _KEY: dict(self.provenance)}


def check_resumable(
    path: Path,
    earlier: Mapping[str, Any],
    wanted: Mapping[str, Any],
    now: Origin,
    accept: Accept,
) -> None:
    """Raise InvalidInputError unless a run in a folder can go on with the same bits.

    `earlier` is the config there, `wanted` that of what shall go on from `now`, without an origin.
    """
    origin = Origin.of(earlier)
    there, here = (
        {name: value for name, value in config.items() if name not in (_KEY, "versions")}
        for config in (earlier, wanted)
    )
    if found := differences(there, here, "there", "now"):
        told = "\n  ".join(found)
        raise InvalidInputError(
            f"{path} holds a run with another config; choose another --out\n  {told}"
        )
    if (found := origin.changed(now)) and not accept.changes:
        told = "\n  ".join(found)
        raise InvalidInputError(
            f"{path} holds a run of other code; choose another --out, or add --accept-changes to "
            f"have episodes of both in it, in rows that say so\n  {told}"
        )
    other = origin.other_numerics(now.numerics[0])
    if other and not accept.numerics:
        raise InvalidInputError(
            f"{path} holds a run of a processor that computes other bits ({other}); choose another "
            "--out, or add --accept-numerics to have episodes of both in it"
        )
