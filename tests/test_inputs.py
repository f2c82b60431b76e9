import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.errors import InvalidInputError
from dressing_sim.inputs import fit, inputs_of
from dressing_sim.learning import Frame, SyntheticDemonstration

LINE = np.linspace(0.0, 1.0, 12).reshape(4, 3)


class Pupil:
    def __init__(self, inputs=None):
        if inputs is not None:
            self.inputs = inputs

    def fit(self, demonstrations):
        self.learned = demonstrations
        return self


def test_without_a_word_a_policy_is_asked_with_frames():
    assert inputs_of(Pupil()) == "frames"
    assert inputs_of(Pupil("elbow")) == "elbow"


@pytest.mark.parametrize(
    ("inputs", "names"),
    [
        (None, ("shoulder", "wrist")),
        ("frames+force", ("shoulder", "wrist")),
        ("elbow", ("shoulder", "wrist", "elbow")),
    ],
)
def test_a_policy_learns_from_the_frames_of_its_class_and_nothing_else(
    inputs, names, demonstration
):
    pupil = Pupil(inputs)
    assert fit(pupil, [demonstration]) is pupil
    (seen,) = pupil.learned
    np.testing.assert_array_equal(seen.positions, demonstration.positions)
    assert seen.dt == demonstration.dt
    assert seen.frames == demonstration.posture.frames(*names)
    assert seen.frames.names == names
    assert not hasattr(seen, "posture")
    assert not hasattr(seen, "commands")


def test_of_class_posture_it_learns_from_the_whole_demonstration(demonstration):
    assert fit(Pupil("posture"), [demonstration]).learned == [demonstration]


def test_frames_that_are_not_there_are_an_error():
    posture = Posture("p", 70, 20, 30, 40)
    with_elbow = posture.frames("shoulder", "wrist", "elbow")
    whole = SyntheticDemonstration(LINE, 0.1, with_elbow)
    assert fit(Pupil("elbow"), [whole]).learned[0].frames == with_elbow
    assert fit(Pupil(), [whole]).learned[0].frames == posture.frames()
    two = SyntheticDemonstration(LINE, 0.1, posture.frames())
    with pytest.raises(InvalidInputError, match="asks for shoulder, wrist, elbow"):
        fit(Pupil("elbow"), [two])


def test_frames_without_names_are_those_of_the_paper():
    frames = Frame(np.eye(3), np.zeros(3)), Frame(np.eye(3), np.ones(3))
    plain = SyntheticDemonstration(LINE, 0.1, frames)
    assert fit(Pupil(), [plain]).learned[0].frames == frames
