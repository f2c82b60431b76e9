"""MuJoCo's warnings: by default it adds them to MUJOCO_LOG.TXT in whatever the current folder is.

What matters of them the world reads from MuJoCo's own counters (see `World.invalid_reason`).
"""

import logging

import mujoco

_LOG = logging.getLogger("dressing_sim.mujoco")


def keep_no_file() -> None:
    """Send MuJoCo's warnings to Python's log, unless somebody has chosen a function for them."""
    config = mujoco.MjLogConfig.get()
    config.logto_file = False
    mujoco.MjLogConfig.set(config)
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_LOG.info)
