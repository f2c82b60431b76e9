import io

from rich.console import Console

from dressing_sim.arm import Posture
from dressing_sim.benchmark.progress import progress_bar
from dressing_sim.benchmark.protocol import Entry
from dressing_sim.benchmark.runner import EpisodeResult
from dressing_sim.judge import Outcome

OUTCOMES = [Outcome(True), Outcome(False), Outcome(True), Outcome(False, void="broke down")]
RESULTS = [EpisodeResult(Entry("expert"), Posture("arm", 0, 0, 0, 0), 0, o) for o in OUTCOMES]


def test_the_bar_shows_each_stage_and_the_running_success_rate():
    console = Console(file=io.StringIO(), width=120, force_terminal=True, color_system=None)
    with progress_bar(console) as tell:
        tell("demonstrations", 0, 2, ())
        tell("demonstrations", 2, 2, ())
        for done in range(5):
            tell("episodes", done, 4, RESULTS[:done])
    lines = console.file.getvalue().splitlines()
    (demonstrations,) = [line for line in lines[-3:] if "demonstrations" in line]
    (episodes,) = [line for line in lines[-3:] if "episodes" in line]
    assert "2/2" in demonstrations
    assert "4/4" in episodes
    assert "2 of 3 dressed (67 %)" in episodes  # a void episode counts neither way
    assert "dressed" not in demonstrations
