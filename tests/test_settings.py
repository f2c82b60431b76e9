import json
from dataclasses import dataclass, field

import pytest

from dressing_sim.episode import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.operator import OperatorConfig
from dressing_sim.settings import from_plain, to_plain


@dataclass(frozen=True)
class Inner:
    size: float = 1.0
    numbers: tuple[float, ...] = (1.0, 2.0)


@dataclass(frozen=True)
class Outer:
    inner: Inner = field(default_factory=Inner)
    name: str = "cloth"


@pytest.mark.parametrize(
    "config",
    [Outer(Inner(3.5, (4.0, 5.0)), "silk"), EpisodeConfig(hold=0.3), OperatorConfig(speed=0.2)],
)
def test_settings_go_through_json_unchanged(config):
    assert from_plain(type(config), json.loads(json.dumps(to_plain(config)))) == config


def test_plain_values_are_nested_as_the_settings_are():
    plain = {"inner": {"size": 1.0, "numbers": [1.0, 2.0]}, "name": "cloth"}
    assert to_plain(Outer()) == plain


def test_what_is_not_said_keeps_its_default():
    assert from_plain(Outer, {"inner": {"size": 2.0}}) == Outer(Inner(2.0))


@pytest.mark.parametrize(
    ("values", "parts"),
    [
        ({"colour": "red"}, ["Outer", "colour", "inner, name"]),
        ({"inner": {"weight": 1}}, ["Inner", "weight", "size, numbers"]),
    ],
)
def test_an_unknown_setting_is_an_error_that_names_it_and_the_valid_ones(values, parts):
    with pytest.raises(InvalidInputError) as caught:
        from_plain(Outer, values)
    assert all(part in str(caught.value) for part in parts)


@pytest.mark.parametrize("values", [5, {"inner": 5}])
def test_values_that_are_not_settings_are_an_error(values):
    with pytest.raises(InvalidInputError):
        from_plain(Outer, values)
