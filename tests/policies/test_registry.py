import pickle
import sys
from dataclasses import dataclass
from types import ModuleType

import numpy as np
import pytest

from dressing_sim.config import to_plain
from dressing_sim.episode.operator import Operator
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import AugmentOptions, Policy, SyntheticDemonstration
from dressing_sim.policies import registry
from dressing_sim.policies.hyperparameters import changed
from dressing_sim.policies.paper import (
    GIVEN,
    POLICIES,
    AugmentedTPGMMConfig,
    SamplerOf,
    TPGMMConfig,
    any_of_the_paper,
    left_open,
    plain_config,
)
from dressing_sim.policies.registry import DEFAULT, EXPERT, built_in, learns, make_policy
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


class Greedy(Still):
    inputs = "everything"


@dataclass(frozen=True)
class Taste:
    sweet: float = 0.5
    kind: str | None = None


class Tunable(Still):
    def __init__(
        self, gain: float = 1.0, steps: int = 3, loud: bool = False, taste: Taste | None = None
    ):
        self.gain, self.steps, self.loud, self.taste = gain, steps, loud, taste


@dataclass(frozen=True)
class TunableConfig:
    gain: float = 1.0

    def make(self, seed=0):
        return Tunable(self.gain)


@pytest.fixture(autouse=True)
def third_party(monkeypatch):
    """A module of somebody else's."""
    module = ModuleType("third_party")
    for kind in (Still, Halfway, Demanding, Random, Greedy, Tunable, TunableConfig):
        setattr(module, kind.__name__, kind)
    module.number = 5
    monkeypatch.setitem(sys.modules, "third_party", module)


@pytest.mark.parametrize("name", [*POLICIES, "default"])
def test_a_built_in_policy_is_new_each_time_and_dresses(name, demonstration):
    policy, other = make_policy(name), make_policy(name)
    assert isinstance(policy, Policy)
    assert policy is not other
    start = demonstration.positions[0]
    path = policy.fit([demonstration, demonstration]).generate(demonstration.frames, start)
    positions = getattr(path, "positions", path)  # a policy may say how fast too
    assert positions.ndim == 2
    assert positions.shape[1] == 3
    assert np.isfinite(positions).all()
    np.testing.assert_allclose(positions[0], start, rtol=0.0, atol=1e-12)


def test_default_is_what_it_stands_for():
    assert DEFAULT in built_in()
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

    monkeypatch.setattr(registry, "entry_points", lambda group: [Point()])
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
        ("third_party:Still?seed=1", "unknown hyper-parameter 'seed'; valid is none"),
        ("third_party:Random?seed=1", "valid is none"),
        ("third_party:Tunable?volume=1", "valid is one of gain, steps, loud, sweet, kind"),
        ("third_party:Tunable?steps=1.5", "a whole number"),
        ("third_party:Tunable?sweet=very", "a number"),
        ("third_party:Greedy", "valid is one of frames, frames+force, elbow, posture"),
        ("expert?speed=0", "speed"),
        ("expert?height=1", "forearm_height"),
        ("tp-gmm?max_iterations=9", "valid is one of n_components, fusion"),
        ("tp-gmm-rf?method=noise", "'method'"),
        ("tp-gmm?", "name=value"),
        ("tp-gmm?end_radius", "name=value"),
        ("tp-gmm?floor=1", "position_floor"),
        ("tp-gmm?end_radius=0&end_radius=0", "twice"),
        ("tp-gmm?end_radius=far", "a number"),
        ("tp-gmm?end_radius=nan", ">= 0"),
        ("tp-gmm?position_floor=-1", ">= 0"),
        ("tp-gmm?samples=1.5", "a whole number"),
        ("tp-gmm?samples=1", "samples is 1, valid is a whole number, 3 to"),
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
    assert policy.model.floor == (0.01, TPGMMConfig().displacement_floor)
    assert policy.end_radius == 0.0
    assert policy.model.relative_floor is True
    assert make_policy("tp-gmm").end_radius == TPGMMConfig().end_radius
    assert make_policy("default?phases=50").config.phases == 50


def as_text(values):
    return "&".join(f"{k}={str(v).lower() if isinstance(v, bool) else v}" for k, v in values)


def test_every_hyper_parameter_can_be_named():
    default = AugmentedTPGMMConfig()
    assert changed(default, as_text(plain_config().items())) == default
    options = to_plain(AugmentOptions("rf", termination="both", retrain="cold"))
    named = as_text((k, v) for k, v in options.items() if k != "method")
    policy = make_policy(f"tp-gmm-rf?{named}")
    assert policy.options == AugmentOptions("rf", termination="both", retrain="cold")


