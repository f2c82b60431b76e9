"""People and garments by file."""

from dataclasses import astuple, replace
from functools import partial
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dressing_sim.arm import ARM_SIZES, ArmSize, Posture
from dressing_sim.benchmark.run.plan import Plan
from dressing_sim.benchmark.studies.agreement import agreement_plan
from dressing_sim.benchmark.studies.convergence import convergence_plan
from dressing_sim.benchmark.studies.evaluate import evaluation_plan
from dressing_sim.benchmark.studies.thresholds import PROTOCOL, thresholds_plan
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import assets
from dressing_sim.suites.measures import Measure, schema_table
from dressing_sim.suites.people import (
    DEVIATION,
    MEAN,
    PERSON,
    SHARE,
    TAPE,
    arm_size,
    as_person,
    load_person,
)
from dressing_sim.suites.suites import find_posture
from dressing_sim.suites.wardrobe import GARMENT, load_garment, world_with
from dressing_sim.world.garment import FABRICS, GARMENTS
from dressing_sim.world.scene import resting_sleeve

PAGE = Path(__file__).resolve().parents[2] / "docs" / "measurements.md"


@pytest.mark.parametrize("sex", MEAN)
def test_whoever_has_the_mean_measures_has_the_median_arm(sex):
    measured = dict(zip(TAPE, MEAN[sex], strict=True))
    for values in ({"sex": sex}, {"sex": sex, **measured}, {"sex": sex, "percentile": 50.0}):
        assert astuple(arm_size(values)) == pytest.approx(astuple(ARM_SIZES[sex]))


@pytest.mark.parametrize("sex", MEAN)
def test_two_standard_deviations_are_the_small_and_the_large_arm(sex):
    for percentile, name in ((2.2750131948, "small"), (97.7249868, "large")):
        size = arm_size({"sex": sex, "percentile": percentile})
        assert astuple(size) == pytest.approx(astuple(ARM_SIZES[f"{sex}_{name}"]), rel=2e-4)


@given(st.sampled_from(sorted(MEAN)), st.floats(0.8, 2.3))
def test_an_arm_grows_with_the_height_and_a_measure_changes_nothing_else(sex, height):
    size = arm_size({"sex": sex, "height_m": height})
    twice = zip(astuple(size), astuple(arm_size({"sex": sex, "height_m": 2.3})), strict=True)
    assert all(a / b == pytest.approx(height / 2.3) for a, b in twice)
    longer = arm_size({"sex": sex, "height_m": height, "forearm_length_m": 0.25})
    assert replace(longer, forearm_length=size.forearm_length) == size
    tracked = arm_size({"sex": sex, "height_m": height, "joints": {"forearm_length_m": 0.25}})
    assert tracked == replace(size, forearm_length=0.25)


def test_shares_means_and_deviations_are_of_the_same_people():
    """Mean share times mean stature (1.756 and 1.628 m) is nearly the mean."""
    for sex, stature in (("male", 1.7562), ("female", 1.6285)):
        shares = [share * stature for share in SHARE[sex]]
        assert shares == pytest.approx(MEAN[sex], rel=2e-3)
        assert all(0.04 < d / m < 0.11 for d, m in zip(DEVIATION[sex], MEAN[sex], strict=True))


@pytest.mark.parametrize("path", sorted((assets() / "people").glob("*.toml")), ids=lambda p: p.stem)
def test_people_that_come_along_can_be_dressed(path):
    size = load_person(path.stem)
    assert size == load_person(str(path))
    (arm,) = as_person([find_posture("bent40")], size)
    assert Posture.from_dict(arm.to_dict()) == arm
    assert hash(arm) == hash(Posture.from_dict(arm.to_dict()))
    assert "mm" in arm.size_name


@pytest.mark.parametrize(
    "path", sorted((assets() / "garments").glob("*.toml")), ids=lambda p: p.stem
)
def test_garments_that_come_along_can_be_meshed(path):
    sleeve = world_with(path.stem).world.sleeve
    mesh = resting_sleeve(find_posture("bent40"), sleeve)
    area = sleeve.garment.sleeve_area + sleeve.garment.body_area
    assert mesh.masses.sum() == pytest.approx(area * sleeve.garment.fabric.areal_density)


def test_names_mean_what_they_did():
    assert [load_person(name) for name in ARM_SIZES] == list(ARM_SIZES)
    assert [load_garment(name) for name in GARMENTS] == list(GARMENTS.values())


