import numpy as np
import pytest
from learning_tasks import (
    moved,
    reaching_demonstrations,
    reaching_situation,
    rebased,
    rebased_frames,
)

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import TPGMM, EMOptions, Frame, SyntheticDemonstration, rotation

TURN = rotation([0.4, -1.1, 2.0])
SHIFT = np.array([3.0, -2.0, 0.5])


def test_the_model_does_not_see_where_the_world_is():
    demonstrations = reaching_demonstrations()
    a = TPGMM(4).fit(demonstrations).fitted()
    b = TPGMM(4).fit([moved(d, TURN, SHIFT) for d in demonstrations]).fitted()
    np.testing.assert_allclose(a.means, b.means, atol=1e-8)
    np.testing.assert_allclose(a.covariances, b.covariances, atol=1e-8)


def test_the_order_of_demonstrations_does_not_matter():
    demonstrations = reaching_demonstrations()
    a = TPGMM(4).fit(demonstrations).fitted()
    b = TPGMM(4).fit(demonstrations[::-1]).fitted()
    np.testing.assert_allclose(a.means, b.means, atol=1e-7)
    np.testing.assert_allclose(a.covariances, b.covariances, atol=1e-7)


def test_the_order_of_frames_does_not_matter():
    demonstrations = reaching_demonstrations()
    swapped = [SyntheticDemonstration(d.positions, d.dt, d.frames[::-1]) for d in demonstrations]
    situation = reaching_situation(np.random.default_rng(5))
    query = demonstrations[0].positions[::20]
    for order in ("regression-then-product", "product-then-regression"):
        a, _ = TPGMM(4).fit(demonstrations).regression(situation, order)(query)
        b, _ = TPGMM(4).fit(swapped).regression(situation[::-1], order)(query)
        np.testing.assert_allclose(a, b, atol=1e-8)


@pytest.mark.parametrize("order", ["regression-then-product", "product-then-regression"])
@pytest.mark.parametrize(
    "changes",
    [
        pytest.param((rotation([1.0, 2.0, 3.0]), np.eye(3)), id="rotation"),
        pytest.param((np.diag([1.0, -1, 1]), -np.eye(3)), id="reflection"),
        pytest.param((0.2 * np.eye(3), 5.0 * rotation([1.0, 0, 0])), id="scaled rotation"),
    ],
)
def test_any_basis_gives_the_same_motion(changes, order):
    """Turned, mirrored or scaled local coordinates describe the same task."""
    demonstrations = reaching_demonstrations()
    situation = reaching_situation(np.random.default_rng(5))
    query = demonstrations[0].positions[::20]
    settings = {"floor": 0.01, "relative_floor": True}
    a, _ = TPGMM(4, **settings).fit(demonstrations).regression(situation, order)(query)
    model = TPGMM(4, **settings).fit([rebased(d, changes) for d in demonstrations])
    b, _ = model.regression(rebased_frames(situation, changes), order)(query)
    np.testing.assert_allclose(a, b, atol=1e-7)


@pytest.mark.parametrize("n_frames", [1, 2, 3])
def test_any_number_of_frames(n_frames):
    extra = (Frame(TURN, SHIFT),)
    demonstrations = [
        SyntheticDemonstration(d.positions, d.dt, (d.frames + extra)[:n_frames])
        for d in reaching_demonstrations()
    ]
    model = TPGMM(3).fit(demonstrations)
    assert model.fitted().n_frames == n_frames
    means, _ = model.regression(demonstrations[0].frames)(demonstrations[0].positions[:5])
    assert np.isfinite(means).all()


@pytest.mark.parametrize("n_components", [1, 2, 5, 12, 25])
@pytest.mark.parametrize("encoding", ["time", "trajectory"])
def test_any_number_of_components(n_components, encoding):
    demonstrations = reaching_demonstrations()
    model = TPGMM(n_components, encoding=encoding).fit(demonstrations)
    assert model.fitted().n_components == n_components
    assert np.isfinite(model.log_likelihood(demonstrations))
    assert np.linalg.eigvalsh(model.fitted().covariances).min() > 0


def test_demonstrations_of_unequal_length_and_sampling():
    demonstrations = [
        *reaching_demonstrations(1, seed=0, samples=60, dt=0.1),
        *reaching_demonstrations(1, seed=1, samples=200, dt=0.02),
    ]
    with pytest.raises(InvalidInputError, match="different dt"):
        TPGMM(4).fit(demonstrations)
    data, lengths = TPGMM(4, dt=0.05).samples(demonstrations)
    assert lengths == [118, 80]
    assert data.shape == (2, 6, 198)
    assert TPGMM(4, encoding="time").fit(demonstrations).fitted().n_dims == 4


