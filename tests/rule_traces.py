"""Made-up traces: a dressing as it should be, and how each thing goes wrong in it."""

import numpy as np

from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.episode.trace import Trace

RULES = Thresholds()
DT = 0.02
ROWS = 200
MOMENT = round(RULES.moment / DT)
HELD = round(RULES.hold_time / DT)
SHOULDER = np.array([0.5, -0.3, 0.2])
LINKS = ("hand", "forearm", "upper_arm")
ROBOT_LINKS = ("panda_hand", "panda_leftfinger")


def good(**changes):
    """A dressing as it should be: in four seconds the sleeve is at the shoulder."""
    progress = np.linspace(0.0, 1.0, ROWS)
    above = np.add(SHOULDER, [0.0, 0.0, 0.5 * RULES.gripper_distance])
    s = np.minimum(1.2 * progress, 1.0) * (RULES.armscye_s + 0.1)
    per_link, per_joint = (ROWS, len(LINKS)), (ROWS, 7)
    columns = {
        "tcp": above + np.outer(1.0 - np.minimum(1.2 * progress, 1.0), [0.0, 0.4, 0.0]),
        "clearance": np.full(ROWS, 0.03),
        "tracking_error": np.full(ROWS, 1e-4),
        "joint_position": np.zeros(per_joint),
        "joint_velocity": np.full(per_joint, 0.2),
        "torque": np.full(per_joint, 3.0),
        "limit_ratio": np.full((ROWS, 3), [0.3, 0.1, 0.25]),
        "armscye_s": s,
        "hem_s": s - 0.8,
        "wound": np.ones(ROWS, dtype=bool),
        "dressed_ratio": np.stack([np.maximum(s - 1.0, 0.0), 0.5 * s], axis=1),
        "line_triangle_on": np.ones(ROWS, dtype=bool),
        "line_triangle_ratio": np.stack([np.maximum(s - 1.1, 0.0), 0.4 * s], axis=1),
        "strain": np.full(ROWS, 0.5 * RULES.strain),
        "strain_median": np.full(ROWS, 0.1 * RULES.strain),
        "strain_max": np.full(ROWS, 0.8 * RULES.strain),
        "edge_strain": np.full(ROWS, 0.4 * RULES.strain),
        "holding": np.ones(ROWS, dtype=bool),
        "grip_force": np.full(ROWS, 0.2 * RULES.grip_force),
        "link_force": np.full((*per_link, 3), [0.2 * RULES.link_force, 0.0, 0.0]),
        "link_normal_force": np.full(per_link, 0.3 * RULES.link_force),
        "penetration": np.full(ROWS, 0.001),
        "hit_by": np.full(per_link, -1),
        "hit_force": np.zeros(per_link),
    }
    return Trace(DT, LINKS, ROBOT_LINKS, **(columns | changes))


def changed(name, rows, value):
    """The good trace with one quantity changed in some rows; of net forces, what is along x."""
    column = getattr(good(), name).copy()
    (column[..., 0] if name == "link_force" else column)[rows] = value
    return good(**{name: column})


LAST = slice(-1, None)
ARRIVED = 170
"""A row after the sleeve has come to the shoulder."""
LONG = slice(ARRIVED, ARRIVED + MOMENT + 1)
ENDS = {
    "stopped_short": ("tcp", LAST, np.add(SHOULDER, [0.0, 1.01 * RULES.gripper_distance, 0.01])),
    "stuck": ("armscye_s", LAST, RULES.armscye_s - 0.01),
    "ring_off": ("wound", LAST, False),
}
STOPS = {
    "hit": ("hit_by", (50, 1), 0),
    "grasp_lost": ("holding", slice(50, None), False),
    "over_strain": ("strain", LONG, 1.01 * RULES.strain),
    "over_force": ("grip_force", LONG, 1.01 * RULES.grip_force),
}
SPOILT = ENDS | STOPS
