"""``dressing-sim replay``: an episode of a run again."""

from __future__ import annotations

import json as json_format
import sys
from pathlib import Path

import tyro

from dressing_sim.commands.options import new_film, print_outcome
from dressing_sim.files import check_output


def replay(
    folder: tyro.conf.Positional[Path],
    episode: tyro.conf.Positional[int],
    video: Path | None = None,
    camera: str = "front",
    fps: int = 25,
    width: int = 640,
    height: int = 480,
    force: bool = False,
    json: bool = False,
) -> None:
    """Run an episode of a run again, and check that every bit is the same.

    The policy learns again from the demonstrations in the folder. Exit code 1 if the outcome is not
    the recorded one, as with other versions of the packages. On another kind of processor than it
    was recorded on, verdicts must be the same and numbers within a millionth.

    For example: dressing-sim replay results/evaluate 7 --video seven.mp4

    Args:
        folder: what ``dressing-sim evaluate`` or ``dressing-sim thresholds`` left.
        episode: its index in episodes.jsonl.
        video: film to write: .mp4 or .gif.
        camera: front, close or above.
        fps: pictures a second.
        width: of a picture, in pixels; even for .mp4.
        height: of a picture, in pixels; even for .mp4.
        force: replace a film that is there already.
        json: print the outcome as JSON.
    """
    from dressing_sim.benchmark.run.folder import CONFIG, DEMONSTRATIONS, EPISODES
    from dressing_sim.benchmark.run.origin import Origin
    from dressing_sim.benchmark.run.replay import replay_episode
    from dressing_sim.benchmark.run.store import load_run
    from dressing_sim.benchmark.studies import find_study
    from dressing_sim.numerics import numerics

    run = load_run(folder)
    run.line(episode)  # an episode that is not there is reported before a film is prepared
    inputs = [folder / CONFIG, folder / EPISODES, *(folder / DEMONSTRATIONS).glob("*")]
    film = new_film(video, camera, fps, width, height, force, inputs)
    study = find_study(run.plan.protocol.study)
    again = replay_episode(study, run, episode, None if film is None else film.expose)
    result, agreement = again.result, again.agreement
    if json:
        values = {
            "policy": result.entry.policy,
            "demonstrations": result.entry.demonstrations,
            "posture": result.posture.to_dict(),
            **result.outcome.to_dict(),
            "identical": not agreement.differences,
            "differences": agreement.differences,
            "agrees": agreement.holds,
            "numerics": agreement.numerics,
        }
        print(json_format.dumps(values, indent=2))
    else:
        learned = "" if result.entry.demonstrations is None else f" ({result.entry.demonstrations})"
        print_outcome(f"{result.entry.policy}{learned}, {result.posture.name}", result.outcome)
        if agreement.holds:
            print(agreement.told())
    if not agreement.holds:
        reasons = [*run.origin.changed(Origin.here(run.plan, numerics())), *agreement.beyond]
        told = "\n  ".join(reasons)
        print(f"dressing-sim: not the recorded outcome:\n  {told}", file=sys.stderr)
    if film is not None and video is not None:
        check_output(video, force, inputs)  # it took long
        film.write(video, again.posture, again.config.world, camera, width, height)
        print(f"film written to {video}", file=sys.stderr if json else sys.stdout)
    if not agreement.holds:
        raise SystemExit(1)
