"""LeRobot imports every package of such a name; this one registers ``--env.type=dressing_sim``."""

from dressing_sim.envs.lerobot.config import DressingSimEnv

__all__ = ["DressingSimEnv"]
