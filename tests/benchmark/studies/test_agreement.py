"""The study that compares policies' verdicts with a finer simulation's."""

from dataclasses import replace

import numpy as np
import pytest
from rule_traces import RULES, good

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import Entry, EpisodeResult
from dressing_sim.benchmark.studies.agreement import (
    DECIDED,
    LEFT,
    REFERENCE,
    SECONDS,
    agreement_plan,
    compared,
    decided,
    dress_thrice,
    reference,
)
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.recording import Recording

POSTURE = Posture("p", flexion_deg=70.0, abduction_deg=20.0, rotation_deg=30.0, elbow_deg=40.0)
DRESSED, CAUGHT = Outcome(True), Outcome(False, (Failure("stuck", "caught"),))


def recording(outcome=DRESSED, **changes):
    return Recording(outcome, good(**changes), None, np.zeros((1, 3)))


def pulled(newtons):
    """A dressing whose margin of force is as many newtons."""
    return recording(grip_force=np.full(len(good()), RULES.grip_force - newtons))


def test_the_reference_refines_mesh_step_and_contact_together():
    default = EpisodeConfig()
    fine, coarse = reference(default).world, reference(default, finer=1.0).world
    assert fine.sleeve.edge == 0.75 * coarse.sleeve.edge == 0.75 * default.world.sleeve.edge
    for world in (fine, coarse):
        assert world.solver.timestep == 0.5 * default.world.solver.timestep
        assert world.sleeve.contact_time == 2.0 * world.solver.timestep
    assert replace(fine, sleeve=coarse.sleeve) == coarse


def test_a_verdict_that_the_mesh_turns_is_undecided():
    assert not decided(recording(), recording(CAUGHT), RULES)
    assert not decided(recording(CAUGHT), recording(), RULES)
    assert decided(recording(CAUGHT), recording(CAUGHT), RULES)
    assert decided(recording(), recording(), RULES)


def test_a_success_is_decided_beyond_richardsons_estimate():
    """An error c h^2 of 1.2 N on the fine mesh makes the coarse one differ by 1.2 N / LEFT."""
    for error in (0.3, 1.2):
        coarse = pulled(2.0 - error / LEFT)
        assert decided(pulled(2.0), coarse, RULES)
        assert not decided(pulled(0.9 * error), pulled(0.9 * error - error / LEFT), RULES)
        assert decided(pulled(1.1 * error), pulled(1.1 * error - error / LEFT), RULES)


def test_the_estimate_is_richardsons():
    """Of values v + c h^2 on both meshes it is the fine one's error."""
    coarse, fine = 0.032**2, (0.75 * 0.032) ** 2
    assert pytest.approx(7.0 * fine) == LEFT * 7.0 * (coarse - fine)


def result(here, there, sure=True, index=0):
    extra = {REFERENCE: there.to_dict(), DECIDED: sure, SECONDS: [1.0, 4.0]}
    return EpisodeResult(index, Entry("p", "d"), POSTURE, 0, 0, {}, here, extra)


def test_undecided_and_void_episodes_are_counted_apart():
    void = Outcome(False, invalid="broke down")
    told = compared(
        [
            *[result(DRESSED, DRESSED)] * 6,
            result(DRESSED, CAUGHT),
            result(CAUGHT, DRESSED, sure=False),
            result(DRESSED, DRESSED, sure=False),
            result(void, DRESSED),
        ]
    )
    assert (told["n_episodes"], told["n_agree"], told["undecided"], told["n_void"]) == (7, 6, 2, 1)
    assert told["agreement"] == pytest.approx(6 / 7)
    assert told["agreement_with_undecided"] == pytest.approx(7 / 9)
    assert (told["n_only_default"], told["n_only_reference"]) == (1, 0)
    assert told["mcnemar_p"] == 1.0
    assert told["cost_ratio"] == 0.25
    low, high = told["agreement_ci95"]
    assert low < 6 / 7 < high


def test_of_nothing_nothing_is_said():
    told = compared([])
    assert told["agreement"] is None
    assert told["cost_ratio"] is None


class StayingBrief:
    """Stays where the gripper is."""

    def generate(self, frames, start):
        return np.tile(start, (6, 1))


def test_the_same_commands_are_played_in_all_worlds():
    plan = agreement_plan(postures=1)
    job = plan.jobs[0]
    done = dress_thrice(StayingBrief(), job, plan.config)
    assert not done.outcome.success
    assert done.extra[DECIDED]
    assert len(done.extra[SECONDS]) == 2
    other = done.extra[REFERENCE]
    assert [failure["reason"] for failure in other["failures"]] == list(done.outcome.reasons)
    # The robot does the same, whatever the cloth's mesh.
    error = other["figures"]["tracking_error"]
    assert error == pytest.approx(done.outcome.metrics["tracking_error"], abs=2e-3)


def test_all_of_a_named_suite_is_tried():
    assert len(agreement_plan("random:4:7").tested) == 4
    assert len(agreement_plan().tested) == 15
    assert len(agreement_plan("random:4:7", 2).tested) == 2
