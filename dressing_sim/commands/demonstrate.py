"""``dressing-sim demonstrate``: recorded demonstrations in a file."""

from __future__ import annotations

import json as json_format
import sys
from pathlib import Path

import tyro

from dressing_sim.checks import shown
from dressing_sim.commands.options import check_seed
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import check_output

#: Exit code if some demonstrations failed.
SOME_FAILED = 3


def demonstrate(
    suite: tyro.conf.Positional[str],
    out: Path = Path("demonstrations.h5"),
    seed: int = 0,
    operator: str = "expert",
    garment: str | None = None,
    person: str | None = None,
    robot: str | None = None,
    force: bool = False,
    json: bool = False,
) -> None:
    """Record the scripted operator on the postures of a suite, in an HDF5 file.

    Demonstrations that fail are named and left out; the exit code is then 3.

    For example: dressing-sim demonstrate case_a --out case_a.h5

    Or: dressing-sim demonstrate random:7:3 --seed 1 --out seven.h5

    Or: dressing-sim demonstrate case_a --operator "expert?speed=0.16" --out quick.h5

    Or: dressing-sim demonstrate case_a --robot ur10 --out ur10.h5

    Args:
        suite: postures to demonstrate on: a name, a JSON file, or random:N[:SEED].
        out: file to write.
        seed: of the operator's variability.
        operator: expert, or expert?name=value&... for one of another style: speed, forearm_height,
            elbow_height, outer_distance, shoulder_height and so on.
        garment: what is put on: tshirt-m, tshirt-l, tshirt-xl, long-sleeve,
            tshirt-m-body, hospital-gown, or a TOML file with a tape measure's sizes.
        person: whose arm is dressed: male, female_small, child-ten, tall-man, or a TOML file
            with a height or a tape measure's sizes.
        robot: which robot dresses: panda, ur10, or a TOML file with its URDF and servos.
        force: replace a file that is there already.
        json: print what was recorded as JSON.
    """
    from dressing_sim.benchmark.run.plan import posture_seed
    from dressing_sim.episode.demonstration import save_demonstrations
    from dressing_sim.episode.operator import Operator
    from dressing_sim.episode.outcome import Outcome
    from dressing_sim.episode.record import DemonstrationFailed
    from dressing_sim.episode.record import demonstrate as record_one
    from dressing_sim.policies.hyperparameters import split_name
    from dressing_sim.policies.registry import EXPERT, make_policy
    from dressing_sim.suites.people import as_person, load_person
    from dressing_sim.suites.robots import with_robot
    from dressing_sim.suites.suites import load_suite
    from dressing_sim.suites.wardrobe import world_with

    check_seed(seed)
    if split_name(operator)[0] != EXPERT:
        valid = f"{EXPERT}, perhaps with ?name=value&..."
        raise InvalidInputError(f"operator is {shown(operator)}, valid is {valid}")
    teacher = make_policy(operator)
    assert isinstance(teacher, Operator)
    inputs = [suite, garment, person, robot]
    check_output(out, force, inputs)
    config, postures = with_robot(world_with(garment), robot), load_suite(suite)
    if person is not None:
        postures = as_person(postures, load_person(person))
    recorded, lines, failed = [], [], []
    for posture in postures:
        try:
            demonstration = record_one(posture, posture_seed(seed, posture), teacher, config)
            outcome = demonstration.outcome or Outcome(False)
        except DemonstrationFailed as error:
            outcome = error.outcome
        verdict = "success" if outcome.success else outcome.invalid or ", ".join(outcome.reasons)
        print(f"{posture.name}: {verdict}", file=sys.stderr)
        if not outcome.success:
            failed.append(f"on posture {posture.name!r} failed ({verdict})")
            continue
        recorded.append(demonstration)
        lines.append(
            {"posture": posture.to_dict(), "seed": demonstration.seed, **outcome.to_dict()}
        )
    if recorded:
        check_output(out, force, inputs)  # it took long
        save_demonstrations(out, recorded)
    file = str(out) if recorded else None
    if json:
        print(json_format.dumps({"file": file, "demonstrations": lines}, indent=2))
    elif recorded:
        print(f"{len(recorded)} demonstrations written to {out}")
    if failed:
        told = f"{', '.join(failed)}; choose another seed or posture"
        written = f"the other {len(recorded)} are in {out}" if recorded else "nothing was written"
        print(f"dressing-sim: the demonstration {told}; {written}", file=sys.stderr)
        raise SystemExit(SOME_FAILED if recorded else 2)
