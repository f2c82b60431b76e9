"""Do the verdicts of a run hold? Some of its episodes again, with other settings of the simulation.

    python scripts/recheck_run.py results/full [--episodes 60] [--setting finest]

Draws episodes of a run, dresses with the policies as they were, under a setting of
``dressing-sim validate``, and prints how many verdicts are the same and which are not.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from dressing_sim.benchmark.analysis.failures import verdict
from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.benchmark.run.executors import Processes, completed
from dressing_sim.benchmark.run.lines import parse_episode
from dressing_sim.benchmark.run.runner import dress_job, learned_source
from dressing_sim.benchmark.run.store import load_run
from dressing_sim.benchmark.studies.convergence import agreement
from dressing_sim.benchmark.studies.convergence_trials import FINEST, settings
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.system import processors


def again(folder: Path, index: int, config: EpisodeConfig) -> EpisodeResult:
    """One episode of a run, with other settings."""
    run = load_run(folder)
    job = run.plan.jobs[index]
    return dress_job(learned_source(run, job), job, config)


def main() -> None:
    """Dress, compare and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=Path)
    parser.add_argument("--episodes", type=int, default=60)
    parser.add_argument("--setting", default=FINEST, choices=[s.name for s in settings()])
    parser.add_argument("--seed", type=int, default=0, help="which episodes are drawn")
    chosen = parser.parse_args()
    try:
        run = load_run(chosen.run)
    except InvalidInputError as error:
        parser.error(str(error))
    recorded = {line["index"]: parse_episode(run.plan, line).outcome for line in run.lines}
    drawn = np.random.default_rng(chosen.seed).permutation(sorted(recorded))[: chosen.episodes]
    config = next(s.config for s in settings(run.plan.config) if s.name == chosen.setting)
    same, dressed, void = 0, [0, 0], 0
    with Processes(processors()) as workers:
        calls = [(int(index), (chosen.run, int(index), config)) for index in drawn]
        for index, future in completed(workers, again, calls):
            here, there = recorded[index], future.result().outcome
            dressed = [dressed[0] + here.success, dressed[1] + there.success]
            void += there.invalid is not None
            agree = agreement(here, there)
            same += agree
            if not agree:
                print(f"episode {index}: {verdict(here)}, {chosen.setting}: {verdict(there)}")
    print(
        f"of {len(drawn)} verdicts {same} are the same; {dressed[0]} dressed in the run, "
        f"{dressed[1]} with setting {chosen.setting!r}, {void} void"
    )


if __name__ == "__main__":
    main()
