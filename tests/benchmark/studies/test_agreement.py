"""The study that compares policies' verdicts with a finer simulation's."""

import numpy as np
import pytest
from rule_traces import RULES, good

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import Entry, EpisodeResult
from dressing_sim.benchmark.studies.agreement import (
    DECIDED,
    FINE,
    LEFT_OF_MESH,
    LEFT_OF_STEP,
    REFERENCE,
    SECONDS,
    SHORT,
    agreement_plan,
    compared,
    decided,
    dress_again,
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


def test_the_reference_refines_the_mesh_and_its_errors_are_told_by_mesh_and_step():
    default = EpisodeConfig()
    fine, longer = reference(default).world, reference(default, step=1.0).world
    coarse = reference(default, edge=1.0).world
    assert fine.sleeve.edge == longer.sleeve.edge == FINE * default.world.sleeve.edge
    assert fine.sleeve.edge < coarse.sleeve.edge == default.world.sleeve.edge
    assert fine.solver == coarse.solver
    assert fine.solver.timestep == SHORT * longer.solver.timestep
    assert longer.solver.timestep == default.world.solver.timestep
    for world in (fine, coarse, longer):
        assert world.sleeve.contact_time == 2.0 * world.solver.timestep


def test_a_verdict_that_mesh_or_step_turns_is_undecided():
    assert not decided(recording(), recording(CAUGHT), recording(), RULES)
    assert not decided(recording(), recording(), recording(CAUGHT), RULES)
    assert not decided(recording(CAUGHT), recording(), recording(CAUGHT), RULES)
    assert decided(recording(CAUGHT), recording(CAUGHT), recording(CAUGHT), RULES)
    assert decided(recording(), recording(), recording(), RULES)


def test_a_success_is_decided_beyond_richardsons_estimates():
    """Errors of the mesh and of the step, in newtons, make the coarser worlds differ so much."""
    for of_mesh, of_step in ((0.3, 0.0), (1.2, 0.0), (0.0, 0.7), (0.4, 0.5)):
        for share, expected in ((0.9, False), (1.1, True)):
            margin = share * (of_mesh + of_step)
            coarse = pulled(margin - of_mesh / LEFT_OF_MESH)
            longer = pulled(margin - of_step / LEFT_OF_STEP)
            # A margin below zero would be another verdict, which these are made not to be.
            assert decided(pulled(margin), coarse, longer, RULES) is expected


def test_the_estimates_are_richardsons():
    """Of values v + c h^2 and v + c dt in both worlds they are the reference's errors."""
    assert pytest.approx(7.0 * FINE**2) == LEFT_OF_MESH * 7.0 * (1.0 - FINE**2)
    assert pytest.approx(7.0 * SHORT) == LEFT_OF_STEP * 7.0 * (1.0 - SHORT)


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
    done = dress_again(StayingBrief(), job, plan.config)
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
