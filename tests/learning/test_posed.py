import numpy as np
import pytest
from learning_tasks import moved_frames, reaching, reaching_situation
from scipy.spatial.transform import Rotation

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame, SyntheticDemonstration, rotation
from dressing_sim.learning import quaternions as quat
from dressing_sim.learning.posed import PoseDemonstration, TimePoseTPGMM

TURN, SHIFT = rotation([0.4, -0.9, 2.1]), np.array([0.3, -0.6, 0.2])


def posed(frames, rng, samples=60):
    """A reach whose hand turns from the start's axes to the goal's."""
    path = reaching(frames, rng, samples=samples)
    begin, end = quat.of_matrices(np.stack([frame.A for frame in frames]), "frames")
    phase = np.linspace(0.0, 1.0, samples)[:, None]
    turned = quat.exp(np.tile(begin, (samples, 1)), phase * quat.log(begin, end))
    return PoseDemonstration(path.positions, path.dt, frames, turned)


@pytest.fixture(scope="module")
def demonstrations():
    rng = np.random.default_rng(3)
    return [posed(reaching_situation(rng), rng) for _ in range(8)]


@pytest.fixture(scope="module")
def model(demonstrations):
    return TimePoseTPGMM(3, samples=40).fit(demonstrations)


@pytest.fixture(scope="module")
def asked():
    return reaching_situation(np.random.default_rng(11))


def angles(one, other):
    return np.linalg.norm(quat.log(one, other), axis=-1)


def test_it_goes_from_frame_to_frame_in_place_and_in_orientation(model, asked):
    path = model.generate(asked)
    np.testing.assert_allclose(path.positions[[0, -1]], [asked[0].b, asked[1].b], atol=0.06)
    wanted = quat.of_matrices(np.stack([frame.A for frame in asked]), "frames")
    assert (angles(path.orientations[[0, -1]], wanted) < 0.15).all()
    assert ((path.orientations[1:] * path.orientations[:-1]).sum(axis=1) > 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(path.orientations, axis=1), 1.0)


def test_it_needs_some_demonstrations_and_is_misled_by_chance_covariances(demonstrations, model):
    """The figures of the page: orientations at both ends of a reach in new situations [rad]."""
    asked = [reaching_situation(np.random.default_rng(seed)) for seed in range(11, 17)]

    def error(learned):
        found = []
        for frames in asked:
            wanted = quat.of_matrices(np.stack([frame.A for frame in frames]), "frames")
            found.append(angles(learned.generate(frames).orientations[[0, -1]], wanted))
        return np.mean(found)

    coupled = TimePoseTPGMM(3, samples=40, coupled=True).fit(demonstrations)
    few = TimePoseTPGMM(3, samples=40).fit(demonstrations[:3])
    assert error(model) == pytest.approx(0.03, abs=0.01)
    assert error(coupled) == pytest.approx(0.13, abs=0.03)
    assert error(few) > 0.5


def test_frames_moved_move_the_answer(model, asked):
    here, there = model.generate(asked), model.generate(moved_frames(asked, TURN, SHIFT))
    np.testing.assert_allclose(there.positions, here.positions @ TURN.T + SHIFT, atol=1e-7)
    turned = quat.multiply(quat.of_matrices(TURN, "it"), here.orientations)
    assert angles(there.orientations, turned).max() < 1e-7


def test_a_whole_scene_moved_before_learning_moves_the_answer(model, demonstrations, asked):
    turn = quat.of_matrices(TURN, "it")
    there = [
        PoseDemonstration(
            one.positions @ TURN.T + SHIFT,
            one.dt,
            moved_frames(one.frames, TURN, SHIFT),
            quat.multiply(turn, one.orientations),
        )
        for one in demonstrations
    ]
    other = TimePoseTPGMM(3, samples=40).fit(there).generate(moved_frames(asked, TURN, SHIFT))
    here = model.generate(asked)
    np.testing.assert_allclose(other.positions, here.positions @ TURN.T + SHIFT, atol=1e-5)
    assert angles(other.orientations, quat.multiply(turn, here.orientations)).max() < 1e-5


