"""A demonstration as a learner's data set has it: observations and actions, row by row.

All data sets of others hold the same columns, so that an adapter only says where they are.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from dressing_sim.arm import SITUATION, Posture
from dressing_sim.checks import real_array, shown
from dressing_sim.datasets.prepare import ImportConfig, demonstration_of
from dressing_sim.datasets.recording import LabRecording, of_columns
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.errors import InvalidInputError

Columns = Mapping[str, NDArray[np.float64]]

#: Told how many demonstrations are written, of how many.
Written = Callable[[int, int], None]

#: What every demonstration has, and what some have besides: numbers a row.
OBSERVED: Mapping[str, int] = {
    "gripper": 3,
    "shoulder_position": 3,
    "shoulder_axes": 9,
    "wrist_position": 3,
    "wrist_axes": 9,
}
OPTIONAL: Mapping[str, int | str] = {"joint_command": "n", "orientation": 4, "force": 3}

#: What the fields of a `Demonstration` are called among the observations.
_NAMES = {"commands": "joint_command", "orientations": "orientation", "forces": "force"}

#: The joints of a posture and of the observations are the same within this [m].
_SAME = 1e-6


def observations(demonstration: Demonstration) -> dict[str, NDArray[np.float64]]:
    """What is observed in each of the T rows, by name, each (T, n); see `OBSERVED`.

    Places are in the robot's base frame [m]. The axes of a frame are its matrix row by row: numbers
    0, 3 and 6 are the x axis.
    """
    rows = len(demonstration.positions)
    columns = {"gripper": demonstration.positions}
    for name, frame in zip(SITUATION, demonstration.frames, strict=True):
        columns[f"{name}_position"] = np.tile(frame.b, (rows, 1))
        columns[f"{name}_axes"] = np.tile(frame.A.ravel(), (rows, 1))
    return columns | {_NAMES[name]: array for name, array in demonstration.optional.items()}


def actions(demonstration: Demonstration) -> NDArray[np.float64]:
    """What is done in each row: where the gripper is led, which is where it is next, (T, 3) [m].

    The environments take this with ``control="target"``. In the last row it stays.
    """
    positions = demonstration.positions
    return np.concatenate([positions[1:], positions[-1:]])


def description(demonstration: Demonstration) -> str:
    """What the columns do not say, as JSON."""
    return json.dumps(
        {
            "posture": demonstration.posture.to_dict(),
            "dt": demonstration.dt,
            "seed": demonstration.seed,
            "settings": demonstration.settings,
            "versions": demonstration.versions,
        }
    )


def demonstration_from(
    columns: Columns, text: str | bytes | None, name: str, config: ImportConfig
) -> Demonstration:
    """The demonstration that was written; without a description, what a recording tells.

    Args:
        columns: Observations by name, see `OBSERVED`.
        text: Its description, if there is one.
        name: Of the posture, if there is none.
        config: How a recording becomes a demonstration; its rows are ``config.dt`` apart.

    Raises:
        InvalidInputError: A column is missing or not valid, or the description is none, or of
            another arm.
    """
    missing = [one for one in OBSERVED if one not in columns]
    if missing:
        raise InvalidInputError(
            f"no observation {missing[0]}; valid is a data set with {', '.join(OBSERVED)}"
        )
    widths = {**OBSERVED, **OPTIONAL}
    arrays = {
        one: real_array(columns[one], ("T", n), f"{one} has", fewest=2)
        for one, n in widths.items()
        if one in columns
    }
    if text is None:
        return demonstration_of(_recording(arrays, name, config.dt), config)
    values = _described(text)
    posture = Posture.from_dict(values["posture"])
    for joint in SITUATION:
        apart = np.abs(arrays[f"{joint}_position"] - getattr(posture, joint)).max()
        if apart > _SAME:
            raise InvalidInputError(
                f"{joint}_position is {apart:.3g} m off that of posture {posture.name!r}, valid is "
                "a data set as it was written"
            )
    optional: dict[str, Any] = {field: arrays.get(one) for field, one in _NAMES.items()}
    rest = {one: values[one] for one in ("dt", "seed", "settings", "versions")}
    return Demonstration(arrays["gripper"], posture=posture, **rest, **optional)


def _described(text: str | bytes) -> dict[str, Any]:
    try:
        values = json.loads(text)
    except (TypeError, ValueError, RecursionError) as error:
        raise InvalidInputError("its description is not JSON") from error
    keys = ["posture", "dt", "seed", "settings", "versions"]
    if not isinstance(values, dict) or set(values) != set(keys):
        raise InvalidInputError(
            f"its description is {shown(values)}, valid is an object of {', '.join(keys)}"
        )
    return values


def _recording(arrays: Columns, name: str, dt: float) -> LabRecording:
    """A data set of somebody else's as a recording."""
    columns = {
        "time": np.arange(len(arrays["gripper"])) * np.float64(dt),
        "gripper": arrays["gripper"],
    }
    for joint in SITUATION:
        columns[joint] = arrays[f"{joint}_position"]
        axes = arrays[f"{joint}_axes"].reshape(-1, 3, 3)
        if not np.allclose(axes @ axes.transpose(0, 2, 1), np.eye(3), atol=1e-3):
            raise InvalidInputError(f"{joint}_axes are no rotation, valid are its rows")
        columns[f"{joint}_quaternion"] = Rotation.from_matrix(axes).as_quat()
    for field, one in (("quaternion", "orientation"), ("force", "force")):
        if one in arrays:
            columns[field] = arrays[one]
    return of_columns(name, columns)
