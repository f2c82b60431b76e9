import numpy as np
import pytest

from dressing_sim.episode.operator import Operator
from dressing_sim.errors import InvalidInputError
from dressing_sim.explain.learned import check_explained, explain
from dressing_sim.learning import SyntheticDemonstration
from dressing_sim.policies.hosted import hosted_policy
from dressing_sim.policies.registry import make_policy
from dressing_sim.suites.suites import find_posture, load_suite
from dressing_sim.world.scene import WorldConfig, grip_start

ARM = find_posture("bent40")
FEW = "?samples=60&max_iterations=6"


def begin(posture):
    return grip_start(posture, WorldConfig().sleeve)


@pytest.fixture(scope="module")
def shown():
    """What the operator wants; nothing is simulated."""
    paths = [Operator().generate(p, begin(p), seed) for seed, p in enumerate(load_suite("case_a"))]
    return [
        SyntheticDemonstration(path.positions, path.dt, posture.frames())
        for path, posture in zip(paths, load_suite("case_a"), strict=True)
    ]


def explained(name, shown, arm=ARM, known=True):
    policy = hosted_policy(name).fit(shown)
    return explain(policy, name, arm, begin(arm), shown if known else ()), policy


def test_the_fused_ellipsoids_are_the_product_of_the_frames_own(shown):
    found, _ = explained("tp-gmm?samples=60", shown)
    precise = [np.linalg.inv(view.learned.final.covariances) for view in found.views]
    # Positions are not independent of displacements, whose part the product takes as well: the
    # marginal of the product is at least as certain as the product of the marginals.
    alone = np.linalg.inv(sum(precise))
    for fused, product in zip(found.fused.final.covariances, alone, strict=True):
        assert np.linalg.eigvalsh(product - fused).min() > -1e-9
    assert found.fused.initial is None
    assert all(view.synthetic == view.discarded == () for view in found.views)


def test_what_frames_saw_is_as_it_was_where_the_arm_is_the_demonstrated_one(shown):
    arm = load_suite("case_a")[0]
    found, policy = explained("tp-gmm?samples=60", shown, arm)
    for view in found.views:
        np.testing.assert_allclose(view.experts[0], shown[0].positions, atol=1e-12)
        assert not np.allclose(view.experts[1], shown[1].positions, atol=1e-3)
    np.testing.assert_array_equal(found.path, policy.generate(arm.frames(), begin(arm)).positions)
    np.testing.assert_array_equal(found.joints, [arm.shoulder, arm.elbow, arm.wrist])


def test_every_candidate_of_algorithm_1_is_there_kept_or_discarded(shown):
    found, policy = explained(f"tp-gmm-rf{FEW}", shown)
    learned = policy.policy
    for view in found.views:
        assert len(view.synthetic) == len(learned.costs) - 1
        assert len(view.synthetic) + len(view.discarded) <= learned.options.max_iterations
        assert len(view.experts) == 2
    again = learned.policy.model.in_situation(ARM.frames()).marginal(3)
    np.testing.assert_array_equal(found.fused.final.means, again.means)
    initial = make_policy("tp-gmm?samples=60").fit(shown).model.in_situation(ARM.frames())
    np.testing.assert_allclose(found.fused.initial.means, initial.means[:, :3], atol=1e-9)


def test_without_demonstrations_the_model_is_explained_alone(shown):
    found, _ = explained(f"tp-gmm-rf{FEW}", shown, known=False)
    assert found.fused.initial is None
    assert all(view.experts == view.synthetic == view.discarded == () for view in found.views)
    assert len(found.views[0].learned.final.means) == 4


@pytest.mark.parametrize("more", ["&free_axes=arm-plane", "&clearance=true"])
def test_what_surrounds_a_policy_does_not_hide_it(more, shown):
    found, policy = explained(f"tp-gmm?samples=60{more}", shown)
    assert [view.name for view in found.views] == ["shoulder", "wrist"]
    np.testing.assert_array_equal(found.path, policy.generate(ARM.frames(), begin(ARM)).positions)


def test_transport_is_explained_by_its_own_answer(shown):
    found, policy = explained("transport", shown)
    answer = policy.policy.answer(ARM.frames(), begin(ARM))
    np.testing.assert_array_equal(found.path, answer.points)
    np.testing.assert_array_equal(found.deviation, answer.deviation)
    assert found.carried.shape == (2, *found.path.shape)


def test_a_policy_that_cannot_be_explained_is_refused_before_it_learns():
    check_explained(hosted_policy("default"), "default")
    with pytest.raises(InvalidInputError, match="'expert' cannot be explained; valid is transport"):
        check_explained(hosted_policy("expert"), "expert")
