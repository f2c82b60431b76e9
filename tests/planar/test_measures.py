import numpy as np
import pytest
from learning_tasks import PLANAR_FILE, needs_reference

from dressing_sim.learning import SyntheticDemonstration
from dressing_sim.planar.box import MOUTH
from dressing_sim.planar.files import load
from dressing_sim.planar.generator import GOAL_BASE, START, Frame, generate
from dressing_sim.planar.measures import measures, rms_difference

GOAL = Frame(GOAL_BASE, np.array([0.5, 0.5]))
CORNERS = np.vstack([START.to_world([[0, 0], 2 * MOUTH]), GOAL.to_world([2 * MOUTH, [0, 0]])])


def demonstration(power):
    """Along a polygon through both mouths, at t ** power of its length."""
    length = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(CORNERS, axis=0), axis=1)))
    at = np.linspace(0.0, 1.0, 2001) ** power * length[-1]
    path = np.stack([np.interp(at, length, column) for column in CORNERS.T], axis=1)
    return SyntheticDemonstration(path, 0.001, (START, GOAL)), length[-1]


def test_even_motions_that_are_alike_do_not_vary():
    one, length = demonstration(1.0)
    found = measures([one, one])
    assert found.n == 2
    assert found.timing_sd == found.leaving_sd == found.entering_sd == found.lateral_sd == 0.0
    assert found.end_speed == pytest.approx(1.0, abs=1e-3)
    assert found.length == pytest.approx(length, rel=1e-3)  # corners are cut
    # The mouth is half of the way to the polygon's first corner.
    leaving = np.linalg.norm(CORNERS[1] - CORNERS[0]) / 2 / length
    assert found.leaving == pytest.approx(leaving, abs=1e-3)
    assert 1.0 - found.entering == pytest.approx(leaving, abs=1e-3)


def test_timing_is_the_deviation_of_the_times_of_a_share_of_the_way():
    found = measures([demonstration(1.0)[0], demonstration(2.0)[0]])
    share = np.linspace(0.0, 1.0, 10_001)
    # Of two times a and b the variance with n - 1 is (a - b)^2 / 2.
    assert found.timing_sd == pytest.approx(
        np.sqrt(np.mean((np.sqrt(share) - share) ** 2) / 2), rel=1e-2
    )


def test_differences_see_bends_and_tremor_but_no_even_motion():
    t = np.linspace(0.0, 1.0, 50)[:, None]
    assert rms_difference(t * [1.0, 2.0], 2) == pytest.approx(0.0, abs=1e-12)
    white = np.random.default_rng(0).standard_normal((20_000, 2))
    assert rms_difference(white, 3) == pytest.approx(np.sqrt(20.0), rel=0.05)


@needs_reference
def test_generated_demonstrations_vary_as_the_four_recordings_do():
    data = load(PLANAR_FILE, PLANAR_FILE.with_name("planar_fourth.npz"))
    people = measures((*data.training, *data.validation))
    assert people.n == 4
    assert people.leaving_sd == pytest.approx(0.124, abs=0.001)
    ours = measures([d for seed in range(12) for d in generate(seed, 3, 0).training])
    for name in ("timing_sd", "end_speed", "roughness", "acceleration", "lateral_sd", "length"):
        assert getattr(ours, name) == pytest.approx(getattr(people, name), rel=0.3), name
