"""Step a dressing by hand, branch it from a snapshot, and see that both branches repeat.

python examples/01_step_a_dressing.py
"""

import numpy as np

from dressing_sim import Dressing, load_suite

POSTURE = load_suite("paper5")[1]
UP_THE_FOREARM = 60  # control steps of 0.02 s


def lead(dressing: Dressing, aside: float, steps: int) -> bytes:
    """Lead the gripper towards above the elbow, or beside it; returns the moment it came to."""
    goal = POSTURE.elbow + np.array([aside, 0.0, 0.10])
    for _ in range(steps):
        if dressing.done:
            break
        way = goal - dressing.target
        dressing.step(dressing.target + 0.002 * way / max(np.linalg.norm(way), 0.002))
    return dressing.snapshot()


dressing = Dressing(POSTURE)
row = dressing.reset()
print(f"the gripper starts at {row.tcp.round(3)} m; the armscye is at s = {row.armscye_s:.2f}")

trunk = lead(dressing, aside=0.0, steps=UP_THE_FOREARM)
ends = {}
for aside in (0.0, -0.08):
    for attempt in ("first", "second"):
        dressing.restore(trunk)
        ends[aside, attempt] = lead(dressing, aside, steps=80)
    row = dressing.row
    print(f"{aside:+.2f} m aside: s = {row.armscye_s:.2f}, pull {row.grip_force:.2f} N")
    assert ends[aside, "first"] == ends[aside, "second"], "a branch repeats to the bit"

assert ends[0.0, "first"] != ends[-0.08, "first"]
print("both branches repeat to the bit;", ", ".join(dressing.outcome().reasons))
