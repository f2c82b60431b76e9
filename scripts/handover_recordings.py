"""The recordings of a handover in ``examples/recordings/handover.json``, from robosuite's wheel.

    pip download --no-deps robosuite==1.4.1
    python scripts/handover_recordings.py robosuite-1.4.1-py3-none-any.whl [--out FILE]

robosuite (MIT licence) brings seven demonstrations of two people who lead two simulated arms: one
grasps a hammer that lies somewhere on the table and holds it out, the other takes it. A file of
states is in the wheel, not the places of grippers and hammer; they follow from the joints by the
kinematics of the model that is stored with each demonstration. Two phases are cut out:

* ``reach``: the first gripper, from its place to where it closes on the hammer for good;
* ``take``: the second one, from its last 2 cm about where it waited to where it closes for good.

Frames are the gripper's place at the beginning, with the axes of the world, and the hammer: its
origin, x along the handle to the head, z up. For ``reach`` it is where it lay at the beginning, and
for ``take`` where it is held at the end.
"""

from __future__ import annotations

import argparse
import io
import json
import xml.etree.ElementTree as ElementTree
import zipfile
from pathlib import Path

import h5py
import mujoco
import numpy as np
from numpy.typing import NDArray

MEMBER = "robosuite/models/assets/demonstrations/handover/panda_panda/demo.hdf5"
OUT = Path(__file__).resolve().parents[1] / "examples" / "recordings" / "handover.json"
STEP = 2  # every other sample of 20 Hz is kept
WAITING = 0.02  # a gripper that has not left this ball has not begun [m]
LIFTED = 0.02  # how high the hammer is once it is in the hand [m]
CLOSING = (6, 13)  # where actions have the commands of the grippers; above zero is closing
Array = NDArray[np.float64]


def kinematics(model_file: str) -> mujoco.MjModel:
    """The stored model without what needs files of its own; joints and sites are as they were."""
    root = ElementTree.fromstring(model_file)
    for part in [*root]:
        if part.tag in ("asset", "actuator", "sensor", "visual", "statistic", "size", "contact"):
            root.remove(part)
    for part in [*root.iter()]:
        part.attrib.pop("material", None)
        for child in [*part]:
            if child.tag == "geom" and child.get("mesh"):
                part.remove(child)
    compiler = root.find("compiler")
    assert compiler is not None
    compiler.attrib.pop("meshdir", None)
    compiler.set("inertiafromgeom", "false")
    return mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))


def places(model: mujoco.MjModel, states: Array) -> tuple[list[Array], Array, Array]:
    """Both grippers' positions (T, 3), the hammer's (T, 3) and its axes (T, 3, 3), all in [m]."""
    data = mujoco.MjData(model)
    grippers: list[list[Array]] = [[], []]
    hammer, axes = [], []
    for state in states:
        data.qpos[:] = state[1 : 1 + model.nq]
        mujoco.mj_kinematics(model, data)
        for side, path in enumerate(grippers):
            path.append(data.site(f"gripper{side}_grip_site").xpos.copy())
        hammer.append(data.body("hammer_root").xpos.copy())
        axes.append(data.body("hammer_root").xmat.reshape(3, 3).copy())
    return [np.array(path) for path in grippers], np.array(hammer), np.array(axes)


def upright(axes: Array) -> Array:
    """Columns x, y, z of a frame with x along the handle, as seen from above, and z up."""
    ahead = axes[:2, 2] / np.linalg.norm(axes[:2, 2])
    return np.array([[ahead[0], -ahead[1], 0.0], [ahead[1], ahead[0], 0.0], [0.0, 0.0, 1.0]])


def last_closing(commands: Array, before: int) -> int:
    """The sample with the last command to close before one."""
    closing = np.flatnonzero((commands[1:] > 0) & (commands[:-1] <= 0)) + 1
    return int(closing[closing < before][-1])


def entry(phase: str, name: str, path: Array, begin: int, hammer: Array, axes: Array) -> dict:
    """One recording with its two frames."""
    kept = path[begin:][::-1][::STEP][::-1]
    start = {"A": np.eye(3).tolist(), "b": kept[0].round(4).tolist()}
    goal = {"A": upright(axes).round(6).tolist(), "b": hammer.round(4).tolist()}
    return {
        "phase": phase,
        "recording": name,
        "dt": 0.05 * STEP,
        "frames": [start, goal],
        "positions": kept.round(4).tolist(),
    }


def phases(name: str, states: Array, actions: Array, model_file: str) -> list[dict]:
    """The two phases of one demonstration."""
    grippers, hammer, axes = places(kinematics(model_file), states)
    lifted = int(np.argmax(hammer[:, 2] > hammer[0, 2] + LIFTED))
    grasped = last_closing(actions[:, CLOSING[0]], lifted)
    taken = last_closing(actions[:, CLOSING[1]], len(actions))
    away = np.linalg.norm(grippers[1] - grippers[1][lifted], axis=1) > WAITING
    begun = int(np.flatnonzero(~away[:taken])[-1])
    return [
        entry("reach", name, grippers[0][: grasped + 1], 0, hammer[0], axes[0]),
        entry("take", name, grippers[1][: taken + 1], begun, hammer[taken], axes[taken]),
    ]


def main() -> None:
    """Read the wheel and write the file, a line for each recording."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--out", type=Path, default=OUT)
    args = parser.parse_args()
    content = zipfile.ZipFile(args.wheel).read(MEMBER)
    with h5py.File(io.BytesIO(content)) as file:
        made = [
            phase
            for name, group in sorted(file["data"].items())
            for phase in phases(
                name, group["states"][:], group["actions"][:], group.attrs["model_file"]
            )
        ]
    lines = ",\n".join(json.dumps(one, separators=(",", ":")) for one in made)
    args.out.write_text(f"[\n{lines}\n]\n", encoding="utf-8")
    print(f"{args.out}: {len(made)} recordings")


if __name__ == "__main__":
    main()
