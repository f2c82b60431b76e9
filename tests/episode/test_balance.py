"""Newton's second law of the whole cloth, in every physics step of a dressing."""

import numpy as np
import pytest

from dressing_sim.episode.record import replay
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.simulation import World
from dressing_sim.world.sleeve import vertex_body


@pytest.fixture(scope="module")
def balances(demonstration):
    """Of each step: what is left of the forces (n, 3), and the pull of the fingers (n,) [N]."""
    rows, step = [], World.step

    def watched(world):
        first = world.model.joint(f"{vertex_body(0)}_x").dofadr[0]
        cloth = slice(first, first + 3 * len(world.mesh.vertices))
        before = world.data.qvel[cloth].reshape(-1, 3).copy()
        step(world)
        gained = (world.data.qvel[cloth].reshape(-1, 3) - before) / world.model.opt.timestep
        forces = world.grip_force - sum(world.link_force(link) for link in LINKS)
        masses = world.mesh.masses
        left = masses @ gained - forces - masses.sum() * world.model.opt.gravity
        rows.append((*left, np.linalg.norm(world.grip_force)))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(World, "step", watched)
        assert replay(demonstration).outcome.success
    return np.split(np.array(rows), [3], axis=1)


def test_grip_arm_weight_and_acceleration_balance_through_a_whole_pull(balances):
    """Measured: 3e-5 N; the solver stops at a tolerance."""
    left, pull = balances
    assert len(left) > 500
    assert pull.max() > 0.2
    assert np.abs(left).max() < 1e-4
