"""``dressing-sim demonstrate``: recorded demonstrations in a file."""

from __future__ import annotations

import json as json_format
import sys
from pathlib import Path

import tyro

from dressing_sim.commands.options import check_seed
from dressing_sim.errors import DressingSimError
from dressing_sim.files import check_output


def demonstrate(
    suite: tyro.conf.Positional[str],
    out: Path = Path("demonstrations.h5"),
    seed: int = 0,
    force: bool = False,
    json: bool = False,
) -> None:
    """Record the scripted operator on the postures of a suite, in an HDF5 file.

    For example: dressing-sim demonstrate case_a --out case_a.h5

    Or: dressing-sim demonstrate random:7:3 --seed 1 --out seven.h5

    Args:
        suite: postures to demonstrate on: a name, a JSON file, or random:N[:SEED].
        out: file to write.
        seed: of the operator's variability.
        force: replace a file that is there already.
        json: print what was recorded as JSON.
    """
    from dressing_sim.benchmark.run.plan import posture_seed
    from dressing_sim.episode.demonstration import save_demonstrations
    from dressing_sim.episode.outcome import Outcome
    from dressing_sim.episode.record import DemonstrationFailed
    from dressing_sim.episode.record import demonstrate as record_one
    from dressing_sim.suites.suites import load_suite

    check_seed(seed)
    check_output(out, force, [suite])
    recorded, lines = [], []
    for posture in load_suite(suite):
        try:
            demonstration = record_one(posture, posture_seed(seed, posture))
            outcome = demonstration.outcome or Outcome(False)
        except DemonstrationFailed as error:
            outcome = error.outcome
        verdict = "success" if outcome.success else outcome.invalid or ", ".join(outcome.reasons)
        print(f"{posture.name}: {verdict}", file=sys.stderr)
        if not outcome.success:
            raise DressingSimError(
                f"the demonstration on posture {posture.name!r} failed ({verdict}); nothing was "
                "written, choose another seed or posture"
            )
        recorded.append(demonstration)
        lines.append(
            {"posture": posture.to_dict(), "seed": demonstration.seed, **outcome.to_dict()}
        )
    check_output(out, force, [suite])  # it took long
    save_demonstrations(out, recorded)
    if json:
        print(json_format.dumps({"file": str(out), "demonstrations": lines}, indent=2))
    else:
        print(f"{len(recorded)} demonstrations written to {out}")
