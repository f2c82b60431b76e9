"""Recordings of ROS 2: bags of stamped poses, points and wrenches, read by `rosbags`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.archives import check_folder_size, read_by_others
from dressing_sim.checks import shown
from dressing_sim.datasets.recording import LabRecording, of_columns
from dressing_sim.datasets.topics import Topics
from dressing_sim.errors import InvalidInputError
from dressing_sim.extras import needed
from dressing_sim.learning.registration import at_times

#: Messages that are read, and how their numbers are found.
POSE, POINT, WRENCH = (f"geometry_msgs/msg/{name}Stamped" for name in ("Pose", "Point", "Wrench"))

#: More messages of one topic are in no recording of one dressing.
MOST_MESSAGES = 1_000_000


_Rows = tuple[NDArray[np.int64], NDArray[np.float64]]


def read_bag(path: str | Path, topics: Topics | None = None) -> LabRecording:
    """A recording in a ROS 2 bag, a folder with ``metadata.yaml``.

    Times are those of the headers. All are given in one fixed frame: nothing is looked up in tf.

    Raises:
        InvalidInputError: It cannot be read, a topic is missing or of another type, frames differ,
            or it is no recording; or `rosbags` is not installed.
    """
    highlevel = needed("rosbags.highlevel", "ros")
    typesys = needed("rosbags.typesys", "ros")
    path, topics = Path(path), topics or Topics()
    check_folder_size(path)
    wanted = {topic: name for name, topic in _by_name(topics).items()}
    with read_by_others(path, "ROS 2 bag"):
        store = typesys.get_typestore(typesys.Stores.LATEST)
        with highlevel.AnyReader([path], default_typestore=store) as bag:
            rows = _read(bag, wanted)
        return of_columns(path.name, _columns(rows))


def _by_name(topics: Topics) -> dict[str, str]:
    return {name: getattr(topics, name) for name in Topics.__dataclass_fields__}


def _read(bag: Any, wanted: Mapping[str, str]) -> dict[str, _Rows]:
    """Times [ns] and numbers of each quantity's messages."""
    connections = [one for one in bag.connections if one.topic in wanted]
    for one in connections:
        valid = (WRENCH,) if wanted[one.topic] == "force" else (POSE, POINT)
        if one.msgtype not in valid:
            raise InvalidInputError(
                f"topic {shown(one.topic)} has {one.msgtype}, valid is {' or '.join(valid)}"
            )
        if one.msgcount > MOST_MESSAGES:
            raise InvalidInputError(f"topic {shown(one.topic)} has {one.msgcount} messages")
    missing = sorted({"gripper", "shoulder", "wrist"} - {wanted[one.topic] for one in connections})
    if missing:
        topics = ", ".join(sorted({one.topic for one in bag.connections}))
        raise InvalidInputError(
            f"no topic of the {missing[0]}; valid is --topics.{missing[0]} one of {topics}"
        )
    found: dict[str, list[tuple[int, list[float]]]] = {}
    frames: dict[str, str] = {}
    for connection, _, raw in bag.messages(connections=connections):
        message = bag.deserialize(raw, connection.msgtype)
        name, stamp = wanted[connection.topic], message.header.stamp
        frames[name] = message.header.frame_id
        found.setdefault(name, []).append((stamp.sec * 10**9 + stamp.nanosec, _numbers(message)))
    if len(set(frames.values())) > 1:
        told = ", ".join(f"{name} in {shown(frame)}" for name, frame in frames.items())
        raise InvalidInputError(f"topics are in different frames ({told}), valid is one")
    return {
        name: (np.array([t for t, _ in rows]), np.array([numbers for _, numbers in rows]))
        for name, rows in found.items()
    }


def _numbers(message: Any) -> list[float]:
    """Place and, of a pose, orientation; or the force of a wrench."""
    if hasattr(message, "wrench"):
        return [getattr(message.wrench.force, axis) for axis in "xyz"]
    if hasattr(message, "point"):
        return [getattr(message.point, axis) for axis in "xyz"]
    pose = message.pose
    place = [getattr(pose.position, axis) for axis in "xyz"]
    return place + [getattr(pose.orientation, axis) for axis in "xyzw"]


def _columns(rows: Mapping[str, _Rows]) -> dict[str, NDArray[np.float64]]:
    """Quantities at the gripper's times."""
    stamps, gripper = rows["gripper"]
    times = (stamps - stamps[0]) * 1e-9
    columns = {"time": times, "gripper": gripper[:, :3]}
    if gripper.shape[1] == 7:
        columns["quaternion"] = gripper[:, 3:]
    if "force" in rows:
        at = (rows["force"][0] - stamps[0]) * 1e-9
        if np.any(np.diff(at) <= 0.0):
            raise InvalidInputError("the force's times do not rise, valid are rising times")
        columns["force"] = at_times(rows["force"][1], at, times)
    for name in ("shoulder", "elbow", "wrist"):
        if name in rows:
            numbers = rows[name][1]
            columns[name] = numbers[:, :3]
            if numbers.shape[1] == 7 and name != "elbow":
                columns[f"{name}_quaternion"] = numbers[:, 3:]
    return columns
