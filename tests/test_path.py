import numpy as np
import pytest

from dressing_sim.errors import InvalidInputError
from dressing_sim.path import checked_path, policy_path


class Told:
    """A policy that returns what it was told to."""

    def __init__(self, path, **attributes):
        self.path = path
        vars(self).update(attributes)

    def generate(self, frames, start):
        self.seen = frames, start
        return self.path


LINE = [[0.0, 0.0, 0.5], [0.1, 0.0, 0.5], [0.2, 0.0, 0.5]]


@pytest.mark.parametrize(
    ("path", "part"),
    [
        (None, "()"),
        ("left", "'left'"),
        ([[0.0, 1.0], [0.0]], "[[0.0, 1.0], [0.0]]"),
        (np.zeros((10, 2)), "(10, 2)"),
        (np.zeros(3), "(3,)"),
        (np.zeros((1, 3)), "(1, 3)"),
        (np.zeros((0, 3)), "(0, 3)"),
        (np.full((4, 3), np.nan), "not finite"),
        (np.full((4, 3), -np.inf), "not finite"),
    ],
)
def test_a_path_that_is_none_is_an_error_that_names_its_maker(path, part):
    with pytest.raises(InvalidInputError) as caught:
        checked_path(path, "policy Told")
    message = str(caught.value)
    assert message.startswith("policy Told: returned")
    assert part in message
    assert "valid" in message
    assert "\n" not in message


def test_a_policy_is_asked_for_a_situation_and_its_path_is_an_array():
    policy, frames, start = Told(LINE), object(), object()
    path, dt = policy_path(policy, frames, start, 0.05, 30.0)
    assert policy.seen == (frames, start)
    np.testing.assert_array_equal(path, np.array(LINE))
    assert dt == 0.05


@pytest.mark.parametrize(
    ("dt", "expected"),
    [(None, 0.05), (0.1, 0.1), (1, 1.0), (np.float32(0.5), 0.5), (np.int64(2), 2.0), (30.0, 30.0)],
)
def test_the_time_step_is_the_policy_s_or_the_default(dt, expected):
    got = policy_path(Told(LINE, dt=dt), None, None, 0.05, 30.0)[1]
    assert got == expected
    assert type(got) is float
    # Without a word of its own a policy is never too slow.
    assert policy_path(Told(LINE), None, None, 0.05, 0.02)[1] == 0.05


@pytest.mark.parametrize(
    "dt", [0, -0.1, 30.1, 1e300, np.nan, np.inf, True, np.True_, "slow", 1j, [0.1]]
)
def test_a_time_step_that_is_none_is_an_error_that_names_the_policy(dt):
    with pytest.raises(InvalidInputError, match=r"policy Told: its attribute dt is .*valid is"):
        policy_path(Told(LINE, dt=dt), None, None, 0.05, 30.0)


@pytest.mark.parametrize("thing", [LINE, None, 3.0, Told])
def test_what_is_no_policy_is_an_error(thing):
    with pytest.raises(InvalidInputError, match=r"cannot dress with .*valid is"):
        policy_path(thing, None, None, 0.05, 30.0)
