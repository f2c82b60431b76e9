import matplotlib
import numpy as np
import pytest
from draw_rivals import draw, excesses, failure

from dressing_sim import load_suite
from dressing_sim.benchmark.studies.tuning_paths import PathMetrics, path_metrics, steady_path

SHOWN, TESTED = load_suite("case_a"), load_suite("val50")[:5]


@pytest.fixture(scope="module")
def straight():
    return failure("straight", SHOWN, TESTED)


def test_a_failure_is_told_by_the_criterion_that_it_misses_most():
    good = {"end_gap": 0.0, "clearance": 0.05, "largest_gap": 0.05, "mean_gap": 0.0}
    good |= {"outside": 0.1, "outside_expert": 0.12}
    assert PathMetrics(**good).dresses
    assert max(excesses(PathMetrics(**good)).values()) < 1.0
    for bad, why in (
        ({"end_gap": 0.21}, "ends 21 cm off"),
        ({"clearance": -0.01}, "runs into the arm"),
        ({"clearance": 0.012}, "12 mm from the arm"),
        ({"largest_gap": 0.3}, "strays 30 cm"),
        ({"outside": 0.0}, "cuts the bend by 12 cm"),
    ):
        metrics = PathMetrics(**(good | bad))
        found = excesses(metrics)
        assert not metrics.dresses
        assert max(found, key=found.get) == why
        assert found[why] > 1.0


def test_the_failure_in_the_middle_is_one_of_its_own(straight):
    """A straight line is drawn where it fails, and its path is straight."""
    assert 0 < straight.n_failed <= straight.n_postures == 5
    assert not straight.metrics.dresses
    expert = steady_path(straight.posture)
    np.testing.assert_array_equal(straight.expert, expert)
    assert path_metrics(straight.path, expert, straight.posture) == straight.metrics
    steps = np.diff(straight.path, axis=0)
    assert np.linalg.matrix_rank(steps, tol=1e-6) == 1


def test_arm_operator_and_policy_are_drawn_in_two_views(straight, monkeypatch):
    drawn = []
    plot = matplotlib.axes.Axes.plot
    monkeypatch.setattr(
        matplotlib.axes.Axes,
        "plot",
        lambda axes, x, y, **style: drawn.append(list(x)) or plot(axes, x, y, **style),
    )
    text = draw([straight])
    assert text == draw([straight])
    arm = [straight.posture.wrist[1], straight.posture.elbow[1], straight.posture.shoulder[1]]
    assert drawn.count(arm) == 2 * 2
    assert len(drawn) == 2 * 2 * 4
    assert "<!-- straight" in text
