import numpy as np
import pytest
from learning_tasks import PLANAR_FILE, needs_reference
from scipy.io import savemat

from dressing_sim.errors import InvalidInputError
from dressing_sim.planar.files import load
from dressing_sim.planar.generator import generate

DATA = generate(0)
TIMES = np.arange(1, 201) * 0.01


def arrays(demonstrations):
    return {
        "xy": np.array([d.positions for d in demonstrations]),
        "A": np.array([[f.A for f in d.frames] for d in demonstrations]),
        "b": np.array([[f.b for f in d.frames] for d in demonstrations]),
    }


def same(a, b):
    assert len(a) == len(b)
    for x, y in zip(a, b, strict=True):
        np.testing.assert_allclose(x.positions, y.positions)
        assert x.dt == pytest.approx(y.dt)
        assert x.frames == y.frames


def test_npz_without_and_with_a_validation_set(tmp_path):
    path = tmp_path / "demos.npz"
    np.savez(path, t=TIMES, **arrays(DATA.training))
    data = load(path)
    same(data.training, DATA.training)
    assert data.validation == ()
    extra = {f"validation_{name}": array for name, array in arrays(DATA.validation).items()}
    np.savez(path, t=TIMES, **arrays(DATA.training), **extra)
    same(load(path).validation, DATA.validation)


def test_a_file_of_its_own_to_validate_on(tmp_path):
    path, others = tmp_path / "demos.npz", tmp_path / "others.npz"
    extra = {f"validation_{name}": array for name, array in arrays(DATA.validation[:1]).items()}
    np.savez(path, t=TIMES, **arrays(DATA.training), **extra)
    np.savez(others, t=TIMES, **arrays(DATA.validation))
    data = load(path, others)
    same(data.training, DATA.training)
    same(data.validation, DATA.validation)


def test_a_file_to_validate_on_with_other_frames_is_named(tmp_path):
    path, others = tmp_path / "demos.npz", tmp_path / "others.npz"
    np.savez(path, t=TIMES, **arrays(DATA.training))
    fewer = arrays(DATA.validation)
    np.savez(others, t=TIMES, xy=fewer["xy"], A=fewer["A"][:, :1], b=fewer["b"][:, :1])
    with pytest.raises(InvalidInputError, match=r"others\.npz does not go with .*demos\.npz"):
        load(path, others)


def test_the_authors_mat_layout(tmp_path):
    entries = []
    for d in DATA.training:
        frames = np.empty(2, dtype=[("A", object), ("b", object)])
        for p, frame in enumerate(d.frames):
            basis = np.eye(3)
            basis[1:, 1:] = frame.A
            frames[p] = (basis, np.concatenate([[0.0], frame.b]))
        entries.append((frames, np.vstack([TIMES, d.positions.T]), 200))
    s = np.empty(3, dtype=[("p", object), ("Data0", object), ("nbData", object)])
    s[:] = entries
    path = tmp_path / "demos.mat"
    savemat(path, {"s": s, "nbSamples": 3})
    data = load(path)
    same(data.training, DATA.training)
    assert data.validation == ()


@needs_reference
def test_the_papers_file():
    data = load(PLANAR_FILE)
    assert len(data.training) == 3
    assert data.validation == ()
    assert {d.positions.shape for d in data.training} == {(200, 2)}
    assert data.training[0].dt == pytest.approx(0.01)


def test_unusable_files_are_clear_errors(tmp_path):
    with pytest.raises(InvalidInputError, match="no file"):
        load(tmp_path / "none.npz")
    text = tmp_path / "demos.txt"
    text.write_text("0 0")
    with pytest.raises(InvalidInputError, match=r"\.npz or \.mat"):
        load(text)
    for name in ("demos.npz", "demos.mat"):
        (tmp_path / name).write_text("nothing of the kind")
        with pytest.raises(InvalidInputError, match=name):
            load(tmp_path / name)
    path = tmp_path / "part.npz"
    parts = arrays(DATA.training)
    np.savez(path, t=TIMES, xy=parts["xy"], b=parts["b"])
    with pytest.raises(InvalidInputError, match="no array A"):
        load(path)
    np.savez(path, t=TIMES, **{**parts, "xy": parts["xy"][:, :, :1]})
    with pytest.raises(InvalidInputError, match="shape"):
        load(path)
    np.savez(path, t=TIMES**2, **parts)
    with pytest.raises(InvalidInputError, match="even"):
        load(path)
    np.savez(path, t=TIMES, **{**parts, "A": parts["A"] * 0})
    with pytest.raises(InvalidInputError, match="invertible"):
        load(path)
