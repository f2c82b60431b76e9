"""Episodes as lines of ``episodes.jsonl``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import EpisodeResult, Failure, Json, Outcome
from dressing_sim.benchmark.run.plan import Plan
from dressing_sim.checks import of_kind, shown, truth_value, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.provenance import versions


def episode_values(plan: Plan, result: EpisodeResult) -> dict[str, Json]:
    """What the line of an episode holds."""
    return {
        "index": result.index,
        "protocol": plan.protocol.name,
        "policy": result.entry.policy,
        "demonstrations": result.entry.demonstrations,
        "demonstration_set": result.demonstration_set,
        "posture": result.posture.to_dict(),
        "seed": result.seed,
        "variation": dict(result.variation),
        **result.outcome.to_dict(),
        **({"extra": dict(result.extra)} if result.extra else {}),
        "versions": versions(),
    }


def parse_episode(plan: Plan, values: Mapping[str, Any]) -> EpisodeResult:
    """The inverse of `episode_values` for an episode of a plan.

    Raises:
        InvalidInputError: The line is damaged or of another run.
    """
    try:
        entry = plan.protocol.entries[values["index"] // len(plan.tested)]
        if (values["policy"], values["demonstrations"]) != (entry.policy, entry.demonstrations):
            raise InvalidInputError(f"episode {values['index']} is of another run")
        whole_number(values["index"], "index")
        whole_number(values["seed"], "seed")
        whole_number(values["demonstration_set"], "demonstration_set")
        return EpisodeResult(
            index=values["index"],
            entry=entry,
            posture=Posture.from_dict(values["posture"]),
            demonstration_set=values["demonstration_set"],
            seed=values["seed"],
            variation=of_kind(values["variation"], dict, "variation", "values by name"),
            outcome=parse_outcome(values),
            extra=of_kind(values.get("extra", {}), dict, "extra", "values by name"),
        )
    except (KeyError, TypeError, IndexError, AttributeError, ValueError) as error:
        raise InvalidInputError(f"not an episode: {shown(values)} ({shown(error)})") from error


def parse_outcome(values: Mapping[str, Any]) -> Outcome:
    """The outcome of a line: the inverse of `Outcome.to_dict`."""
    truth_value(values["success"], "success")
    of_kind(values["figures"], Mapping, "figures", "numbers by name")
    return Outcome(
        success=values["success"],
        failures=tuple(Failure(**failure) for failure in values["failures"]),
        metrics=values["figures"],
        invalid=values["void"],
        abstained=values.get("abstained"),
    )
