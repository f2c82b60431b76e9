"""How a person moves, in closed form; nothing is simulated."""

import json
from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.errors import InvalidInputError
from dressing_sim.motion import COORDINATES, UNITS, Compliance, Drift, Motion, Sway
from dressing_sim.suites.motions import MotionDistribution

ELBOW = COORDINATES.index("elbow_deg")
MOTION = Motion(
    (Sway("elbow_deg", 4.0, 0.3, 25.0), Sway("shoulder_x", 0.01, 0.2)),
    (Drift("flexion_deg", -10.0, 1.0, 4.0), Drift("elbow_deg", 6.0, 2.0, 3.0)),
    Compliance(),
)


def posture(motion=MOTION):
    return Posture("one", 70, 20, 30, 40, motion=motion)


def test_a_sway_is_where_its_formula_says_once_it_has_grown():
    motion = Motion((Sway("elbow_deg", 4.0, 0.3, 25.0),))
    for time in (1.0, 2.7, 11.3):
        angle = 4.0 * np.sin(2.0 * np.pi * 0.3 * time + np.deg2rad(25.0))
        wanted = np.zeros(7)
        wanted[ELBOW] = np.deg2rad(angle)
        np.testing.assert_allclose(motion.offsets(time), wanted, atol=1e-15)


def test_a_drift_goes_half_way_in_half_its_time_and_stays_at_its_end():
    motion = Motion(drift=(Drift("shoulder_z", -0.02, 2.0, 6.0),))
    for time, share in ((0.0, 0.0), (2.0, 0.0), (5.0, 0.5), (8.0, 1.0), (100.0, 1.0)):
        assert motion.offsets(time)[2] == pytest.approx(-0.02 * share)


def test_it_begins_in_the_posture_and_at_rest():
    motion = Motion((Sway("elbow_deg", 4.0, 0.3, 90.0),))
    assert not motion.offsets(0.0).any()
    assert not motion.offsets(-1.0).any()
    assert abs(motion.offsets(1e-3)[ELBOW]) < 1e-9


def test_sways_and_drifts_add_up():
    parts = [Motion((one,)) for one in MOTION.sway] + [Motion(drift=(one,)) for one in MOTION.drift]
    for time in (0.4, 3.0, 7.0):
        total = sum(part.offsets(time) for part in parts)
        np.testing.assert_allclose(MOTION.offsets(time), total, atol=1e-15)


def test_a_drift_that_begins_later_is_the_same_later():
    early, late = (Motion(drift=(Drift("elbow_deg", 5.0, b, 3.0),)) for b in (0.0, 2.0))
    for time in np.linspace(0.0, 5.0, 11):
        np.testing.assert_allclose(late.offsets(time + 2.0), early.offsets(time), atol=1e-15)


def test_it_never_goes_beyond_its_bounds(rng):
    for _ in range(20):
        motion = MotionDistribution().draw(rng)
        least, most = motion.farthest() * UNITS
        for time in np.linspace(0.0, 30.0, 301):
            assert (motion.offsets(time) >= least - 1e-12).all()
            assert (motion.offsets(time) <= most + 1e-12).all()


def test_a_file_holds_it_to_the_last_bit():
    text = json.dumps(posture().to_dict())
    assert Posture.from_dict(json.loads(text)) == posture()
    assert "motion" not in posture(None).to_dict()
    assert hash(posture()) != hash(posture(None))


def test_a_still_posture_at_the_coordinates_of_another_is_that_one():
    one = posture(None)
    assert one.at(one.coordinates) == one
    assert posture().at(one.coordinates) == one  # whoever sees an arm does not see its motion
    bent = one.at(one.coordinates + np.eye(7)[ELBOW] * 15.0)
    assert bent == replace(one, elbow_deg=55.0)
    assert one.at(one.coordinates + 1e3).elbow_deg == 150.0  # the nearest that there is


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: Sway("nose", 1.0, 0.2), "sway: coordinate"),
        (lambda: Sway("elbow_deg", 80.0, 0.2), "amplitude"),
        (lambda: Sway("elbow_deg", 1.0, 9.0), "frequency"),
        (lambda: Drift("elbow_deg", np.nan), "change"),
        (lambda: Drift("elbow_deg", 1.0, 0.0, 0.0), "duration"),
        (lambda: Compliance((1.0, 2.0)), "stiffness has shape"),
        (lambda: Compliance(damping=(1.0, 1.0, 1.0, -1.0)), "damping"),
        (lambda: Motion(("elbow_deg",)), "a list of Sway"),
        (lambda: Motion(compliance=3.0), "a Compliance or None"),
        (lambda: Motion.from_dict({"sway": [{"coordinate": "elbow_deg"}]}), "too few keys"),
        (lambda: Motion.from_dict({"sway": {}}), "valid is a list of objects"),
        (lambda: Motion.from_dict({"sway": [{}] * 101}), "101 of sway, valid is up to 100"),
        (lambda: Motion.from_dict({"\n": 1}), "unknown setting"),
        (lambda: Motion.from_dict({"shiver": 1}), "unknown setting shiver"),
        (lambda: Motion.from_dict([1]), "motion is"),
        (lambda: Posture("one", 70, 20, 30, 3, motion=MOTION), "takes elbow_deg from -1 to 13"),
        (lambda: Posture("one", 70, 20, 30, 3, motion="still"), "a Motion or None"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(make, match):
    with pytest.raises(InvalidInputError, match=match) as error:
        make()
    assert "\n" not in str(error.value)