def test_signs_of_demonstrated_quaternions_change_nothing(model, demonstrations, asked, rng):
    flipped = [
        PoseDemonstration(
            one.positions,
            one.dt,
            one.frames,
            one.orientations * rng.choice([-1.0, 1.0], (len(one.orientations), 1)),
        )
        for one in demonstrations
    ]
    other = TimePoseTPGMM(3, samples=40).fit(flipped).generate(asked)
    here = model.generate(asked)
    np.testing.assert_allclose(other.positions, here.positions, atol=1e-9)
    np.testing.assert_allclose(other.orientations, here.orientations, atol=1e-9)


def test_a_constant_rotation_is_reproduced_exactly():
    rng = np.random.default_rng(5)
    held = Rotation.from_euler("xyz", [0.2, 1.3, -2.0]).as_quat()
    frames = [(Frame(np.eye(3), rng.normal(size=3)), Frame(np.eye(3), rng.normal(size=3) + 2))]
    frames.append(tuple(Frame(one.A, one.b + 0.3) for one in frames[0]))
    shown = [
        PoseDemonstration(path.positions, path.dt, path.frames, np.tile(held, (120, 1)))
        for path in (reaching(situation, rng) for situation in frames)
    ]
    path = TimePoseTPGMM(3, samples=40).fit(shown).generate(frames[1])
    assert angles(path.orientations, held).max() < 1e-9


def test_the_unit_of_length_does_not_matter(model, demonstrations, asked):
    there = [
        PoseDemonstration(
            1e3 * one.positions,
            one.dt,
            tuple(Frame(frame.A, 1e3 * frame.b) for frame in one.frames),
            one.orientations,
        )
        for one in demonstrations
    ]
    frames = tuple(Frame(frame.A, 1e3 * frame.b) for frame in asked)
    other, here = TimePoseTPGMM(3, samples=40).fit(there).generate(frames), model.generate(asked)
    np.testing.assert_allclose(other.positions, 1e3 * here.positions, atol=1e-3)
    assert angles(other.orientations, here.orientations).max() < 1e-6


def test_a_given_start_is_met_and_forgotten(model, asked):
    start = np.concatenate([[0.1, 0.2, 0.3], Rotation.from_euler("z", 1.0).as_quat()])
    free, led = model.generate(asked), model.generate(asked, start)
    np.testing.assert_allclose(led.positions[0], start[:3], atol=1e-12)
    assert angles(led.orientations[0], start[3:]) < 1e-9
    np.testing.assert_allclose(led.positions[10:], free.positions[10:], atol=1e-12)


def test_it_is_less_sure_of_an_orientation_that_varied_more(demonstrations, model):
    rng = np.random.default_rng(0)
    loose = [
        PoseDemonstration(
            one.positions,
            one.dt,
            one.frames,
            quat.exp(one.orientations, np.tile(rng.normal(0.0, 0.3, 3), (60, 1))),
        )
        for one in demonstrations
    ]
    # At the beginning, seen from the start: what another frame knows is not in there.
    wide = TimePoseTPGMM(3, samples=40).fit(loose).mixture.over_time(np.zeros(1))
    narrow = model.mixture.over_time(np.zeros(1))
    traces = [np.trace(one.covariances[0, 0, 3:, 3:]) for one in (narrow, wide)]
    assert traces[1] > 2 * traces[0]


def test_expectation_maximisation_raises_the_likelihood(model):
    record = model.record
    assert record.log_likelihoods[-1] > record.log_likelihoods[0]


def test_what_cannot_be_learned_from_is_refused(demonstrations, asked):
    one = demonstrations[0]
    with pytest.raises(InvalidInputError, match="fit"):
        TimePoseTPGMM().generate(asked)
    with pytest.raises(InvalidInputError, match="demonstration 0 has no orientations"):
        TimePoseTPGMM().fit([SyntheticDemonstration(one.positions, one.dt, one.frames)])
    with pytest.raises(InvalidInputError, match=r"shape \(59, 4\), valid is one a position"):
        TimePoseTPGMM().fit(
            [PoseDemonstration(one.positions, one.dt, one.frames, one.orientations[1:])]
        )
    with pytest.raises(InvalidInputError, match="1 frames, valid is as many as learned from: 2"):
        TimePoseTPGMM(2, samples=20).fit(demonstrations).generate(asked[:1])
    with pytest.raises(InvalidInputError, match="angle_floor"):
        TimePoseTPGMM(angle_floor=0.0)
