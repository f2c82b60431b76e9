"""What several commands share: their options, and how results are printed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from dressing_sim.errors import InvalidInputError

if TYPE_CHECKING:
    from dressing_sim.episode.outcome import Outcome


#: Of whatever is counted on the command line; more is a slip of the finger.
MOST = 1_000_000

#: More processes than any machine has processors.
MOST_WORKERS = 1024


def check_positive(name: str, value: int, most: int = MOST) -> None:
    """Raise InvalidInputError unless an option is 1 or more, and not absurd."""
    if not 1 <= value <= most:
        raise InvalidInputError(f"{name} is {value}, valid is 1 or more, up to {most}")


def check_seed(value: int) -> None:
    """Raise InvalidInputError unless a seed is 0 or more."""
    if not 0 <= value < 2**63:
        raise InvalidInputError(f"seed is {value}, valid is 0 or more, below 2 to the 63rd")


def names(text: str) -> list[str]:
    """The names in a list with commas."""
    return [name.strip() for name in text.split(",")]


#: Metrics that are printed next to a verdict: how far the sleeve came, and what it took.
_TOLD = (
    "duration",
    "armscye_s",
    "gripper_distance",
    "strain",
    "grip_force",
    "link_force",
    "hit_force",
)


def print_outcome(name: str, outcome: Outcome) -> None:
    """Print a verdict with its reasons and the metrics that matter most."""
    from dressing_sim.episode.metrics import METRICS, metric_text

    failed = bool(outcome.failures) and outcome.invalid is None
    print(f"{name}: {'failure' if failed else outcome.verdict}")
    if outcome.abstained is not None:
        print(f"  {outcome.abstained}")
    for failure in outcome.failures:
        when = "" if failure.time is None else f" at {failure.time:.2f} s"
        print(f"  {failure.reason}{when}: {failure.detail}")
    told = {m: v for m, v in outcome.metrics.items() if m in _TOLD or m not in METRICS}
    for metric, value in told.items():
        print(f"  {metric:24} {metric_text(metric, value)}")
    if len(told) < len(outcome.metrics):
        print(f"  {len(outcome.metrics) - len(told)} more metrics with --json")
