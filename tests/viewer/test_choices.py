import numpy as np
import pytest

from dressing_sim.arm import ANGLE_LIMITS_DEG
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.viewer.choices import AUGMENTATIONS, Choices, policies


def test_the_first_choices_are_the_command_lines_defaults():
    choices = Choices()
    assert choices.config() == EpisodeConfig()
    assert choices.policy_name == policies()[0] == "transport"


def test_augmentation_makes_the_policies_of_the_paper():
    names = [Choices(policy="tp-gmm", augmentation=one).policy_name for one in AUGMENTATIONS]
    assert names == ["tp-gmm", "tp-gmm-noise", "tp-gmm-rf", "tp-gmm-rf-noise"]
    assert Choices(policy="expert", augmentation="rf").policy_name == "expert"


def test_friction_changes_the_episode_and_not_what_is_demonstrated_in():
    choices = Choices(friction=0.9)
    assert choices.config().world.sleeve.garment.fabric.friction == 0.9
    assert choices.nominal() == EpisodeConfig()


@pytest.mark.parametrize(
    "wrong", [{"garment": "tent"}, {"policy": "os:system"}, {"friction": -1.0}, {"seed": -1}]
)
def test_what_cannot_be_chosen_is_one_line(wrong):
    with pytest.raises(InvalidInputError, match=r"valid|must be"):
        Choices(**wrong)


def test_sliders_stay_within_the_limits_and_the_arm_changes_its_name():
    bent = Choices().bent(elbow_deg=1000.0)
    assert bent.posture.elbow_deg == ANGLE_LIMITS_DEG["elbow_deg"][1]
    assert bent.posture.name == "80,40,50,150"
    same = Choices()
    assert same.bent(elbow_deg=same.posture.elbow_deg) is same


@pytest.mark.parametrize("joint", ["elbow", "wrist"])
def test_a_dragged_joint_comes_to_where_it_is_dragged(joint):
    choices = Choices()
    there = getattr(choices.bent(flexion_deg=70.0, abduction_deg=30.0).posture, joint)
    dragged = choices.dragged(joint, there)
    assert np.linalg.norm(getattr(dragged.posture, joint) - there) < 0.004


def test_a_joint_that_is_dragged_out_of_reach_stays_on_the_arm():
    dragged = Choices().dragged("wrist", np.array([3.0, 3.0, 3.0]))
    assert dragged.posture.arm_size == Choices().posture.arm_size
