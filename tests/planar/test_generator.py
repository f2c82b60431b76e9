import numpy as np
import pytest

from dressing_sim.planar.box import MOUTH, violation
from dressing_sim.planar.generator import START, generate


@pytest.mark.parametrize("seed", range(6))
def test_the_demonstrator_goes_from_box_to_box_and_touches_no_wall(seed):
    data = generate(seed)
    assert len(data.training) == len(data.validation) == 3
    for demonstration in data.training + data.validation:
        start, goal = demonstration.frames
        assert start == START
        assert violation(demonstration) == 0.0
        path = demonstration.positions
        assert path.shape == (200, 2)
        assert np.linalg.norm(start.to_local(path[0])) < 0.2
        assert np.linalg.norm(goal.to_local(path[-1])) < 0.2
        assert np.linalg.det(goal.A) < 0
        for frame in (start, goal):
            mouth = np.linalg.norm(frame.to_local(path) - MOUTH, axis=1)
            assert mouth.min() < 0.3


def test_a_seed_gives_the_same_demonstrations_and_another_one_others():
    a, b, c = generate(3), generate(3), generate(4)
    np.testing.assert_array_equal(a.training[0].positions, b.training[0].positions)
    assert a.validation[2].frames == b.validation[2].frames
    assert not np.array_equal(a.training[0].positions, c.training[0].positions)


@pytest.mark.parametrize("seed", range(6))
def test_the_situations_of_a_set_are_distinct(seed):
    data = generate(seed)
    for demonstrations in (data.training, data.validation):
        origins = np.array([d.frames[1].b for d in demonstrations])
        cells = np.floor(3 * (origins - [-0.4, -0.1]) / [1.15, 0.85])
        for axis in cells.T:
            assert sorted(axis) == [0, 1, 2]


def test_people_vary():
    data = generate(0)
    starts = np.array([d.positions[0] for d in data.training])
    assert np.ptp(starts, axis=0).max() > 1e-3
