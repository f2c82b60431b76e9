import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.learning.em import Mixture
from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.semi_markov import SemiMarkov, _Chain, _occupation


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(4), 60)


def test_states_follow_each_other_and_all_of_them_are_passed(shown):
    chain = _Chain.of(shown, 6, 1e-3, 10)
    sequence = chain.sequence(60)
    assert (sequence[0], sequence[-1]) == (0, 5)
    assert set(np.diff(sequence)) <= {0, 1}
    assert chain.durations.sum() == pytest.approx(1.0)


def test_occupation_is_that_of_all_paths_through_the_chain(rng):
    """Forwards and backwards give what summing over all sequences of states gives."""
    data = rng.standard_normal((1, 1, 1, 5))
    states = Mixture(np.full(2, 0.5), np.array([[[-1.0]], [[1.0]]]), np.ones((2, 1, 1, 1)))
    stay = np.array([0.6, 0.9])
    density = np.exp(-0.5 * (data[0, 0, 0][:, None] - np.array([-1.0, 1.0])) ** 2)
    total, occupied = 0.0, np.zeros((2, 5))
    for change in range(1, 5):  # the last row is in the last state
        sequence = (np.arange(5) >= change).astype(int)
        weight = density[np.arange(5), sequence].prod() * 0.6 ** (change - 1) * 0.4
        total += weight
        occupied[sequence, np.arange(5)] += weight
    np.testing.assert_allclose(_occupation(data, states, stay)[0], occupied / total, atol=1e-12)


def test_demonstrations_are_reproduced_from_their_start_without_jumps(shown, rng):
    skill = SemiMarkov(samples=60).learn(shown, rng)
    for path, frames in zip(shown.points, shown.situations, strict=True):
        found = skill(frames, path[0])
        np.testing.assert_allclose(found[0], path[0], atol=1e-12)
        assert np.linalg.norm(found - path, axis=1).max() < 0.06
        assert np.linalg.norm(np.diff(found, axis=0), axis=1).max() < 0.05
