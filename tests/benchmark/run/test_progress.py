import io

import pytest
from rich.console import Console

from dressing_sim.benchmark.run.progress import INTERVAL, show_progress

NOTES = ("", "1 of 1 dressed (100 %)", "1 of 2 dressed (50 %)", "2 of 3 dressed (67 %)")
NOTES += ("2 of 3 dressed (67 %), 1 void",)


def test_the_bar_shows_each_stage_and_how_it_goes():
    console = Console(file=io.StringIO(), width=140, force_terminal=True, color_system=None)
    with show_progress(console) as tell:
        tell("demonstrations", 0, 2, "")
        tell("demonstrations", 2, 2, "")
        for done in range(5):
            tell("episodes", done, 4, NOTES[done])
    lines = console.file.getvalue().splitlines()
    (demonstrations,) = [line for line in lines[-3:] if "demonstrations" in line]
    (episodes,) = [line for line in lines[-3:] if "episodes" in line]
    assert "2/2" in demonstrations
    assert "4/4" in episodes
    assert "2 of 3 dressed (67 %), 1 void" in episodes
    assert "dressed" not in demonstrations


@pytest.fixture
def plain():
    """A console that is no terminal, and a clock that is set by hand."""
    return Console(file=io.StringIO(), width=40, force_terminal=False), [100.0]


def told(console):
    return console.file.getvalue().splitlines()


def test_without_a_terminal_a_stage_begins_and_ends_with_a_plain_line(plain):
    console, time = plain
    with show_progress(console, lambda: time[0]) as tell:
        for done in range(5):
            tell("episodes", done, 4, NOTES[done])
    assert told(console) == ["episodes: 0 of 4", "episodes: 4 of 4, 2 of 3 dressed (67 %), 1 void"]


def test_without_a_terminal_there_is_a_line_now_and_then_with_the_time_left(plain):
    console, time = plain
    with show_progress(console, lambda: time[0]) as tell:
        tell("episodes", 1, 401, NOTES[1])  # one was there from before
        for done in range(2, 102):
            time[0] += 1.0
            tell("episodes", done, 401, NOTES[1])
    first, *later = told(console)
    assert first == "episodes: 1 of 401, 1 of 1 dressed (100 %)"
    assert len(later) == 100 // INTERVAL
    assert later[0] == "episodes: 31 of 401, 1 of 1 dressed (100 %), 0:06:10 left"


def test_an_early_error_leaves_nothing_on_the_console(plain):
    console, _ = plain
    with pytest.raises(ValueError, match="early"), show_progress(console):
        raise ValueError("early")
    assert told(console) == []