def test_what_the_paper_leaves_open_is_told_as_it_can_be_named():
    told = left_open().split(", ")
    other = AugmentedTPGMMConfig(relative_floor=True, end_radius=1e-7, samples=99)
    assert changed(other, "&".join(told)) == AugmentedTPGMMConfig()
    assert {text.partition("=")[0] for text in told} == set(plain_config()) - set(GIVEN)


def test_summaries_hold_the_hyper_parameters_in_the_order_they_always_had():
    assert list(plain_config()) == [
        "n_components",
        "max_demonstrations",
        "max_iterations",
        "snr_db",
        "fusion",
        "position_floor",
        "displacement_floor",
        "relative_floor",
        "samples",
        "shrinkage",
        "end_radius",
        "free_axes",
        "aligned",
        "clearance",
        "situations",
        "angle_margin_deg",
        "translation_margin",
    ]


@pytest.mark.parametrize("name", [*POLICIES, "tp-gmm?end_radius=0"])
def test_the_paper_s_policies_are_known_by_their_names(name):
    assert any_of_the_paper([EXPERT, name])


def test_other_policies_are_not_taken_for_the_paper_s():
    assert not any_of_the_paper(
        [EXPERT, "default", DEFAULT, "third_party:Still", "tp-gmm-mine", ""]
    )


def test_augmented_policies_differ_by_method_and_seed_and_can_be_sent_to_a_process():
    policy = make_policy("tp-gmm-rf-noise?max_iterations=9", seed=3)
    assert (policy.options, policy.seed) == (AugmentOptions("rf+noise", max_iterations=9), 3)
    copy = pickle.loads(pickle.dumps(policy))  # what an executor does with it
    assert copy.sampler == policy.sampler


def test_a_third_party_s_policy_takes_hyper_parameters_by_its_annotations():
    policy = make_policy("third_party:Tunable?gain=2&steps=5&loud=true&sweet=0.1&kind=none")
    assert (policy.gain, policy.steps, policy.loud) == (2.0, 5, True)
    assert policy.taste == Taste(0.1)
    assert make_policy("third_party:Tunable").taste is None
    assert make_policy("third_party:TunableConfig?gain=4").gain == 4.0
    assert make_policy("third_party:Demanding?taste=good").taste == "good"


def test_a_policy_is_one_file_of_the_package(tmp_path, monkeypatch):
    (tmp_path / "lazy.py").write_text(
        "from dataclasses import dataclass\n"
        "import numpy as np\n"
        "class Lazy:\n"
        "    inputs = 'elbow'\n"
        "    def __init__(self, steps): self.steps = steps\n"
        "    def fit(self, demonstrations): return self\n"
        "    def generate(self, frames, start): return np.stack([start] * self.steps)\n"
        "@dataclass(frozen=True)\n"
        "class LazyConfig:\n"
        "    steps: int = 2\n"
        "    def make(self, seed=0): return Lazy(self.steps)\n"
        "POLICIES = {'lazy': LazyConfig()}\n"
    )
    monkeypatch.setattr(registry.policies, "__path__", [*registry.policies.__path__, str(tmp_path)])
    built_in.cache_clear()
    try:
        assert len(make_policy("lazy?steps=4").generate(None, np.zeros(3))) == 4
        assert {EXPERT, DEFAULT, *POLICIES, "lazy"} <= set(built_in())
    finally:
        built_in.cache_clear()
        sys.modules.pop("dressing_sim.policies.lazy", None)


@pytest.mark.parametrize(
    ("config", "related"),
    [
        (AugmentedTPGMMConfig(situations="frames"), False),
        (AugmentedTPGMMConfig(), True),
        (AugmentedTPGMMConfig(free_axes="arm-plane"), True),
    ],
)
def test_random_situations_are_independent_frames_or_those_of_an_arm(config, related, rng):
    shown = [SyntheticDemonstration(np.eye(3), 1.0, p.frames()) for p in load_suite("case_a")]
    sampler = SamplerOf(config)(shown)
    gaps = []
    for _ in range(20):
        shoulder, wrist = sampler.sample(rng)
        across = np.cross(shoulder.A[:, 0], wrist.A[:, 0])
        gaps.append(abs(across @ (wrist.b - shoulder.b)) / np.linalg.norm(across))
        flat = abs(shoulder.A[:, 1] @ across) < 1e-9
        assert flat == (config.free_axes == "arm-plane")
    assert (max(gaps) < 1e-9) == related


def test_the_expert_is_a_policy_that_learns_nothing():
    assert isinstance(make_policy(EXPERT), Operator)
    assert make_policy("expert?speed=0.2&sway=0").config.speed == 0.2
    assert not learns(EXPERT)
    assert not learns("expert?speed=0.2")
    assert learns("tp-gmm?samples=50")
