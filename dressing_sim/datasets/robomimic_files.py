"""robomimic's HDF5: ``data/demo_0/{obs,actions,...}``; written and read with h5py alone."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np

from dressing_sim.datasets.columns import (
    OBSERVED,
    OPTIONAL,
    Written,
    actions,
    demonstration_from,
    description,
    observations,
)
from dressing_sim.datasets.prepare import ImportConfig
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.hdf5 import array_of, inside, opened
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import write_file

#: robomimic's number for environments of gym's interface.
_GYM_TYPE = 2

#: Where our description of a demonstration is.
DESCRIPTION = "dressing_sim"


def write_robomimic(
    path: str | Path, demonstrations: Sequence[Demonstration], told: Written
) -> None:
    """Write demonstrations as robomimic reads them, all or nothing.

    Rewards are 0 and in the last row 1, where it is done: a demonstration ends with the task.
    """
    with h5py.File(str(path), "w", driver="core", backing_store=False) as file:
        data = file.create_group("data")
        environment = {
            "env_name": "dressing_sim/DressArm-v0",
            "type": _GYM_TYPE,
            "env_kwargs": {"control": "target", "finish": "arrival"},
        }
        data.attrs["env_args"] = json.dumps(environment)
        data.attrs["total"] = sum(len(one.positions) for one in demonstrations)
        for number, one in enumerate(demonstrations):
            rows = len(one.positions)
            group = data.create_group(f"demo_{number}")
            group.attrs["num_samples"] = rows
            group.attrs[DESCRIPTION] = np.bytes_(description(one).encode("ascii"))
            group["actions"] = actions(one)
            last = np.arange(rows) == rows - 1
            group["rewards"], group["dones"] = last.astype(np.float64), last.astype(np.int64)
            seen = observations(one)
            group["states"] = one.positions
            for name, array in seen.items():
                group[f"obs/{name}"] = array
                group[f"next_obs/{name}"] = np.concatenate([array[1:], array[-1:]])
            told(number + 1, len(demonstrations))
        file.flush()
        content = file.id.get_file_image()
    write_file(path, content)


def read_robomimic(path: str | Path, config: ImportConfig) -> list[Demonstration]:
    """The demonstrations in a file of robomimic's with the observations of `OBSERVED`.

    Raises:
        InvalidInputError: It cannot be read, is damaged, or has other observations.
    """
    with opened(path) as file:
        data = inside(file, "data", h5py.Group)
        names = [name for name in data if re.fullmatch(r"demo_\d{1,7}", name, re.ASCII)]
        if not names:
            raise InvalidInputError("no data/demo_0; valid is a file of robomimic's")
        ordered = sorted(names, key=lambda name: int(name.removeprefix("demo_")))
        return [_read(inside(data, name, h5py.Group), name, config) for name in ordered]


def _read(group: h5py.Group, name: str, config: ImportConfig) -> Demonstration:
    seen = inside(group, "obs", h5py.Group)
    widths = {**OBSERVED, **OPTIONAL}
    columns = {one: array_of(seen, one, ("T", n)) for one, n in widths.items() if one in seen}
    return demonstration_from(columns, group.attrs.get(DESCRIPTION), name, config)
