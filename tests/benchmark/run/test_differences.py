from math import inf, nan

import pytest

from dressing_sim.benchmark.run.agreement import differences

NESTED = {"a": {"b": [1, {"c": 0.1}], "d": None}, "e": "text", "f": [], "g": {}, "h": nan}


def test_equal_structures_have_none():
    assert differences(NESTED, {**NESTED}, "here", "there") == []


@pytest.mark.parametrize(
    ("other", "line"),
    [
        ({"e": "other"}, "e: 'text' here, 'other' there"),
        ({"f": [1]}, "f: [] here, nothing there"),
        ({"g": None}, "g: {} here, None there"),
        ({"h": inf}, "h: nan here, inf there"),
        ({"a": {"b": [1, {"c": 0.1}], "d": 0}}, "a.d: None here, 0 there"),
        (
            {"a": {"b": [1, {"c": 0.30000000000000004}], "d": None}},
            "a.b.1.c: 0.1 here, 0.30000000000000004 there",
        ),
        ({"new": True}, "new: nothing here, True there"),
    ],
)
def test_a_value_that_differs_is_named_with_both(other, line):
    assert differences(NESTED, NESTED | other, "here", "there")[0] == line


def test_the_last_bit_counts():
    assert differences([0.3], [0.1 + 0.2], "a", "b") == ["0: 0.3 a, 0.30000000000000004 b"]


def test_many_differences_are_counted():
    lines = differences(list(range(50)), list(range(1, 51)), "a", "b")
    assert lines[0] == "0: 0 a, 1 b"
    assert len(lines) == 13
    assert lines[-1] == "and 38 more"
