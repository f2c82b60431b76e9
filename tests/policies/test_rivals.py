import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame
from dressing_sim.learning.rivals import METHODS, Shown
from dressing_sim.policies import rivals
from dressing_sim.policies.files import load_policy, save_policy
from dressing_sim.policies.registry import make_policy
from dressing_sim.policies.rivals import POLICIES, RivalPolicy
from dressing_sim.policies.skeleton import Skeleton
from dressing_sim.policies.warped import KinematicWarping
from dressing_sim.suites.suites import load_suite


def test_hyper_parameters_after_the_name_reach_the_method():
    policy = make_policy("kmp?kernel=12&samples=50")
    assert (policy.method.kernel, policy.method.samples) == (12.0, 50)
    assert make_policy("tp-gmr-addition").method.update == "addition"
    with pytest.raises(InvalidInputError, match="valid is one of"):
        make_policy("kmp?stiffness=1")
    with pytest.raises(InvalidInputError, match="floor is -1"):
        make_policy("tp-gmr?floor=-1")


def test_a_policy_whose_package_is_missing_is_refused_before_it_learns(monkeypatch):
    def missing(name):
        raise InvalidInputError(f"{name} is not installed")

    monkeypatch.setattr(rivals, "library", missing)
    with pytest.raises(InvalidInputError, match=r"policy 'dmp': movement_primitives.dmp is not"):
        make_policy("dmp")
    assert make_policy("kmp").method == METHODS["kmp"]


def test_an_offset_of_the_start_fades_and_leaves_the_rest(rng):
    shown = reaching_demonstrations(2)
    policy = RivalPolicy(METHODS["tp-gmr"]).fit(shown)
    frames = shown[0].frames
    one, other = (policy.generate(frames, start) for start in (np.zeros(3), np.full(3, 0.2)))
    np.testing.assert_array_equal(other[0], np.full(3, 0.2))
    np.testing.assert_array_equal(one[25:], other[25:])


def test_other_frames_than_learned_from_and_an_unfitted_policy_are_refused():
    policy = RivalPolicy(METHODS["tp-gmr"])
    with pytest.raises(InvalidInputError, match="fit"):
        policy.generate((), np.zeros(3))
    shown = reaching_demonstrations(2)
    policy.fit(shown)
    with pytest.raises(InvalidInputError, match="valid is as learned from: 2 of dimension 3"):
        policy.generate(shown[0].frames[:1], np.zeros(3))
    with pytest.raises(InvalidInputError, match="start"):
        policy.generate(shown[0].frames, np.zeros(2))


def test_a_file_of_an_unknown_method_is_refused(tmp_path):
    class Stranger(type(METHODS["nearest"])):
        """Not in the table."""

    policy = RivalPolicy(Stranger()).fit(reaching_demonstrations(2))
    with pytest.raises(InvalidInputError, match="unknown method"):
        load_policy(save_policy(policy, tmp_path / "policy.npz"))


def test_every_method_of_the_library_is_a_policy():
    assert set(METHODS) <= set(POLICIES)


def test_warping_takes_bones_to_bones(rng):
    """A path along the skeleton of one arm becomes the path along that of another."""
    here, there = (posture.frames() for posture in load_suite("val50")[:2])
    share = np.linspace(0.0, 1.0, 30)[:, None]

    def along(skeleton):
        fore = skeleton.wrist + share * (skeleton.elbow - skeleton.wrist)
        return np.concatenate([fore, skeleton.elbow + share * (skeleton.shoulder - skeleton.elbow)])

    one, other = along(Skeleton.of(here)), along(Skeleton.of(there))
    skill = KinematicWarping(samples=60).learn(Shown(one[None], (tuple(here),), 1.0), rng)
    np.testing.assert_allclose(skill(there, one[0]), other, atol=2e-3)
    np.testing.assert_allclose(skill(here, one[0]), one, atol=1e-9)
    assert isinstance(here[0], Frame)
