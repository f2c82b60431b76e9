"""Metres or millimetres, here or a kilometre away: the same path, up to the unit and the place."""

import numpy as np
import pytest
from learning_tasks import reaching_demonstrations, reaching_situation

from dressing_sim.learning import (
    Alignment,
    AugmentOptions,
    EMOptions,
    Frame,
    SyntheticDemonstration,
    TimeTPGMM,
    TrajectoryTPGMM,
    dtw,
    noise_deviation,
    remarks,
)
from dressing_sim.learning.augmented import AugmentedTPGMM
from dressing_sim.learning.carried import CarriedDemonstrations
from dressing_sim.learning.registration import by_phase, landmarks_of

DEMONSTRATIONS = reaching_demonstrations(3)
FRAMES = reaching_situation(np.random.default_rng(8))
RELATIVE = {"floor": 0.02, "ridge": 0.02, "relative_floor": True}

WORLDS = pytest.mark.parametrize(
    ("unit", "shift"),
    [(1e3, 0.0), (1e-3, 0.0), (1.0, 1e3), (1e3, 1e6)],
    ids=["mm", "km", "1 km away", "mm, 1 km away"],
)


def elsewhere(points, unit, shift):
    return unit * np.asarray(points) + shift * np.array([0.6, -0.8, 0.2])


def frames_elsewhere(frames, unit, shift):
    return tuple(Frame(frame.A, elsewhere(frame.b, unit, shift)) for frame in frames)


def demonstrations_elsewhere(unit, shift):
    return [
        SyntheticDemonstration(
            elsewhere(d.positions, unit, shift), d.dt, frames_elsewhere(d.frames, unit, shift)
        )
        for d in DEMONSTRATIONS
    ]


def carried(demonstrations, frames):
    """Transport regression, as a policy without an arm would do it."""
    phased = [by_phase(one, 0.0, 50) for one in demonstrations]
    scale = np.linalg.norm(np.diff(phased[0].points, axis=0), axis=1).sum()
    model = CarriedDemonstrations(
        np.stack([one.points for one in phased]),
        np.stack([one.times for one in phased]),
        np.stack([landmarks_of(one.frames, scale) for one in demonstrations]),
        np.arange(3.0),
        0.5 * scale,
        0.05,
        1.0,
    )
    return model.answer(landmarks_of(frames, scale), 0.5).points


POLICIES = {
    "trajectory": lambda: TrajectoryTPGMM(),
    "trajectory, other order": lambda: TrajectoryTPGMM(fusion="product-then-regression"),
    "trajectory, shrunk": lambda: TrajectoryTPGMM(shrinkage=True),
    "trajectory, prior": lambda: TrajectoryTPGMM(options=EMOptions(flooring="prior")),
    "trajectory, aligned": lambda: TrajectoryTPGMM(alignment=Alignment()),
    "trajectory, stopped": lambda: TrajectoryTPGMM(stop_outside=True),
    "time": lambda: TimeTPGMM(5, **RELATIVE),
    "time, other order": lambda: TimeTPGMM(5, fusion="product-then-regression", **RELATIVE),
    "time, aligned": lambda: TimeTPGMM(5, alignment=Alignment(), **RELATIVE),
    "augmented, noise": lambda: AugmentedTPGMM(AugmentOptions("noise", max_iterations=4)),
    "augmented, rf+noise": lambda: AugmentedTPGMM(AugmentOptions("rf+noise", max_iterations=4)),
}


@WORLDS
@pytest.mark.parametrize("name", POLICIES)
def test_every_policy_answers_in_the_unit_and_place_it_is_asked_in(name, unit, shift):
    path = POLICIES[name]().fit(DEMONSTRATIONS).generate(FRAMES, FRAMES[0].b)
    policy = POLICIES[name]().fit(demonstrations_elsewhere(unit, shift))
    asked = frames_elsewhere(FRAMES, unit, shift)
    other = policy.generate(asked, asked[0].b)
    # A kilometre away the twelfth digit of a metre is lost, and EM widens what is.
    np.testing.assert_allclose(other, elsewhere(path, unit, shift), atol=1e-5 * unit)


@WORLDS
def test_so_do_transport_warping_noise_and_remarks(unit, shift):
    others = demonstrations_elsewhere(unit, shift)
    asked = frames_elsewhere(FRAMES, unit, shift)
    expected = elsewhere(carried(DEMONSTRATIONS, FRAMES), unit, shift)
    np.testing.assert_allclose(carried(others, asked), expected, atol=1e-7 * unit)
    (a, b), (c, d) = ([one.positions for one in some[:2]] for some in (DEMONSTRATIONS, others))
    assert dtw(c, d).distance == pytest.approx(unit * dtw(a, b).distance, rel=1e-8)
    assert noise_deviation(c, 30.0, "centred") == pytest.approx(
        unit * noise_deviation(a, 30.0, "centred"), rel=1e-8
    )
    assert remarks(others) == ()


@WORLDS
def test_confidence_changes_by_the_volume_of_the_unit_alone(unit, shift):
    points = np.array([one.positions[40] for one in DEMONSTRATIONS])
    plain = TrajectoryTPGMM().fit(DEMONSTRATIONS).log_density(FRAMES, points)
    policy = TrajectoryTPGMM().fit(demonstrations_elsewhere(unit, shift))
    other = policy.log_density(
        frames_elsewhere(FRAMES, unit, shift), elsewhere(points, unit, shift)
    )
    np.testing.assert_allclose(other + 3.0 * np.log(unit), plain, atol=1e-4)
