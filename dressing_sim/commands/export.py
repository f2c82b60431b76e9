"""``dressing-sim export``: demonstrations as the data set of another library."""

from __future__ import annotations

import json as json_format
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Literal

import tyro
from rich.console import Console

from dressing_sim.benchmark.run.progress import show_progress
from dressing_sim.commands.options import names
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import check_output


def export(
    demonstrations: tyro.conf.Positional[Path],
    to: Literal["robomimic", "minari", "lerobot"],
    out: Path,
    cameras: str = "",
    width: int = 640,
    height: int = 480,
    force: bool = False,
    json: bool = False,
) -> None:
    """Write demonstrations as robomimic, Minari or LeRobot train on them.

    Minari and LeRobot write their own data sets, so they must be installed: pip install
    'dressing-sim[minari]' or 'dressing-sim[lerobot]' (Python 3.12).

    For example: dressing-sim export case_a.h5 --to robomimic --out case_a.hdf5

    Or: dressing-sim export case_a.h5 --to minari --out data/dressing-sim/case-a-v0

    Or: dressing-sim export case_a.h5 --to lerobot --out case_a_lerobot --cameras front,close

    Args:
        demonstrations: file that ``dressing-sim demonstrate`` or ``dressing-sim import`` wrote.
        to: robomimic, minari or lerobot.
        out: file, or new folder, to write.
        cameras: pictures of each row for lerobot: some of front,close,above,side,person,room. The
            demonstrations are played again for them, so they must be of the simulator.
        width: of a picture, in pixels.
        height: of a picture, in pixels.
        force: replace a file that is there already; folders never are.
        json: print what was written as JSON.
    """
    from dressing_sim.datasets.lerobot_sets import write_lerobot
    from dressing_sim.datasets.minari_sets import write_minari
    from dressing_sim.datasets.replayed import Cameras
    from dressing_sim.datasets.robomimic_files import write_robomimic
    from dressing_sim.episode.demonstration import load_demonstrations

    if cameras and to != "lerobot":
        raise InvalidInputError(f"cameras are given with --to {to}, valid is --to lerobot")
    if not cameras and (width, height) != (640, 480):
        raise InvalidInputError("a picture's width and height are given, valid is with --cameras")
    drawn = Cameras(tuple(names(cameras)), width, height) if cameras else None
    writers: dict[str, Callable[..., None]] = {
        "robomimic": write_robomimic,
        "minari": write_minari,
        "lerobot": partial(write_lerobot, cameras=drawn),
    }
    check_output(out, force and to == "robomimic", [demonstrations])
    recorded = load_demonstrations(demonstrations)
    if not recorded:
        raise InvalidInputError(f"{demonstrations}: no demonstrations; valid is one or more")
    with show_progress(Console(stderr=True)) as progress:
        writers[to](out, recorded, lambda done, total: progress("written", done, total, ""))
    if json:
        print(json_format.dumps({"out": str(out), "to": to, "n_demonstrations": len(recorded)}))
    else:
        print(f"{len(recorded)} demonstrations written to {out}")
