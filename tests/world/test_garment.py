from dataclasses import fields, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dressing_sim.errors import InvalidInputError
from dressing_sim.world.garment import FABRICS, GARMENTS, Fabric, Garment, find_garment

#: What was measured of jersey, and of T-shirts of size M [SI].
FABRIC_RANGES = {
    "areal_density": (0.150, 0.207),
    "membrane_stiffness": (17.0, 410.0),
    "friction": (0.31 - 0.07, 0.31 + 0.07),
}
BENDING_STIFFNESS = 2e-5
SIZE_M_RANGES = {
    "length": (0.191, 0.216),
    "armscye_circumference": (0.440, 0.480),
    "hem_circumference": (0.356, 0.368),
}


@given(membrane=st.floats(10, 500), bending=st.floats(1e-6, 1e-3), poisson=st.floats(0, 0.45))
def test_one_solid_sheet_has_both_stiffnesses(membrane, bending, poisson):
    fabric = Fabric(membrane_stiffness=membrane, bending_stiffness=bending, poisson=poisson)
    young, thickness = fabric.young, fabric.elastic_thickness
    assert young * thickness == pytest.approx(membrane)
    assert young * thickness**3 / (12 * (1 - poisson**2)) == pytest.approx(bending)


def test_there_are_garments_enough_to_compare():
    """Short sleeves in two sizes and fabrics, a long sleeve, and one with the shirt's body."""
    assert GARMENTS["tshirt-m"] == Garment()
    short = [g for g in GARMENTS.values() if g.length < 0.25 and not g.body]
    assert len({g.length for g in short}) >= 2
    assert len({g.fabric for g in short}) >= 2
    assert any(g.length > 0.35 for g in GARMENTS.values())
    assert any(g.body > 0.0 for g in GARMENTS.values())
    assert len(set(GARMENTS.values())) == len(GARMENTS) >= 3


@pytest.mark.parametrize("fabric", FABRICS.values(), ids=FABRICS)
def test_fabrics_are_within_what_was_measured_of_jersey(fabric):
    for name, (low, high) in FABRIC_RANGES.items():
        assert low <= getattr(fabric, name) <= high
    # Of bending only the order of magnitude is known.
    assert 0.5 <= fabric.bending_stiffness / BENDING_STIFFNESS <= 2.0


@pytest.mark.parametrize("garment", GARMENTS.values(), ids=GARMENTS)
def test_garments_are_made_of_a_known_fabric(garment):
    assert garment.fabric in FABRICS.values()


@pytest.mark.parametrize("name", ["tshirt-m", "tshirt-m-body"])
def test_size_m_is_within_what_was_measured(name):
    for size, (low, high) in SIZE_M_RANGES.items():
        assert low <= getattr(GARMENTS[name], size) <= high


def test_the_armscye_of_the_long_sleeve_is_that_of_size_m():
    low, high = SIZE_M_RANGES["armscye_circumference"]
    assert low <= GARMENTS["long-sleeve"].armscye_circumference <= high


@pytest.mark.parametrize(("name", "steps"), [("tshirt-l", 1), ("tshirt-xl", 2)])
def test_larger_sizes_are_graded_from_m(name, steps):
    medium, garment = GARMENTS["tshirt-m"], GARMENTS[name]
    assert garment.length - medium.length == pytest.approx(0.01 * steps)
    for size in ("armscye_circumference", "hem_circumference"):
        assert getattr(garment, size) - getattr(medium, size) == pytest.approx(0.02 * steps)


@pytest.mark.parametrize("name", GARMENTS)
def test_a_garment_is_found_by_its_name(name):
    assert find_garment(name) is GARMENTS[name]


def test_an_unknown_garment_is_an_error_that_lists_the_known():
    with pytest.raises(InvalidInputError, match=r"unknown garment 'cape'.*tshirt-m, .*long-sleeve"):
        find_garment("cape")


def numbers(config):
    return [f.name for f in fields(config) if isinstance(getattr(config, f.name), float)]


@pytest.mark.parametrize("value", [-0.1, float("nan"), float("inf")])
@pytest.mark.parametrize(
    ("config", "name"),
    [(config, name) for config in (Fabric(), Garment()) for name in numbers(config)],
)
def test_an_impossible_number_is_an_error_that_names_it(config, name, value):
    kind = type(config).__name__.lower()
    with pytest.raises(InvalidInputError, match=rf"{kind}: {name} is {value}, valid is"):
        replace(config, **{name: value})


@pytest.mark.parametrize(
    ("config", "name"),
    [(Fabric(), "friction"), (Fabric(), "damping"), (Fabric(), "poisson"), (Garment(), "body")],
)
def test_some_numbers_may_be_zero_and_the_others_may_not(config, name):
    assert getattr(replace(config, **{name: 0.0}), name) == 0.0
    for other in set(numbers(config)) - {"friction", "damping", "poisson", "body"}:
        with pytest.raises(InvalidInputError, match=rf"{other} is 0.0, valid is > 0"):
            replace(config, **{other: 0.0})


def test_a_sheet_of_poissons_ratio_a_half_is_an_error():
    with pytest.raises(InvalidInputError, match=r"poisson is 0.5, valid is 0 to below 0.5"):
        Fabric(poisson=0.5)
