import numpy as np
import pytest

from dressing_sim.benchmark.analysis.refinement import SAFETY, SAFETY_UNKNOWN, refine
from dressing_sim.errors import InvalidInputError


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 3.3])
@pytest.mark.parametrize("sizes", [(1.0, 2.0, 4.0), (0.02, 0.028, 0.04), (0.3, 0.31, 2.0)])
@pytest.mark.parametrize("slope", [3.0, -0.2])
def test_a_power_law_is_found_exactly(order, sizes, slope):
    values = [7.0 + slope * size**order for size in sizes]
    found = refine(sizes, values)
    assert found.order == pytest.approx(order)
    assert found.limit == pytest.approx(7.0)
    assert found.index == pytest.approx(SAFETY * abs(values[0] - 7.0) / values[0])


def test_the_order_does_not_depend_on_units():
    values = [1.0, 1.1, 1.5]
    metres, millimetres = (refine(u * np.array([0.02, 0.03, 0.05]), values) for u in (1.0, 1e3))
    assert metres.order == pytest.approx(millimetres.order)
    assert metres.limit == pytest.approx(millimetres.limit)


@pytest.mark.parametrize("values", [(1.0, 1.2, 1.1), (1.0, 1.5, 1.51)])
def test_values_that_rise_and_fall_or_change_ever_more_have_no_order(values):
    found = refine((1.0, 2.0, 4.0), values)
    assert found.order is None
    assert found.limit == 1.0
    assert found.index == pytest.approx(SAFETY_UNKNOWN * (values[1] - 1.0))


def test_equal_values_have_no_error():
    assert refine((1.0, 2.0, 4.0), (3.0, 3.0, 3.0)).index == 0.0


@pytest.mark.parametrize(
    ("sizes", "values"),
    [
        ((1.0, 2.0), (1.0, 2.0)),
        ((2.0, 1.0, 4.0), (1.0, 2.0, 3.0)),
        ((0.0, 1.0, 2.0), (1.0, 2.0, 3.0)),
        ((1.0, 2.0, 4.0), (1.0, np.nan, 3.0)),
    ],
)
def test_levels_that_are_none_are_refused(sizes, values):
    with pytest.raises(InvalidInputError, match="valid are three"):
        refine(sizes, values)
