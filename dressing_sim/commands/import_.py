"""``dressing-sim import``: recordings of a lab, and data sets of others, as demonstrations."""

from __future__ import annotations

import json as json_format
from dataclasses import replace
from pathlib import Path

import tyro
from rich.console import Console

from dressing_sim.benchmark.run.progress import show_progress
from dressing_sim.datasets.topics import Topics
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import check_output


def import_(
    sources: tyro.conf.Positional[list[Path]],
    out: Path = Path("demonstrations.h5"),
    dt: float = 0.02,
    turn_deg: float = 0.0,
    mirror: bool = False,
    keep_place: bool = False,
    trim_pauses: bool = False,
    max_gap: float = 0.5,
    person: str = "male",
    topics: Topics = Topics(),  # noqa: B008 (frozen)
    force: bool = False,
    json: bool = False,
) -> None:
    """Make a file of demonstrations, as ``dressing-sim learn`` takes it, of what others recorded.

    A recording is a CSV or NPZ file or a ROS 2 bag with the gripper's positions and the arm's
    joints; names end with units. A data set is a robomimic HDF5 file, or a folder of Minari or
    LeRobotDataset v3, as ``dressing-sim export`` writes them.

    For example: dressing-sim import first.csv second.csv --trim-pauses --out mine.h5

    Or: dressing-sim import right_arm.csv --turn-deg 90 --mirror --out mine.h5

    Or: dressing-sim import robomimic.hdf5 --out again.h5

    Args:
        sources: files and folders to read, all together.
        out: file to write.
        dt: time between two rows of a demonstration, in seconds.
        turn_deg: turn a recording about the vertical so that the person looks along +y.
        mirror: make a left arm of a right one.
        keep_place: the recording is in the frame of the simulator's robot; else it is moved until
            the shoulder is in its usual place.
        trim_pauses: leave out rows in which the gripper rests.
        max_gap: longest time without a row, in seconds.
        person: whose arm's thickness it is: a name or a TOML file, as of ``dressing-sim dress``.
        topics: which topics of a ROS 2 bag are read.
        force: replace a file that is there already.
        json: print what was read as JSON.
    """
    from dressing_sim.arm import ARM_SIZES
    from dressing_sim.datasets.prepare import ImportConfig
    from dressing_sim.datasets.sources import read_source
    from dressing_sim.episode.demonstration import save_demonstrations
    from dressing_sim.suites.people import load_person

    if not sources:
        raise InvalidInputError("import: no files, valid are one or more recordings or data sets")
    check_output(out, force, sources)
    size = load_person(person)
    config = ImportConfig(dt, turn_deg, mirror, keep_place, trim_pauses, max_gap)
    config = replace(config, size=ARM_SIZES[size] if isinstance(size, str) else size)
    recorded = []
    with show_progress(Console(stderr=True)) as progress:
        for number, source in enumerate(sources):
            recorded += read_source(source, config, topics)
            progress("read", number + 1, len(sources), str(source))
    check_output(out, force, sources)  # it took long
    save_demonstrations(out, recorded)
    if json:
        lines = [
            {
                "posture": one.posture.to_dict(),
                "n_rows": len(one.positions),
                "dt": one.dt,
                "has": ["positions", *one.optional],
            }
            for one in recorded
        ]
        print(json_format.dumps({"file": str(out), "demonstrations": lines}, indent=2))
    else:
        print(f"{len(recorded)} demonstrations written to {out}")
