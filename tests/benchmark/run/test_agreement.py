import json
from copy import deepcopy
from math import inf, nan

import pytest

from dressing_sim.benchmark.run.agreement import RELATIVE, SMALL, compare, differences

OTHER = "blas Sandybridge recorded, Haswell now"
RECORDED = {
    "index": 7,
    "policy": "tp-gmm",
    "seed": 12345,
    "success": False,
    "failures": [{"reason": "over_force", "detail": "grip 30.1 N", "time": 3.2}],
    "figures": {"strain": 0.1, "grip_force": 30.1, "hit_force": 0.0, "count": float("nan")},
    "void": None,
    "versions": {"mujoco": "4.0"},
}


def changed(place, value):
    line = deepcopy(RECORDED)
    *folders, name = place
    inner = line
    for folder in folders:
        inner = inner[folder]
    inner[name] = value
    return json.loads(json.dumps(line))


@pytest.mark.parametrize("numerics", ["", OTHER])
def test_the_same_line_is_the_same_to_the_bit(numerics):
    found = compare(RECORDED, deepcopy(RECORDED), numerics)
    assert found.holds
    assert found.differences == found.beyond == []
    assert found.told() == "identical to the recorded episode, to the bit"


@pytest.mark.parametrize(
    ("place", "value", "largest"),
    [
        (("figures", "grip_force"), 30.1 * (1 + 3e-9), 3e-9),
        (("figures", "grip_force"), 30.1 * (1 - 0.9 * RELATIVE), 0.9 * RELATIVE),
        (("failures", 0, "time"), 3.2 * (1 + 1e-12), 1e-12),
        (("figures", "hit_force"), 0.9 * RELATIVE * SMALL, 0.9 * RELATIVE),
        (("failures", 0, "detail"), "grip 30.2 N", 0.0),
    ],
)
def test_the_last_bits_may_differ_where_the_numerics_do_and_only_there(place, value, largest):
    line = changed(place, value)
    here = compare(RECORDED, line)
    assert not here.holds
    assert len(here.beyond) == 1
    there = compare(RECORDED, line, OTHER)
    assert there.holds
    assert there.differences == here.differences
    assert there.largest == pytest.approx(largest, rel=1e-3, abs=1e-15)
    assert there.told().startswith("the same verdict as recorded, numbers within ")
    assert OTHER in there.told()


@pytest.mark.parametrize(
    ("place", "value"),
    [
        (("figures", "grip_force"), 30.1 * (1 + 1.1 * RELATIVE)),
        (("figures", "grip_force"), float("nan")),
        (("figures", "count"), 1.0),
        (("figures", "hit_force"), 1.1 * RELATIVE * SMALL),
        (("figures", "another"), 1.0),
        (("success",), True),
        (("failures", 0, "reason"), "over_strain"),
        (("failures",), []),
        (("failures", 0, "time"), 3.22),
        (("failures", 0, "time"), None),
        (("seed",), 12346),
        (("policy",), "tp-gmm-rf"),
        (("void",), "solver warning"),
    ],
)
def test_another_verdict_or_number_is_another_episode_everywhere(place, value):
    found = compare(RECORDED, changed(place, value), OTHER)
    assert not found.holds
    assert set(found.beyond) <= set(found.differences)
    assert any(str(place[-1]) in line or "failures" in line for line in found.beyond)


def test_versions_and_provenance_are_no_measurements():
    line = changed(("versions", "mujoco"), "3.0") | {"provenance": {"commit": "abc"}}
    assert compare(RECORDED, line).differences == []


def test_times_are_the_machines():
    timed = [{**RECORDED, "extra": {"seconds": [n, 2.0], "decided": True}} for n in (1.0, 9.0)]
    assert compare(*timed).differences == []
    other = {**timed[0], "extra": {"seconds": [1.0, 2.0], "decided": False}}
    assert compare(timed[0], other).differences


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
