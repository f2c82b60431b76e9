"""Loops of learning, compiled by one worker while others demonstrate; once on a machine."""

from __future__ import annotations

from dressing_sim.benchmark.studies.tuning_paths import tried
from dressing_sim.policies.registry import DEFAULT
from dressing_sim.suites.suites import load_suite

#: Between them they learn with every loop that policies of this package have.
PREPARED = ("tp-gmm-rf-noise", DEFAULT)


def compile_learning() -> None:
    """Let policies learn from paths that nobody simulates, and make one each."""
    shown, tested = load_suite("case_a"), load_suite("paper5")[:1]
    for name in PREPARED:
        for _ in tried(name, shown, tested, seed=0):
            pass
