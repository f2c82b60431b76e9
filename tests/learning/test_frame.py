import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame
from dressing_sim.learning.frame import stack_frames

numbers = st.floats(-10, 10)


@given(arrays(float, (3, 3), elements=numbers), arrays(float, 3, elements=numbers))
def test_local_undoes_world_for_any_invertible_basis(basis, origin):
    if np.linalg.cond(basis) > 1e4:
        return
    frame = Frame(basis, origin)
    points = np.random.default_rng(0).standard_normal((5, 3))
    np.testing.assert_allclose(frame.to_local(frame.to_world(points)), points, atol=1e-8)


def test_world_is_basis_times_local_plus_origin():
    frame = Frame([[0, -2], [2, 0]], [1, 1])
    np.testing.assert_allclose(frame.to_world([1, 0]), [1, 3])
    np.testing.assert_allclose(frame.to_local([1, 3]), [1, 0])


def test_a_displacement_has_no_origin():
    frame = Frame([[0, -2], [2, 0]], [5, 7])
    a, b = np.array([1.0, 2.0]), np.array([-3.0, 4.0])
    expected = frame.to_world(b) - frame.to_world(a)
    np.testing.assert_allclose(frame.displacements_to_world(b - a), expected)
    np.testing.assert_allclose(frame.displacements_to_local(expected), b - a)


@pytest.mark.parametrize("shape", [(2,), (4, 2), (3, 4, 2)])
def test_points_keep_their_shape(shape):
    frame = Frame(np.eye(2), np.zeros(2))
    assert frame.to_local(np.zeros(shape)).shape == shape
    assert frame.to_world(np.zeros(shape)).shape == shape


@pytest.mark.parametrize(
    ("basis", "origin", "message"),
    [
        (np.zeros((2, 2)), np.zeros(2), "invertible"),
        ([[1, 1], [1, 1]], np.zeros(2), "invertible"),
        (np.eye(3), np.zeros(2), "shape"),
        (np.eye(2), [np.nan, 0], "finite"),
    ],
)
def test_an_unusable_frame_says_why(basis, origin, message):
    with pytest.raises(InvalidInputError, match=message):
        Frame(basis, origin)


def test_a_frame_cannot_change():
    frame = Frame(np.eye(2), np.zeros(2))
    with pytest.raises(ValueError, match="read-only"):
        frame.A[0, 0] = 2.0


def test_equal_frames_are_equal_and_hash_alike():
    a, b = Frame(np.eye(2), [1, 2]), Frame(np.eye(2), [1, 2])
    assert a == b
    assert len({a, b, Frame(np.eye(2), [1, 3])}) == 2


def test_stacking_needs_frames_of_one_dimension():
    with pytest.raises(InvalidInputError, match="dimension"):
        stack_frames([Frame(np.eye(2), np.zeros(2)), Frame(np.eye(3), np.zeros(3))])
    with pytest.raises(InvalidInputError, match="at least one"):
        stack_frames([])


@pytest.mark.parametrize("shape", [(3, 2), (4, 1), ()])
def test_arrays_of_another_dimension_are_errors(shape):
    frame = Frame(np.eye(3), np.zeros(3))
    for change in ("to_world", "to_local", "displacements_to_world", "displacements_to_local"):
        with pytest.raises(InvalidInputError, match="valid is"):
            getattr(frame, change)(np.zeros(shape))


def test_equal_frames_have_the_same_hash():
    one, other = Frame(np.eye(2), [0.0, 1.0]), Frame(np.eye(2), [-0.0, 1.0])
    assert one == other
    assert hash(one) == hash(other)


def test_a_basis_may_be_stretched_by_less_than_a_hundred_million():
    assert Frame(np.diag([1.0, 0.9e8]), np.zeros(2)).dimension == 2
    with pytest.raises(InvalidInputError, match="invertible"):
        Frame(np.diag([1.0, 1.1e8]), np.zeros(2))
    with pytest.raises(InvalidInputError, match="shape"):
        Frame(np.eye(2), np.zeros((2, 1)))


def test_a_frame_differs_by_basis_or_origin_and_is_nothing_else():
    frame = Frame(np.eye(2), [1, 2])
    assert frame != Frame(2 * np.eye(2), [1, 2])
    assert frame != Frame(np.eye(2), [1, 3])
    assert frame != "frame"
    with pytest.raises(ValueError, match="read-only"):
        frame.b[0] = 2.0
