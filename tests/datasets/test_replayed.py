"""Pictures of demonstrations: those that the environments show."""

from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.datasets.replayed import Cameras, pictures
from dressing_sim.episode.operator import Operator
from dressing_sim.errors import InvalidInputError

TWO = Cameras(("front", "side"), 64, 48)


def rows(demonstration, number):
    """The beginning of a demonstration."""
    return replace(
        demonstration,
        positions=demonstration.positions[:number],
        commands=demonstration.commands[:number],
    )


def test_they_are_the_pictures_of_the_environments_to_the_bit(demonstration, opengl):
    pytest.importorskip("gymnasium")
    from dressing_sim.envs.gym import DressArm

    env = DressArm(demonstration.posture, control="target", width=64, height=48)
    env.reset()
    actions = env.actions(Operator(), demonstration.seed)
    drawn = [*pictures(rows(demonstration, 8), TWO)]
    assert len(drawn) == 8
    for seen, action in zip(drawn, actions, strict=False):
        assert [*seen] == ["front", "side"]
        for camera, picture in seen.items():
            np.testing.assert_array_equal(picture, env.task.picture(camera))
        env.step(action)
    assert not np.array_equal(drawn[0]["front"], drawn[7]["front"])
    env.close()


def test_a_demonstration_that_goes_elsewhere_now_has_none(demonstration, opengl):
    moved = demonstration.positions + [0.0, 0.0, 0.001]
    with pytest.raises(InvalidInputError, match=r"is 0\.001 m off in row 0; valid is one"):
        next(pictures(replace(demonstration, positions=moved), TWO))
    lab = replace(demonstration, commands=None)
    with pytest.raises(InvalidInputError, match="recorded in the simulator"):
        next(pictures(lab, TWO))


@pytest.mark.parametrize(
    ("names", "told"),
    [((), "none; valid"), (("front", "front"), "each once"), (("top",), "one of front")],
)
def test_cameras_that_are_not_there_are_named(names, told):
    with pytest.raises(InvalidInputError, match=told):
        Cameras(names)
