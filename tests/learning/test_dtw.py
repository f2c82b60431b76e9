import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import dtw, dtw_distance


@pytest.mark.parametrize("seed", range(25))
def test_it_equals_dtw_python(seed):
    oracle = pytest.importorskip("dtw")
    rng = np.random.default_rng(seed)
    n, m, p = rng.integers((1, 1, 1), (90, 90, 5)).tolist()
    x, y = rng.standard_normal((n, p)), rng.standard_normal((m, p))
    if seed % 2:
        x, y = x.cumsum(axis=0), y.cumsum(axis=0)
    expected = oracle.dtw(x, y, step_pattern="symmetric2")
    warping = dtw(x, y)
    assert warping.distance == pytest.approx(expected.normalizedDistance, rel=1e-9, abs=1e-9)
    assert dtw_distance(x, y) == pytest.approx(expected.normalizedDistance, rel=1e-9, abs=1e-9)
    np.testing.assert_array_equal(warping.path[:, 0], expected.index1)
    np.testing.assert_array_equal(warping.path[:, 1], expected.index2)


@settings(max_examples=50, deadline=None)
@given(n=st.integers(1, 40), m=st.integers(1, 40), seed=st.integers(0, 1000))
def test_the_path_is_a_warping_and_costs_what_is_said(n, m, seed):
    rng = np.random.default_rng(seed)
    x, y = rng.standard_normal((n, 3)), rng.standard_normal((m, 3))
    distance, path = dtw(x, y)
    assert path[0].tolist() == [0, 0]
    assert path[-1].tolist() == [n - 1, m - 1]
    steps = np.diff(path, axis=0)
    assert {tuple(step) for step in steps.tolist()} <= {(0, 1), (1, 0), (1, 1)}
    weights = np.concatenate([[1], steps.sum(axis=1)])
    local = np.linalg.norm(x[path[:, 0]] - y[path[:, 1]], axis=1)
    assert distance * (n + m) == pytest.approx((weights * local).sum(), abs=1e-9)
    assert dtw_distance(x, y) == pytest.approx(distance, abs=1e-12)
    assert dtw_distance(y, x) == pytest.approx(distance, abs=1e-12)


def test_a_path_is_no_distance_from_itself_however_slowly_it_is_run():
    x = np.random.default_rng(0).standard_normal((30, 3))
    assert dtw_distance(x, x) == 0.0
    assert dtw_distance(x, np.repeat(x, 3, axis=0)) == 0.0


def test_a_series_is_a_path_in_one_dimension():
    x, y = np.sin(np.arange(20.0)), np.cos(np.arange(30.0))
    assert dtw_distance(x, y) == dtw_distance(x[:, None], y[:, None])


def test_a_shifted_path_is_at_about_the_shift_whatever_the_lengths():
    line = np.linspace([0, 0, 0], [1, 0, 0], 50)
    for count in (50, 120):
        other = np.linspace([0, 0.1, 0], [1, 0.1, 0], count)
        assert dtw_distance(line, other) == pytest.approx(0.1, rel=0.02)


def test_the_distance_does_not_depend_on_the_world():
    rng = np.random.default_rng(0)
    x, y = rng.standard_normal((20, 2)), rng.standard_normal((30, 2))
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    moved = dtw_distance(x @ turn.T + 5, y @ turn.T + 5)
    assert moved == pytest.approx(dtw_distance(x, y))


@pytest.mark.parametrize(
    ("x", "y"),
    [
        (np.zeros((0, 3)), np.zeros((4, 3))),
        (np.zeros((4, 2)), np.zeros((4, 3))),
        (np.zeros(4), np.zeros((4, 1))),
        (np.full((4, 3), np.nan), np.zeros((4, 3))),
    ],
)
def test_unusable_paths_are_errors(x, y):
    with pytest.raises(InvalidInputError, match="dtw needs"):
        dtw_distance(x, y)


def plain_warp(x, y):
    """The recursion as it is written in the module's docstring, cell by cell."""
    local = np.linalg.norm(x[:, None] - y[None], axis=2)
    n, m = local.shape
    total = np.full((n + 1, m + 1), np.inf)
    total[0, 0] = -local[0, 0]
    for i in range(n):
        for j in range(m):
            steps = total[i, j] + 2 * local[i, j], total[i + 1, j], total[i, j + 1]
            total[i + 1, j + 1] = min(steps[0], local[i, j] + min(steps[1:]))
    i, j, path = n - 1, m - 1, [(n - 1, m - 1)]
    while i or j:
        bent, left, up = total[i, j] + local[i, j], total[i + 1, j], total[i, j + 1]
        i, j = min((bent, 0, i - 1, j - 1), (left, 1, i, j - 1), (up, 2, i - 1, j))[2:]
        path.append((i, j))
    return total[n, m] / (n + m), path[::-1]


@pytest.mark.parametrize("seed", range(40))
def test_among_equally_good_steps_the_diagonal_comes_first_and_then_the_one_along_y(seed):
    rng = np.random.default_rng(seed)
    n, m = rng.integers(1, 30, 2)
    # Whole numbers on a line have many alignments of the same cost, without rounding.
    x, y = rng.integers(0, 4, (n, 1)).astype(float), rng.integers(0, 4, (m, 1)).astype(float)
    distance, path = plain_warp(x, y)
    warping = dtw(x, y)
    assert warping.distance == distance
    assert [tuple(pair) for pair in warping.path.tolist()] == path


def test_a_long_path_against_a_short_one_takes_room_for_their_product_only():
    """Either way round; N squared of 40,000 would be 13 GB."""
    rng = np.random.default_rng(0)
    x = rng.standard_normal((40_000, 3)).cumsum(axis=0)
    y = x[::4444]
    tall, wide = dtw(x, y), dtw(y, x)
    assert tall.distance == wide.distance == dtw_distance(x, y)
    np.testing.assert_array_equal(tall.path, wide.path[:, ::-1])
    assert tall.path[-1].tolist() == [39_999, len(y) - 1]


def test_two_long_paths_take_two_bits_a_cell():
    """36 MB for these; at 32 bytes a cell it was 4.6 GB."""
    x = np.random.default_rng(0).standard_normal(12_000)
    warping = dtw(x, x)
    assert warping.distance == 0.0
    np.testing.assert_array_equal(warping.path, np.arange(12_000)[:, None] * [1, 1])