def test_displacements_are_those_of_the_path():
    demonstration = reaching_demonstrations(1)[0]
    data, _ = TPGMM(4).samples([demonstration])
    frame = demonstration.frames[1]
    path = frame.to_local(demonstration.positions)
    np.testing.assert_allclose(data[1, :3].T, path[:-1], atol=1e-12)
    np.testing.assert_allclose(data[1, 3:].T, np.diff(path, axis=0), atol=1e-12)


def test_a_duplicated_demonstration_changes_nothing():
    demonstrations = reaching_demonstrations(2)
    # Only the initial covariances know the number of samples, and the tolerance forgets them.
    options = EMOptions(200, 400, 1e-12)
    a = TPGMM(3, options=options).fit(demonstrations).fitted()
    b = TPGMM(3, options=options).fit(demonstrations * 2).fitted()
    np.testing.assert_allclose(a.means, b.means, atol=1e-5)


def test_a_warm_start_from_the_result_stays_there():
    demonstrations = reaching_demonstrations()
    settings = {"floor": 1e-9, "options": EMOptions(5, 2000, 1e-9)}
    first = TPGMM(4, **settings).fit(demonstrations)
    again = TPGMM(4, **settings).fit(demonstrations, first.fitted())
    assert again.record.n_steps < first.record.n_steps
    np.testing.assert_allclose(first.fitted().means, again.fitted().means, atol=1e-3)


def test_k_means_needs_a_generator_and_repeats_with_its_seed():
    demonstrations = reaching_demonstrations()
    with pytest.raises(InvalidInputError, match="rng="):
        TPGMM(4, initialisation="k-means").fit(demonstrations)
    a, b = (
        TPGMM(4, initialisation="k-means", rng=np.random.default_rng(3)).fit(demonstrations)
        for _ in range(2)
    )
    np.testing.assert_array_equal(a.fitted().means, b.fitted().means)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"n_components": 0}, "n_components"),
        ({"n_components": 2, "encoding": "phase"}, "encoding"),
        ({"n_components": 2, "initialisation": "random"}, "initialisation"),
        ({"n_components": 2, "dt": -1.0}, "dt"),
        ({"n_components": 2, "floor": (1.0, -1.0)}, "floor"),
    ],
)
def test_unusable_settings_are_errors(arguments, message):
    with pytest.raises(InvalidInputError, match=message):
        TPGMM(**arguments).fit(reaching_demonstrations(2))


def test_an_unfitted_model_and_a_foreign_situation_are_errors():
    demonstrations = reaching_demonstrations(2)
    with pytest.raises(InvalidInputError, match="fit"):
        TPGMM(2).regression(demonstrations[0].frames)
    model = TPGMM(2).fit(demonstrations)
    with pytest.raises(InvalidInputError, match="2 frames"):
        model.regression(demonstrations[0].frames[:1])
    with pytest.raises(InvalidInputError, match="dimension 3"):
        model.regression([Frame(np.eye(2), np.zeros(2))] * 2)
    with pytest.raises(InvalidInputError, match="warm start"):
        TPGMM(3).fit(demonstrations, model.fitted())


def test_a_demonstration_of_weight_two_counts_as_if_it_were_there_twice():
    first, *others = reaching_demonstrations(3)
    settings = {"relative_floor": True, "floor": 0.05}
    start = TPGMM(3, **settings).fit([first, *others]).fitted()
    weighted = TPGMM(3, **settings).fit([first, *others], start, weights=[6.0, 3.0, 3.0])
    twice = TPGMM(3, **settings).fit([first, first, *others], start)
    for name in ("priors", "means", "covariances"):
        expected = getattr(twice.fitted(), name)
        np.testing.assert_allclose(getattr(weighted.fitted(), name), expected, atol=1e-9)
    np.testing.assert_allclose(weighted.spread, twice.spread)


@pytest.mark.parametrize("weights", [[1.0, 2.0], [1.0, 0.0, 1.0], [1.0, np.nan, 1.0], "all"])
def test_weights_that_cannot_be_are_errors(weights):
    with pytest.raises(InvalidInputError, match="weight"):
        TPGMM(3).fit(reaching_demonstrations(3), weights=weights)
