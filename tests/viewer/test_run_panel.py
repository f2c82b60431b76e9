"""The map of a run, and the colours of its postures."""

import re

from dressing_sim.benchmark.records import Entry, EpisodeResult
from dressing_sim.episode.outcome import Outcome
from dressing_sim.suites.suites import load_suite
from dressing_sim.viewer.run_panel import _rgb, failure_map

EPISODES = [
    EpisodeResult(number, Entry("tp-gmm", "case_a"), posture, 0, 0, {}, Outcome(True))
    for number, posture in enumerate(load_suite("paper5"))
]


def test_the_chosen_posture_has_a_ring_and_no_other():
    for chosen, rings in ((EPISODES[2].posture.name, 1), ("nobody", 0)):
        circles = re.findall(r"<circle[^>]*><title>[^:]*", failure_map(EPISODES, chosen))
        assert len(circles) == 5
        ringed = [circle for circle in circles if "stroke=" in circle]
        assert len(ringed) == rings
        assert all(circle.endswith(chosen) for circle in ringed)


def test_a_colour_as_light_is_darker_but_for_black_and_white():
    assert _rgb("#000000") == (0, 0, 0)
    assert _rgb("#ffffff") == (255, 255, 255)
    assert _rgb("#808080") == (55, 55, 55)
