import copy
import pickle

import numpy as np
import pytest

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import BoundsSampler, Frame, Situation, SyntheticDemonstration

A, B, C = (Frame(np.eye(3), np.full(3, place)) for place in (0.0, 1.0, 2.0))
NAMED = Situation(shoulder=A, wrist=B)


def test_frames_are_had_by_name_and_by_place():
    assert NAMED.shoulder is NAMED["shoulder"] is NAMED[0] is A
    assert NAMED.wrist is NAMED["wrist"] is NAMED[-1] is B
    assert NAMED[:1] == (A,)
    assert (list(NAMED), len(NAMED), NAMED.names) == ([A, B], 2, ("shoulder", "wrist"))


def test_a_third_frame_is_data():
    three = Situation(shoulder=A, wrist=B, head=C)
    assert three.head is three[2] is C


def test_it_is_equal_to_the_tuple_of_its_frames():
    assert NAMED == (A, B) == Situation(A, B)
    assert hash(NAMED) == hash((A, B))
    assert NAMED != (B, A)
    assert Situation(A, B).names == ()


@pytest.mark.parametrize(
    "same", [copy.copy, copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s)), Situation.of]
)
@pytest.mark.parametrize("situation", [NAMED, Situation(A, B), Situation()])
def test_a_copy_keeps_frames_and_names(situation, same):
    assert same(situation) == situation
    assert same(situation).names == situation.names
    assert type(same(situation)) is Situation


def test_any_sequence_of_frames_becomes_a_situation():
    assert Situation.of([A, B]) == (A, B)
    assert Situation.of([A, B], ("goal", "start")).start is B
    assert Situation.of(NAMED, ("goal", "start")).names == ("goal", "start")


def test_it_cannot_be_changed():
    with pytest.raises(AttributeError, match="cannot be changed"):
        NAMED.shoulder = B
    with pytest.raises(AttributeError, match="cannot be changed"):
        del NAMED.shoulder
    with pytest.raises(TypeError):
        NAMED[0] = B
    assert NAMED.shoulder is A


def test_a_frame_that_is_not_there_is_an_error_that_says_which_are():
    with pytest.raises(AttributeError, match="'elbow'; valid is shoulder, wrist"):
        NAMED.elbow  # noqa: B018
    with pytest.raises(KeyError, match="'elbow'; valid is shoulder, wrist"):
        NAMED["elbow"]
    with pytest.raises(AttributeError, match="have no names"):
        Situation(A).shoulder  # noqa: B018
    assert not hasattr(NAMED, "elbow")


@pytest.mark.parametrize(
    ("frames", "named", "part"),
    [
        ((A,), {"wrist": B}, "for all of its frames or for none"),
        ((1.0,), {}, "not 1.0"),
        ((), {"count": A}, "'count'"),
        ((), {"names": A}, "'names'"),
    ],
)
def test_what_is_no_situation_is_an_error(frames, named, part):
    with pytest.raises(InvalidInputError, match=part):
        Situation(*frames, **named)


def test_it_says_what_it_holds():
    assert repr(NAMED).startswith("Situation(shoulder=Frame(")
    assert "wrist=Frame(" in repr(NAMED)


def test_random_situations_have_the_demonstrated_names():
    path = np.cumsum(np.ones((4, 3)), axis=0)
    shown = [SyntheticDemonstration(path, 0.1, NAMED), SyntheticDemonstration(path, 0.1, NAMED)]
    drawn = BoundsSampler.around(shown).sample(np.random.default_rng(0))
    assert drawn.names == ("shoulder", "wrist")
    plain = [SyntheticDemonstration(path, 0.1, (A, B))]
    assert BoundsSampler.around(plain).sample(np.random.default_rng(0)).names == ()
