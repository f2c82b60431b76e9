"""LeRobotDataset v3: a folder that LeRobot trains on, written and read by `lerobot` itself."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np

from dressing_sim.archives import check_folder_size, read_by_others, read_json
from dressing_sim.datasets.columns import (
    OBSERVED,
    OPTIONAL,
    Written,
    actions,
    demonstration_from,
    description,
    observations,
)
from dressing_sim.datasets.minari_sets import same_observations
from dressing_sim.datasets.prepare import ImportConfig
from dressing_sim.datasets.replayed import Cameras, pictures
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.errors import InvalidInputError
from dressing_sim.extras import needed
from dressing_sim.files import new_folder
from dressing_sim.lerobot_names import FRAMES, PICTURES, STATE, TASK

#: Files of a data set's folder: LeRobot's own description of it, and ours of each episode.
INFO, DESCRIPTIONS = Path("meta", "info.json"), Path("meta", "dressing_sim.json")

_FRAMES = [name for name in OBSERVED if name != "gripper"]


def write_lerobot(
    path: str | Path,
    demonstrations: Sequence[Demonstration],
    told: Written,
    cameras: Cameras | None = None,
) -> None:
    """Write demonstrations as a LeRobotDataset v3, all or nothing.

    Args:
        path: The folder.
        demonstrations: All with the same observations, and as many rows a second, a whole number.
        told: About progress.
        cameras: Whose pictures of each row are written, without loss; demonstrations are played
            again for them.

    Raises:
        InvalidInputError: The folder is there, demonstrations differ in what they have or in their
            rows a second, cannot be played again for pictures, or LeRobot is not installed (it
            needs Python 3.12).
        DressingSimError: Pictures are wanted, and no OpenGL works here.
    """
    module = needed("lerobot.datasets.lerobot_dataset", "lerobot")
    same_observations(demonstrations)
    rates = {1.0 / one.dt for one in demonstrations}
    fps = round(min(rates))
    if any(abs(rate - fps) > 1e-6 * fps for rate in rates):
        raise InvalidInputError(
            f"demonstrations have {', '.join(f'{rate:g}' for rate in sorted(rates))} rows a second,"
            " valid is one whole number"
        )
    features = _described(demonstrations[0], cameras)
    with new_folder(path) as made:
        data = module.LeRobotDataset.create(
            f"dressing-sim/{Path(path).name}", fps, features, made, "panda", use_videos=False
        )
        for number, one in enumerate(demonstrations):
            for frame in _frames(one, cameras):
                data.add_frame(frame)
            data.save_episode()
            told(number + 1, len(demonstrations))
        data.finalize()
        texts = [description(one) for one in demonstrations]
        (made / DESCRIPTIONS).write_text(json.dumps(texts), encoding="utf-8")


def _described(demonstration: Demonstration, cameras: Cameras | None) -> dict[str, dict[str, Any]]:
    """Kind, shape and names of each column."""
    features: dict[str, dict[str, Any]] = {
        name: {"dtype": "float64", "shape": (array.shape[1],), "names": _names(name, array)}
        for name, array in _features(demonstration).items()
    }
    features["next.success"] = {"dtype": "bool", "shape": (1,), "names": None}
    if cameras is not None:
        shape = {
            "shape": (cameras.height, cameras.width, 3),
            "names": ["height", "width", "channels"],
        }
        for camera in cameras.names:
            features[f"{PICTURES}.{camera}"] = {"dtype": "image", **shape}
    return features


def _frames(demonstration: Demonstration, cameras: Cameras | None) -> Iterator[dict[str, Any]]:
    """What LeRobot calls frames: row after row, with the task's text."""
    columns, rows = _features(demonstration), len(demonstration.positions)
    drawn = pictures(demonstration, cameras) if cameras is not None else repeat({}, rows)
    for row, seen in enumerate(drawn):
        frame: dict[str, Any] = {name: array[row] for name, array in columns.items()}
        frame |= {f"{PICTURES}.{camera}": picture for camera, picture in seen.items()}
        yield {**frame, "next.success": np.array([row == rows - 1]), "task": TASK}


def _features(demonstration: Demonstration) -> dict[str, np.ndarray]:
    """Columns by LeRobot's names."""
    seen = observations(demonstration)
    columns = {STATE: seen["gripper"], FRAMES: np.hstack([seen[name] for name in _FRAMES])}
    columns |= {f"observation.{name}": seen[name] for name in OPTIONAL if name in seen}
    return columns | {"action": actions(demonstration)}


def _names(name: str, array: np.ndarray) -> list[str]:
    if name == FRAMES:
        return [f"{one}_{number}" for one in _FRAMES for number in range(OBSERVED[one])]
    axes = "xyzw" if array.shape[1] <= 4 else "1234567"
    return [f"{name.rpartition('.')[2]}_{axis}" for axis in axes[: array.shape[1]]]


def read_lerobot(path: str | Path, config: ImportConfig) -> list[Demonstration]:
    """The demonstrations in a LeRobotDataset v3 with our features; nothing is downloaded.

    Raises:
        InvalidInputError: It cannot be read, is damaged, or has other features, or LeRobot is not
            installed.
    """
    path = Path(path)
    check_folder_size(path)
    texts = read_json(path / DESCRIPTIONS) if (path / DESCRIPTIONS).is_file() else None
    module = needed("lerobot.datasets.lerobot_dataset", "lerobot")
    with read_by_others(path, "LeRobotDataset"):
        data = module.LeRobotDataset(f"dressing-sim/{path.name}", root=path)
        # As it is on the disk: other forms are rounded to single precision.
        numbers = {STATE, FRAMES, *(f"observation.{name}" for name in OPTIONAL)}
        seen = [name for name in data.features if name in numbers]
        table = data.hf_dataset.select_columns([*seen, "episode_index"]).with_format("arrow")[:]
        episode = np.array(table["episode_index"].to_pylist())
        found = {name: np.array(table[name].to_pylist()) for name in seen}
        made = []
        for number in range(data.num_episodes):
            rows = episode == number
            columns = _columns({name: array[rows] for name, array in found.items()})
            text = None if texts is None else texts[number]
            made.append(demonstration_from(columns, text, f"episode_{number}", config))
        return made


def _columns(features: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Observations by our names."""
    given = {name: features.get(f"observation.{name}") for name in OPTIONAL}
    columns = {name: array for name, array in given.items() if array is not None}
    if STATE in features:
        columns["gripper"] = features[STATE]
    if FRAMES in features and features[FRAMES].shape[1:] == (sum(OBSERVED[n] for n in _FRAMES),):
        edges = np.cumsum([OBSERVED[name] for name in _FRAMES])[:-1]
        columns |= dict(zip(_FRAMES, np.split(features[FRAMES], edges, axis=1), strict=True))
    return columns
