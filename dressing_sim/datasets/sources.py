"""What a file or folder is, and the demonstrations in it."""

from __future__ import annotations

import hashlib
from pathlib import Path

from dressing_sim.checks import LONGEST_NAME, shown
from dressing_sim.datasets.lerobot_sets import INFO, read_lerobot
from dressing_sim.datasets.minari_sets import DATA, read_minari
from dressing_sim.datasets.prepare import ImportConfig, demonstration_of
from dressing_sim.datasets.recording import LabRecording
from dressing_sim.datasets.robomimic_files import read_robomimic
from dressing_sim.datasets.ros import read_bag
from dressing_sim.datasets.tables import read_table
from dressing_sim.datasets.topics import Topics
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import is_file


def read_source(
    path: Path, config: ImportConfig | None = None, topics: Topics | None = None
) -> list[Demonstration]:
    """The demonstrations that a file or a folder has.

    Args:
        path: A recording (CSV, NPZ, ROS 2 bag) or a data set (robomimic, Minari, LeRobot).
        config: How a recording becomes a demonstration; data sets hold demonstrations.
        topics: Of a bag.

    Raises:
        InvalidInputError: It is none of these, or not valid.
    """
    config = config or ImportConfig()
    if is_file(path) and path.suffix in (".csv", ".npz"):
        return [_demonstration(path, read_table(path), config)]
    if is_file(path) and path.suffix in (".hdf5", ".h5"):
        return read_robomimic(path, config)
    if is_file(path / INFO):
        return read_lerobot(path, config)
    if is_file(path / DATA / "metadata.json"):
        return read_minari(path, config)
    if is_file(path / "metadata.yaml"):
        return [_demonstration(path, read_bag(path, topics), config)]
    raise InvalidInputError(
        f"{shown(str(path), LONGEST_NAME)[1:-1]}: nothing that can be imported; valid is a .csv or "
        ".npz file, a ROS 2 bag, a .hdf5 file of robomimic's, or a folder of Minari's or LeRobot's"
    )


def _demonstration(path: Path, recording: LabRecording, config: ImportConfig) -> Demonstration:
    source = {"file": path.name}
    if path.is_file():
        source["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
    try:
        return demonstration_of(recording, config, source)
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}") from error