def test_a_tape_measure_says_what_a_garment_is(tmp_path):
    size_m = "sleeve_length_m = 0.2\narmhole_m = 0.48\nopening_m = 0.368\n"
    file = tmp_path / "m.toml"
    file.write_text(size_m)
    assert load_garment(str(file)) == GARMENTS["tshirt-m"]
    file.write_text(f"{size_m}[fabric]\nlike = 'interlock'\nfriction_coefficient = 0.9")
    fabric = replace(FABRICS["interlock"], friction=0.9)
    assert load_garment(str(file)) == replace(GARMENTS["tshirt-m"], fabric=fabric)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "no sex"),
        ("sex = 'male'\nheight_m = 175", r"height_m \[m\] is 175, valid is a number from 0.8"),
        ("sex = 'male'\nheight_cm = 175", "unknown key 'height_cm'; valid are name, sex, height_m"),
        ("sex = 'male'\nheight_m = 1.7\npercentile = 5", "both"),
        ("sex = 'male'\nheight_m = true", "height_m"),
        ("sex = 'male'\njoints = 3", "joints is 3"),
        ("sex = 'male'\njoints.forearm_length_m = nan", "joints.forearm_length_m"),
        ("sex = ['male']", "sex must be one of male, female"),
        ("name = ''\nsex = 'male'", "name"),
        ("sex = ", "not TOML"),
        ("a = " + "[" * 5000, "not TOML"),
        ("\0", "not TOML"),
    ],
)
def test_a_person_that_is_none_is_refused_in_one_line(text, told, tmp_path):
    file = tmp_path / "p.toml"
    file.write_text(text)
    with pytest.raises(InvalidInputError, match=told) as refused:
        load_person(str(file))
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith(f"person {file}: ")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("sleeve_length_m = 0.2", "no armhole_m"),
        ("sleeve_length_m = 0.2\narmhole_m = 0.15\nopening_m = 0.15", "armhole_m"),
        ("fabric.like = 'silk'", "fabric.like must be one of jersey"),
        ("fabric.friction_coefficient = -1", "friction_coefficient"),
    ],
)
def test_a_garment_that_is_none_is_refused(text, told, tmp_path):
    file = tmp_path / "g.toml"
    file.write_text(text)
    with pytest.raises(InvalidInputError, match=told):
        world_with(str(file))


def test_there_is_no_such_person_or_garment(tmp_path):
    with pytest.raises(
        InvalidInputError, match=r"unknown person 'x'; valid is one of male, .*child-ten"
    ):
        load_person("x")
    with pytest.raises(InvalidInputError, match=r"unknown garment '.*hospital-gown, or a TOML"):
        load_garment(str(tmp_path))


@pytest.mark.parametrize("length", [0.0, 1.0, float("nan"), "0.2"])
def test_an_arm_of_ones_own_is_checked(length):
    with pytest.raises(InvalidInputError, match="upper_arm_length"):
        replace(find_posture("bent40"), size=ArmSize(length, 0.04, 0.25, 0.03, 0.04))


def test_a_run_dresses_this_person_in_this_garment_and_its_file_says_so():
    plan = evaluation_plan(
        "paper", None, None, None, 0, garment="hospital-gown", person="child-ten"
    )
    assert {one.size for one in plan.tested} == {load_person("child-ten")}
    assert plan.demonstrated == evaluation_plan("paper", None, None, None, 0).demonstrated
    assert plan.config == world_with("hospital-gown")
    assert Plan.from_dict(plan.to_dict()) == plan
    with pytest.raises(InvalidInputError, match="is varied as well"):
        evaluation_plan("paper", None, None, ["arm"], 0, person="child-ten")


@pytest.mark.parametrize(
    "make",
    [
        partial(thresholds_plan, PROTOCOL, 0),
        partial(agreement_plan, "val50", 2, 0),
        partial(convergence_plan, "val50", 2, None, 0),
    ],
    ids=["thresholds", "agreement", "convergence"],
)
def test_studies_of_the_simulation_dress_this_person_in_this_garment(make):
    usual, plan = make(), make("hospital-gown", "child-ten")
    assert plan.tested == tuple(as_person(usual.tested, load_person("child-ten")))
    assert plan.config == world_with("hospital-gown", usual.config)
    assert plan.config.protective_stop == usual.config.protective_stop
    assert replace(plan, tested=usual.tested, config=usual.config) == usual
    assert Plan.from_dict(plan.to_dict()) == plan
    assert make("tshirt-m", None) == usual
    with pytest.raises(InvalidInputError, match="unknown garment 'x'"):
        make("x", None)
    with pytest.raises(InvalidInputError, match="unknown person 'x'"):
        make(None, "x")


@pytest.mark.parametrize("schema", [PERSON, GARMENT], ids=["person", "garment"])
def test_every_key_names_its_unit_and_the_page_has_it(schema):
    text = PAGE.read_text(encoding="utf-8")
    for line in schema_table(schema):
        assert line in text, line

    def keys(part):
        for key, wanted in part.items():
            if isinstance(wanted, Measure):
                yield key, wanted.unit
            elif isinstance(wanted, dict):
                yield from keys(wanted)

    suffix = {"m": "_m", "s": "_s", "kg/m^2": "_kg_per_m2", "N/m": "_n_per_m", "N m": "_n_m"}
    for key, unit in keys(schema):
        assert key.endswith(suffix.get(unit, ("percentile", "_ratio", "_coefficient"))), key
