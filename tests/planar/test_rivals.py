import numpy as np
import pytest

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.rivals import METHODS
from dressing_sim.planar import rivals
from dressing_sim.planar.generator import PlanarData, generate
from dressing_sim.planar.study import StudyConfig

DATA = generate(3, 3, 2)
CONFIG = StudyConfig(runs=1, components=4)
QUICK = (
    "straight",
    "nearest",
    "gmr-world",
    "tp-gmr",
    "gp-transport",
    "frame-weighted",
    "via-oracle",
)


@pytest.fixture(scope="module")
def result():
    chosen = {name: METHODS[name] for name in QUICK}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rivals, "METHODS", chosen)
        patch.setattr(rivals, "AUGMENTATIONS", ("copies",))
        yield rivals.compare([DATA], CONFIG)


def test_methods_of_the_plane_are_compared_and_others_say_why_not(result):
    compared, refused = result
    assert {one.name for one in compared} == {"tp-gmm", "tp-gmm, copies", *QUICK[:5]}
    assert "in space" in refused["frame-weighted"]
    assert "elbow" in refused["via-oracle"]
    for one in compared:
        assert np.isfinite([*one.training, *one.unseen, one.depth]).all()


def test_who_plays_demonstrations_again_has_no_training_cost(result):
    costs = {one.name: one.training[0] for one in result[0]}
    assert costs["nearest"] == pytest.approx(0.0, abs=1e-9)
    assert costs["tp-gmr"] < costs["straight"]


def test_who_does_not_look_at_the_situation_ends_elsewhere_in_new_ones(result):
    unseen = {one.name: one.unseen[0] for one in result[0]}
    assert unseen["tp-gmr"] < unseen["gmr-world"]


def test_the_table_is_sorted_and_relative_to_the_initial_model(result):
    compared, refused = result
    summary = rivals.comparison(compared, refused, CONFIG, 1)
    costs = [row["unseen"] for row in summary["rows"]]
    assert costs == sorted(costs)
    (own,) = [row for row in summary["rows"] if row["method"] == "tp-gmm"]
    assert own["percent"] == pytest.approx(100.0)
    assert "frame-weighted" in rivals.comparison_markdown(summary)


def test_unseen_demonstrations_are_needed():
    with pytest.raises(InvalidInputError, match="validate"):
        rivals.compare([PlanarData(DATA.training, ())], CONFIG)
