import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.errors import InvalidInputError
from dressing_sim.path import Path, checked_path, policy_path


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


POSTURE = Posture("p", 70, 20, 30, 40)
START = np.zeros(3)


def asked(policy, seed=0, default_dt=0.05, longest_dt=30.0):
    return policy_path(policy, POSTURE, START, seed, default_dt, longest_dt)


def test_a_policy_is_asked_for_a_situation_and_its_path_is_an_array():
    policy = Told(LINE)
    path = asked(policy)
    frames, start = policy.seen
    assert frames == POSTURE.frames()
    assert start is START
    np.testing.assert_array_equal(path.positions, np.array(LINE))
    assert path.dt == 0.05


@pytest.mark.parametrize(
    ("inputs", "expected"),
    [
        ("frames", POSTURE.frames()),
        ("frames+force", POSTURE.frames()),
        ("elbow", POSTURE.frames("shoulder", "wrist", "elbow")),
        ("posture", POSTURE),
    ],
)
def test_a_policy_gets_what_its_class_of_inputs_stands_for(inputs, expected):
    policy = Told(LINE, inputs=inputs)
    asked(policy)
    assert policy.seen[0] == expected
    assert getattr(policy.seen[0], "names", None) == getattr(expected, "names", None)


def test_an_unknown_class_of_inputs_is_an_error():
    with pytest.raises(InvalidInputError, match=r"Told: .*inputs is 'all', valid is one of frames"):
        asked(Told(LINE, inputs="all"))


@pytest.mark.parametrize(
    ("dt", "expected"),
    [(None, 0.05), (0.1, 0.1), (1, 1.0), (np.float32(0.5), 0.5), (np.int64(2), 2.0), (30.0, 30.0)],
)
def test_the_time_step_is_the_policy_s_or_the_default(dt, expected):
    got = asked(Told(LINE, dt=dt)).dt
    assert got == expected
    assert type(got) is float
    # Without a word of its own a policy is never too slow.
    assert asked(Told(LINE), longest_dt=0.02).dt == 0.05


def test_a_path_may_say_its_own_time_step():
    assert asked(Told(Path(LINE, 0.3), dt=0.1)).dt == 0.3
    assert asked(Told(Path(LINE), dt=0.1)).dt == 0.1
    assert asked(Path(LINE, 0.3)).dt == 0.3
    assert asked(np.array(LINE)).dt == 0.05
    with pytest.raises(InvalidInputError, match=r"policy Told: its path's dt is 31"):
        asked(Told(Path(LINE, 31.0)))


@pytest.mark.parametrize("dt", [0, -0.1, np.nan, np.inf, True, "slow"])
def test_a_path_without_a_possible_time_step_is_an_error(dt):
    with pytest.raises(InvalidInputError, match=r"a path: its dt is .*valid is seconds above zero"):
        Path(LINE, dt)


def test_a_path_cannot_be_changed():
    path = Path(np.array(LINE))
    with pytest.raises(ValueError, match="read-only"):
        path.positions[0] = 1.0
    assert len(path) == 3
    with pytest.raises(InvalidInputError, match=r"a path: got an array of shape \(3,\)"):
        Path(np.zeros(3))


@pytest.mark.parametrize(
    "dt", [0, -0.1, 30.1, 1e300, np.nan, np.inf, True, np.True_, "slow", 1j, [0.1]]
)
def test_a_time_step_that_is_none_is_an_error_that_names_the_policy(dt):
    with pytest.raises(InvalidInputError, match=r"policy Told: its attribute dt is .*valid is"):
        asked(Told(LINE, dt=dt))


@pytest.mark.parametrize("thing", [LINE, None, 3.0, Told])
def test_what_is_no_policy_is_an_error(thing):
    with pytest.raises(InvalidInputError, match=r"cannot dress with .*valid is"):
        asked(thing)


class Stochastic(Told):
    """A policy with randomness of its own."""

    def generate(self, frames, start, seed):
        return np.array(LINE) + np.random.default_rng(seed).normal(0.0, 0.01, (3, 3))


def test_episodes_of_a_stochastic_policy_are_independent_and_repeat():
    policy = Stochastic(LINE)
    ends = np.array([asked(policy, seed).positions[-1] for seed in range(200)])
    again = np.array([asked(policy, seed).positions[-1] for seed in range(200)])
    np.testing.assert_array_equal(ends, again)
    off = (ends - LINE[-1]) / 0.01
    np.testing.assert_allclose(off.mean(axis=0), 0.0, atol=0.3)
    np.testing.assert_allclose(np.cov(off.T), np.eye(3), atol=0.35)
    assert abs(np.corrcoef(off[:-1, 0], off[1:, 0])[0, 1]) < 0.25


def test_two_policies_do_not_share_their_randomness():
    class Other(Stochastic):
        pass

    one, other, same = Stochastic(LINE), Other(LINE), Other(LINE, stream="Stochastic")
    assert not np.array_equal(asked(one, 5).positions, asked(other, 5).positions)
    np.testing.assert_array_equal(asked(one, 5).positions, asked(same, 5).positions)
