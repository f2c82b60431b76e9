"""``dressing-sim verify``: whether a submitted result comes out again."""

from __future__ import annotations

import json as json_format
import sys
from pathlib import Path

import tyro


def verify(
    file: tyro.conf.Positional[Path],
    share: float = 0.1,
    seed: int | None = None,
    workers: int | None = None,
    trust: bool = False,
    json: bool = False,
) -> None:
    """Check a submitted result: its file against the rules, then some of its episodes by new runs.

    Demonstrations are recorded again, policies learn again, and a random tenth of the episodes, ten
    at least, must be the same to the bit. On another kind of processor verdicts must be the same
    and numbers within a millionth. Exit code 1 if one is not, or the demonstrations or a policy's
    class of inputs are others; 2 if the file breaks a rule.

    For example: dressing-sim verify mine.json

    Or: dressing-sim verify mine.json --share 1 --trust --json

    Args:
        file: what dressing-sim submit wrote.
        share: of the episodes that are run again, from 0 to 1.
        seed: with which they are drawn; one that nobody can foresee unless given.
        workers: processes, as many as processors unless given.
        trust: import policies that are not of this package, which runs other people's code with
            your rights.
        json: print what was found as JSON.
    """
    from rich.console import Console

    from dressing_sim.benchmark.run.executors import Processes
    from dressing_sim.benchmark.run.progress import show_progress
    from dressing_sim.benchmark.scoreboard.submission import read_submission
    from dressing_sim.benchmark.scoreboard.verification import verify as run_again
    from dressing_sim.commands.options import check_seed
    from dressing_sim.commands.studies import check_workers
    from dressing_sim.errors import one_line

    count = check_workers(workers)
    if seed is not None:
        check_seed(seed)
    submission = read_submission(file)
    with Processes(count) as crew, show_progress(Console(stderr=True)) as progress:
        found = run_again(submission, crew, share=share, seed=seed, trust=trust, progress=progress)
    print(json_format.dumps(found.to_dict(), indent=2) if json else one_line(found.told(), 1000))
    if not found.holds:
        told = [f"{name}: {line}" for name, one in found.differing.items() for line in one]
        for line in [*found.changed, *told]:
            print(f"  {one_line(line)}", file=sys.stderr)
        raise SystemExit(1)
