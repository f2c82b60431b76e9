import logging

import numpy as np
import pytest
from learning_tasks import (
    PLANAR_FILE,
    moved,
    needs_reference,
    reaching_demonstrations,
)

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import SyntheticDemonstration, TrajectoryTPGMM, remarks, rotation
from dressing_sim.planar.files import load

WHOLE = reaching_demonstrations(4)


def changed(demonstration, positions):
    return SyntheticDemonstration(positions, demonstration.dt, demonstration.frames)


def cut(demonstration, first, last):
    return changed(demonstration, demonstration.positions[first:last])


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("count", [1, 2, 7])
def test_of_whole_demonstrations_there_is_nothing_to_tell(seed, count):
    assert remarks(reaching_demonstrations(count, seed=seed, wobble=0.02)) == ()


@needs_reference
def test_of_the_papers_planar_demonstrations_there_is_nothing_to_tell():
    assert remarks(load(PLANAR_FILE).training) == ()


@pytest.mark.parametrize("which", [0, 2])
@pytest.mark.parametrize("others", [1, 3])
@pytest.mark.parametrize("last", [30, 50, 64])
def test_the_one_that_was_cut_short_is_named_and_told_where(which, others, last):
    demonstrations = list(WHOLE[: others + 1])
    which = min(which, others)
    demonstrations[which] = cut(WHOLE[which], 0, last)
    (found,) = remarks(demonstrations)
    assert (found.demonstration, found.kind) == (which, "cut short")
    path = WHOLE[which].positions
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert found.amount == pytest.approx(steps[: last - 1].sum() / steps.sum(), abs=0.1)
    assert f"demonstration {which} was cut short" in str(found)


def test_one_that_begins_late_is_named():
    (found,) = remarks([*WHOLE[:2], cut(WHOLE[2], 60, None)])
    assert (found.demonstration, found.kind) == (2, "begins late")
    assert found.amount == pytest.approx(0.5, abs=0.15)


def test_standing_still_is_named_at_either_end_with_its_time():
    path = WHOLE[1].positions
    trembling = 1e-4 * np.random.default_rng(0).standard_normal((200, 3))
    rested = np.concatenate([path[0] + trembling, path, np.repeat(path[-1:], 100, axis=0)])
    found = remarks([WHOLE[0], changed(WHOLE[1], rested)], still=0.01)
    assert [(one.demonstration, one.kind) for one in found] == [
        (1, "rest at start"),
        (1, "rest at end"),
    ]
    assert found[0].amount == pytest.approx(10.0, abs=1.0)
    assert found[1].amount == pytest.approx(5.0, abs=1.0)


def test_what_is_told_depends_neither_on_the_world_nor_on_the_unit():
    turn, shift = rotation([0.4, -1.1, 2.0]), np.array([1e3, -2.0, 0.5])
    demonstrations = [WHOLE[0], cut(WHOLE[1], 0, 60)]
    (plain,) = remarks(demonstrations)
    (other,) = remarks([moved(one, turn, shift) for one in demonstrations])
    assert (other.demonstration, other.kind) == (plain.demonstration, plain.kind)
    assert other.amount == pytest.approx(plain.amount, abs=0.011)


def test_a_policy_tells_and_learns(caplog):
    with caplog.at_level(logging.WARNING, "dressing_sim"):
        TrajectoryTPGMM().fit(WHOLE)
        assert caplog.records == []
        TrajectoryTPGMM().fit([WHOLE[0], cut(WHOLE[1], 0, 60)])
    assert [record.getMessage().split(":")[0] for record in caplog.records] == [
        "demonstration 1 was cut short"
    ]


def test_unusable_shares_are_errors():
    for name in ("still", "rest_share", "least_share"):
        with pytest.raises(InvalidInputError, match=name):
            remarks(WHOLE, **{name: 1.5})
