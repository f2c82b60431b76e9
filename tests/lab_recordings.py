"""A dressing as a lab would write it down: its own frame, units, clock and pauses."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from dressing_sim.episode.operator import Operator
from dressing_sim.suites.suites import find_posture

POSTURE = find_posture("bent40")

#: From the simulator's frame to the lab's: a turn about the vertical [deg] and a shift [m].
TURN_DEG, SHIFT = -70.0, np.array([1.0, 2.0, 0.9])


def path(seed=0):
    """The operator's path (T, 3), one row each 20 ms."""
    start = POSTURE.wrist + [0.0, 0.0, 0.09]
    return Operator().path(POSTURE, start, np.random.default_rng(seed))


def to_lab(places, turn_deg=TURN_DEG):
    return Rotation.from_euler("z", turn_deg, degrees=True).apply(places) + SHIFT


def columns(seed=0, turn_deg=TURN_DEG, uneven=True):
    """Quantities by name, in SI units."""
    rng = np.random.default_rng(seed)
    positions = path(seed)
    times = 0.02 * np.arange(len(positions))
    if uneven:
        at = np.sort(np.concatenate([times[[0, -1]], rng.uniform(0.0, times[-1], 4 * len(times))]))
        at = np.unique(at)
        positions = np.column_stack([np.interp(at, times, column) for column in positions.T])
        times = at
    lab = Rotation.from_euler("z", turn_deg, degrees=True)
    turns = np.column_stack([0.0 * times, 0.0 * times, 0.1 * times])
    return {
        "time": times,
        "gripper": to_lab(positions, turn_deg),
        "quaternion": (lab * Rotation.from_rotvec(turns)).as_quat(),
        "force": lab.apply(np.tile([1.0, 2.0, 3.0], (len(times), 1))),
        "shoulder": to_lab(POSTURE.shoulder, turn_deg),
        "elbow": to_lab(POSTURE.elbow, turn_deg),
        "wrist": to_lab(POSTURE.wrist, turn_deg),
    }


def write_csv(path, values, length="mm", time="s"):
    """A CSV file of quantities; the arm's joints in every line."""
    factor = {"m": 1.0, "cm": 100.0, "mm": 1000.0}[length]
    ticks = {"s": 1.0, "ms": 1e3}[time]
    names, parts = [f"time_{time}"], [ticks * values["time"]]
    for name, array in values.items():
        if name == "time":
            continue
        unit = {"quaternion": "", "force": "_n"}.get(name, f"_{length}")
        rows = np.broadcast_to(array, (len(values["time"]), array.shape[-1]))
        for axis, column in zip("xyzw", rows.T, strict=False):
            names.append(f"{name}_{axis}{unit}")
            parts.append(column * (factor if unit == f"_{length}" else 1.0))
    table = np.column_stack(parts)
    lines = [",".join(names), *(",".join(repr(float(one)) for one in row) for row in table)]
    path.write_text("\n".join(lines) + "\n")
    return path
