import sys
from types import ModuleType

import numpy as np
import pytest

from dressing_sim.benchmark import policies
from dressing_sim.benchmark.policies import BUILT_IN, DEFAULT, EXPERT, make_policy
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Policy


class Still:
    """A third party's policy: it stays where it is."""

    def fit(self, demonstrations):
        return self

    def generate(self, frames, start):
        return np.stack([start, start])


class Halfway:
    def fit(self, demonstrations):
        return self


class Demanding(Still):
    def __init__(self, taste):
        self.taste = taste


@pytest.fixture(autouse=True)
def third_party(monkeypatch):
    """A module of somebody else's."""
    module = ModuleType("third_party")
    module.Still, module.Halfway, module.Demanding = Still, Halfway, Demanding
    module.number = 5
    monkeypatch.setitem(sys.modules, "third_party", module)


@pytest.mark.parametrize("name", [*BUILT_IN, "default"])
def test_a_built_in_policy_is_new_each_time_and_dresses(name, demonstration):
    policy, other = make_policy(name), make_policy(name)
    assert isinstance(policy, Policy)
    assert policy is not other
    start = demonstration.positions[0]
    path = policy.fit([demonstration, demonstration]).generate(demonstration.frames, start)
    assert path.ndim == 2
    assert path.shape[1] == 3
    assert np.isfinite(path).all()
    np.testing.assert_array_equal(path[0], start)


def test_default_is_what_it_stands_for():
    assert DEFAULT in BUILT_IN
    assert type(make_policy("default")) is type(make_policy(DEFAULT))


def test_a_class_can_be_named():
    assert isinstance(make_policy("third_party:Still"), Still)


def test_an_installed_policy_has_a_name(monkeypatch):
    class Point:
        name = "still"

        def load(self):
            return Still

    monkeypatch.setattr(policies, "entry_points", lambda group: [Point()])
    assert isinstance(make_policy("still"), Still)
    with pytest.raises(InvalidInputError, match="still"):
        make_policy("unknown")


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("nope", "valid is one of"),
        ("", "valid is one of"),
        ("no_such_module:Class", "no_such_module"),
        ("third_party:Absent", "Absent"),
        (":Still", "':Still'"),
        (".third_party:Still", "'.third_party:Still'"),
        ("third_party:", "'third_party:'"),
        ("third_party:number", "not a class"),
        ("third_party:Halfway", "generate(frames, start)"),
        ("third_party:Demanding", "taste"),
    ],
)
def test_a_policy_that_cannot_be_had_is_an_error_that_names_it(name, part):
    with pytest.raises(InvalidInputError) as caught:
        make_policy(name)
    assert part in str(caught.value)
    assert repr(name) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_expert_does_not_learn_and_the_error_does_not_offer_it():
    with pytest.raises(InvalidInputError) as caught:
        make_policy(EXPERT)
    assert EXPERT not in str(caught.value).partition("valid")[2]
