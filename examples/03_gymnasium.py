"""A scripted agent in the Gymnasium environment: it feels its way, and waits when the cloth pulls.

python examples/03_gymnasium.py [--posture bent10] [--steps 1500]

It needs pip install 'dressing-sim[gymnasium]'.
"""

import argparse

import gymnasium
import numpy as np

import dressing_sim.envs  # registers the environment

SPEED, DT = 0.10, 0.02  # of the gripper [m/s]; of a control step [s]
HEIGHT = 0.09  # above the arm [m]
HARD = 1.5  # it slows down above this pull on the cloth [N]


def agent(seen: dict[str, np.ndarray], legs: list[np.ndarray]) -> np.ndarray:
    """The next action: towards the next point above the arm, or "I have finished"."""
    while legs and np.linalg.norm(legs[0] - seen["target"]) < 0.005:
        legs.pop(0)
    if not legs:
        return np.array([0.0, 0.0, 0.0, 1.0])
    way = legs[0] - seen["target"]
    slow = 0.3 if seen["grip_force"][0] > HARD else 1.0
    return np.append(slow * SPEED * DT * way / np.linalg.norm(way), 0.0)


def main() -> None:
    """One episode."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--posture", default="bent10")
    parser.add_argument("--steps", type=int, default=1500)
    args = parser.parse_args()
    env = gymnasium.make(dressing_sim.envs.GYMNASIUM_ID, posture=args.posture)
    seen, info = env.reset(seed=0)
    above = np.array([0.0, 0.0, HEIGHT])
    # Of the arm it knows the frames: each x axis points from its joint to the elbow.
    elbow = seen["wrist_position"] + 0.25 * seen["wrist_axes"][:, 0]
    legs = [point + above for point in (seen["wrist_position"], elbow, seen["shoulder_position"])]
    total = 0.0
    for step in range(1, args.steps + 1):
        seen, reward, terminated, truncated, info = env.step(agent(seen, legs))
        total += float(reward)
        if step % 50 == 0:
            print(f"{step * DT:4.1f} s: pull {seen['grip_force'][0]:.2f} N, return {total:.2f}")
        if terminated or truncated:
            break
    env.close()
    verdict = "dressed" if info["is_success"] else ", ".join(info.get("reasons", ["not over"]))
    print(f"{args.posture} after {step} steps: {verdict}; the rewards add up to {total:.2f}")


if __name__ == "__main__":
    main()
