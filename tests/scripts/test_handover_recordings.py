"""The recordings of the handover are whole, and cut as their script says."""

import json

import numpy as np
import pytest
from handover_recordings import OUT, last_closing, upright

ENTRIES = json.loads(OUT.read_text(encoding="utf-8"))


def test_there_are_seven_of_each_phase_and_their_licence():
    found = [(one["phase"], one["recording"]) for one in ENTRIES]
    assert sorted(found) == [(p, f"demo_{n}") for p in ("reach", "take") for n in range(7)]
    assert "MIT License" in OUT.with_suffix(".LICENSE").read_text(encoding="utf-8")


@pytest.mark.parametrize("one", ENTRIES, ids=lambda one: f"{one['phase']}-{one['recording']}")
def test_a_recording_leads_from_the_one_frame_to_the_other(one):
    path = np.array(one["positions"])
    start, goal = one["frames"]
    axes, place = np.array(goal["A"]), np.array(goal["b"])
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-5)
    assert (axes[2, 2], start["b"], start["A"]) == (1.0, [*path[0]], np.eye(3).tolist())
    # The hand closes about the handle: 18 cm long, and seldom missed by the width of a hand.
    assert np.all(np.abs(axes.T @ (path[-1] - place)) < [0.07, 0.04, 0.05])
    assert one["dt"] == pytest.approx(0.1)
    # Nobody moves faster than an arm does; a gap in the recording would.
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() < 0.6 * one["dt"]


def test_a_hammer_that_is_tilted_keeps_its_heading():
    tilted = upright(np.array([[1.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.0, -0.8, 0.6]]))
    np.testing.assert_allclose(tilted, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)


def test_the_last_closing_is_that_after_which_nothing_opens():
    commands = np.array([-1, 1, 1, -1, -1, 1, 1, -1.0])
    assert (last_closing(commands, 8), last_closing(commands, 5)) == (5, 1)
