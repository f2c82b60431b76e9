"""Plug-in for LeRobot 0.6: its loops train and evaluate on ``--env.type=dressing_sim``.

LeRobot finds it by ``--env.discover_packages_path=dressing_sim.envs.lerobot``, or by itself where
the package ``lerobot_env_dressing_sim`` is installed. `arm` needs Gymnasium only, `config` LeRobot.
"""
