"""MuJoCo's warnings leave nothing in the user's folder."""

import subprocess
import sys
from dataclasses import replace

import mujoco
import pytest

from dressing_sim.arm import Posture
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.record import record
from dressing_sim.errors import InvalidInputError
from dressing_sim.path import Path
from dressing_sim.world.garment import Fabric, Garment
from dressing_sim.world.robot import PANDA
from dressing_sim.world.scene import SolverConfig, WorldConfig, compiled
from dressing_sim.world.sleeve import SleeveConfig

BREAKS_DOWN = """
import sys, mujoco
import {module}
if {own}:
    mujoco.set_mju_user_warning(lambda text: print("mine", text))
model = mujoco.MjModel.from_xml_string(
    "<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"
)
data = mujoco.MjData(model)
data.qpos[0], data.qvel[0] = 1e30, float("nan")
mujoco.mj_step(model, data)
print(data.warning.number.sum())
"""


@pytest.mark.parametrize(
    "module",
    ["dressing_sim.world.scene", "dressing_sim.pictures.rendering", "dressing_sim.by_name"],
)
@pytest.mark.parametrize("own", [False, True])
def test_a_warning_of_mujoco_writes_no_file_and_prints_nothing(module, own, tmp_path):
    code = BREAKS_DOWN.format(module=module, own=own)
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert list(tmp_path.iterdir()) == []
    assert run.stderr == ""
    assert run.stdout.splitlines()[-1] == "1"
    assert ("mine" in run.stdout) == own


def test_a_world_that_mujoco_refuses_is_one_line():
    spec = mujoco.MjSpec()
    spec.worldbody.add_body().add_geom(size=[-1.0, 0.0, 0.0])
    with pytest.raises(InvalidInputError, match="world: MuJoCo refuses it") as caught:
        compiled(spec)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "make",
    [
        lambda: SleeveConfig(edge=1e-6),
        lambda: SleeveConfig(edge="fine"),
        lambda: SleeveConfig(garment=3),
        lambda: SleeveConfig(grasp_offset=(1e200, 0.0, 0.0)),
        lambda: SleeveConfig(grasp_offset=None),
        lambda: Garment(length=None),
        lambda: Garment(fabric="silk"),
        lambda: Fabric(friction=1j),
        lambda: SolverConfig(timestep=[0.01]),
        lambda: SolverConfig(solver=None),
        lambda: WorldConfig(sleeve=None),
        lambda: WorldConfig(settle_time="1"),
        lambda: replace(PANDA, grip_strength=None),
    ],
)
def test_settings_of_another_kind_are_refused(make):
    with pytest.raises(InvalidInputError, match="valid") as caught:
        make()
    assert "\n" not in str(caught.value)


def test_a_world_of_absurd_numbers_that_mujoco_refuses_is_one_line():
    light = Garment(fabric=Fabric(areal_density=1e-300))
    config = EpisodeConfig(world=WorldConfig(sleeve=SleeveConfig(garment=light)))
    path = Path([[0.3, 0.0, 0.5], [0.4, 0.0, 0.5]])
    with pytest.raises(InvalidInputError, match="world: MuJoCo refuses it") as caught:
        record(path, Posture("arm", 70, 20, 30, 40), config=config)
    assert "\n" not in str(caught.value)
