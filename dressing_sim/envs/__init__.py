"""Dressing as a reinforcement-learning environment: thin clients of the core.

Importing this registers ``dressing_sim/DressArm-v0`` if Gymnasium is installed; the same task for
dm_env is in `dressing_sim.envs.dm`.
"""

from __future__ import annotations

from importlib.util import find_spec

#: What Gymnasium calls the environment.
GYMNASIUM_ID = "dressing_sim/DressArm-v0"

if find_spec("gymnasium") is not None:
    import gymnasium

    # Gymnasium 1 has no plug-ins: an environment is there once its package is imported.
    gymnasium.register(GYMNASIUM_ID, entry_point="dressing_sim.envs.gym:DressArm")
