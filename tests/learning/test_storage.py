import json
import os

import numpy as np
import pytest
from learning_tasks import reaching_demonstrations, reaching_situation

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import TPGMM, TimeTPGMM, TrajectoryTPGMM, load_model, save_model

DEMONSTRATIONS = reaching_demonstrations(3)
SITUATION = reaching_situation(np.random.default_rng(3))


@pytest.mark.parametrize(
    "policy",
    [
        TrajectoryTPGMM(5, fusion="regression-then-product", position_floor=0.02, samples=90),
        TrajectoryTPGMM(end_radius=0.1, shared=False, relative_floor=False, step_limit=1.5),
        TimeTPGMM(6, fusion="product-then-regression", ridge=1e-3, blend=0.5),
    ],
)
def test_a_saved_policy_generates_the_same_path_bit_for_bit(policy, tmp_path):
    path = save_model(policy.fit(DEMONSTRATIONS), tmp_path / "policy.npz")
    other = load_model(path)
    start = SITUATION[0].b
    np.testing.assert_array_equal(
        other.generate(SITUATION, start), policy.generate(SITUATION, start)
    )
    assert other.state()[0] == policy.state()[0]
    # It can go on learning as well.
    a, b = policy.refit(DEMONSTRATIONS[:2]), other.refit(DEMONSTRATIONS[:2])
    np.testing.assert_array_equal(a.generate(SITUATION, start), b.generate(SITUATION, start))


def test_a_saved_mixture_is_the_same(tmp_path):
    model = TPGMM(3, floor=(1e-3, 1e-5), relative_floor=True).fit(DEMONSTRATIONS)
    other = load_model(save_model(model, tmp_path / "model"))
    np.testing.assert_array_equal(other.fitted().covariances, model.fitted().covariances)
    assert other.log_likelihood(DEMONSTRATIONS) == model.log_likelihood(DEMONSTRATIONS)


def test_nothing_is_left_beside_the_file_and_a_failed_save_keeps_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "policy.npz"
    policy = TrajectoryTPGMM().fit(DEMONSTRATIONS)
    save_model(policy, path)
    before = path.read_bytes()

    def fails(*_args):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fails)
    with pytest.raises(InvalidInputError, match="disk full"):
        save_model(policy, path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_holds_plain_arrays_only(tmp_path):
    path = save_model(TrajectoryTPGMM().fit(DEMONSTRATIONS), tmp_path / "policy.npz")
    with np.load(path, allow_pickle=False) as archive:
        assert all(archive[name].dtype != object for name in archive.files)


def test_an_unusable_file_is_a_clear_error(tmp_path):
    with pytest.raises(InvalidInputError, match="No such file"):
        load_model(tmp_path / "none.npz")
    (tmp_path / "text.npz").write_text("not an archive")
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    np.savez(tmp_path / "pickled.npz", header=np.array([{}], dtype=object))
    for name in ("text.npz", "other.npz", "pickled.npz"):
        with pytest.raises(InvalidInputError, match="not a saved model"):
            load_model(tmp_path / name)
    whole = save_model(TrajectoryTPGMM().fit(DEMONSTRATIONS), tmp_path / "whole.npz")
    (tmp_path / "cut.npz").write_bytes(whole.read_bytes()[:2000])
    with pytest.raises(InvalidInputError, match="not a saved model"):
        load_model(tmp_path / "cut.npz")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": 99}, "99"),
        ({"kind": "forest"}, "forest"),
        ({"settings": {}}, "not a sound model"),
    ],
)
def test_a_file_of_another_kind_is_a_clear_error(change, message, tmp_path):
    path = save_model(TrajectoryTPGMM().fit(DEMONSTRATIONS), tmp_path / "policy.npz")
    with np.load(path) as archive:
        arrays = dict(archive)
    header = json.loads(str(arrays["header"])) | change
    arrays["header"] = np.array(json.dumps(header))
    np.savez(path, **arrays)
    with pytest.raises(InvalidInputError, match=message):
        load_model(path)


def test_parts_that_do_not_fit_together_are_an_error(tmp_path):
    path = save_model(TrajectoryTPGMM().fit(DEMONSTRATIONS), tmp_path / "policy.npz")
    with np.load(path) as archive:
        arrays = dict(archive)
    for name, value in (("priors", np.ones(2)), ("means", arrays["means"] * np.nan)):
        np.savez(path, **{**arrays, name: value})
        with pytest.raises(InvalidInputError, match="mixture"):
            load_model(path)


def test_what_is_not_fitted_or_not_ours_cannot_be_saved(tmp_path):
    with pytest.raises(InvalidInputError, match="fit"):
        save_model(TrajectoryTPGMM(), tmp_path / "x.npz")
    with pytest.raises(InvalidInputError, match="cannot save"):
        save_model(object(), tmp_path / "x.npz")


def test_settings_may_be_numbers_of_numpy(tmp_path):
    policy = TrajectoryTPGMM(np.int64(4), samples=np.int64(90), end_radius=np.float32(0.2))
    path = save_model(policy.fit(DEMONSTRATIONS), tmp_path / "policy.npz")
    start = SITUATION[0].b
    np.testing.assert_array_equal(
        load_model(path).generate(SITUATION, start), policy.generate(SITUATION, start)
    )
