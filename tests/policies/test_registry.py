import pickle
import sys
from types import ModuleType

import numpy as np
import pytest

from dressing_sim.config import to_plain
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Policy, SyntheticDemonstration
from dressing_sim.policies import registry as policies
from dressing_sim.policies.paper import PaperSettings, SamplerOf, settings_from_text
from dressing_sim.policies.registry import BUILT_IN, DEFAULT, EXPERT, is_built_in, make_policy
from dressing_sim.suites.suites import load_suite


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


class Random(Still):
    def __init__(self, seed=None):
        self.seed = seed


@pytest.fixture(autouse=True)
def third_party(monkeypatch):
    """A module of somebody else's."""
    module = ModuleType("third_party")
    module.Still, module.Halfway, module.Demanding = Still, Halfway, Demanding
    module.Random = Random
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


def test_a_class_is_given_a_seed_if_it_takes_one():
    assert make_policy("third_party:Random", seed=5).seed == 5
    assert isinstance(make_policy("third_party:Still", seed=5), Still)


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
        ("third_party:Still?seed=1", "takes no settings"),
        ("tp-gmm?", "name=value"),
        ("tp-gmm?end_radius", "name=value"),
        ("tp-gmm?floor=1", "position_floor"),
        ("tp-gmm?end_radius=0&end_radius=0", "twice"),
        ("tp-gmm?end_radius=far", "a number"),
        ("tp-gmm?end_radius=nan", ">= 0"),
        ("tp-gmm?position_floor=-1", ">= 0"),
        ("tp-gmm?samples=1.5", "a whole number"),
        ("tp-gmm?samples=1", "samples >= 3"),
        ("tp-gmm?n_components=0", "n_components >= 1"),
        ("tp-gmm-rf?shrinkage=1", "true or false"),
        ("tp-gmm-rf?situations=mars", "frames, arms"),
        ("tp-gmm-rf?fusion=", "product-then-regression"),
    ],
)
def test_a_policy_that_cannot_be_had_is_an_error_that_names_it(name, part):
    with pytest.raises(InvalidInputError) as caught:
        make_policy(name)
    assert part in str(caught.value)
    assert repr(name) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_settings_after_the_name_reach_the_policy():
    policy = make_policy("tp-gmm?position_floor=0.01&end_radius=0&relative_floor=true")
    assert policy.model.floor == (0.01, PaperSettings().displacement_floor)
    assert policy.end_radius == 0.0
    assert policy.model.relative_floor is True
    assert make_policy("tp-gmm").end_radius == PaperSettings().end_radius
    assert make_policy("default?samples=50").samples == 50


def test_every_setting_can_be_named():
    default = PaperSettings()
    plain = {
        k: str(v).lower() if v is True or v is False else v for k, v in to_plain(default).items()
    }
    assert settings_from_text("&".join(f"{k}={v}" for k, v in plain.items())) == default


def test_what_the_paper_leaves_open_is_told_as_it_can_be_named():
    settings = PaperSettings(n_components=3, relative_floor=True, end_radius=1e-7, samples=99)
    told = settings.left_open.split(", ")
    assert settings_from_text("&".join([*told, "n_components=3"])) == settings
    given = {"n_components", "max_demonstrations", "max_iterations", "snr_db"}
    assert {text.partition("=")[0] for text in told} == set(to_plain(settings)) - given


@pytest.mark.parametrize("name", [*BUILT_IN, "default", "tp-gmm?end_radius=0"])
def test_built_in_policies_are_known_by_their_names(name):
    assert is_built_in(name)


@pytest.mark.parametrize("name", [EXPERT, "third_party:Still", "tp-gmm-mine", ""])
def test_other_policies_are_not_taken_for_built_in_ones(name):
    assert not is_built_in(name)


def test_augmented_policies_differ_by_method_and_seed_and_can_be_sent_to_a_process():
    policy = make_policy("tp-gmm-rf-noise?max_iterations=9", seed=3)
    assert (policy.method, policy.seed, policy.max_iterations) == ("rf+noise", 3, 9)
    copy = pickle.loads(pickle.dumps(policy))  # what an executor does with it
    assert copy.sampler == policy.sampler


@pytest.mark.parametrize(
    ("settings", "related"),
    [
        (PaperSettings(situations="frames"), False),
        (PaperSettings(), True),
        (PaperSettings(free_axes="arm-plane"), True),
    ],
)
def test_random_situations_are_independent_frames_or_those_of_an_arm(settings, related, rng):
    shown = [SyntheticDemonstration(np.eye(3), 1.0, p.frames()) for p in load_suite("case_a")]
    sampler = SamplerOf(settings)(shown)
    gaps = []
    for _ in range(20):
        shoulder, wrist = sampler.sample(rng)
        across = np.cross(shoulder.A[:, 0], wrist.A[:, 0])
        gaps.append(abs(across @ (wrist.b - shoulder.b)) / np.linalg.norm(across))
        flat = abs(shoulder.A[:, 1] @ across) < 1e-9
        assert flat == (settings.free_axes == "arm-plane")
    assert (max(gaps) < 1e-9) == related


def test_the_expert_does_not_learn_and_the_error_does_not_offer_it():
    with pytest.raises(InvalidInputError) as caught:
        make_policy(EXPERT)
    assert EXPERT not in str(caught.value).partition("valid")[2]
