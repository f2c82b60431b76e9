"""``dressing-sim replay``: an episode of a run again."""

from __future__ import annotations

import json as json_format
import sys
from pathlib import Path

import tyro

from dressing_sim.commands.filming import Filming
from dressing_sim.commands.options import names, print_outcome

_NO_FILM = Filming()


def replay(
    folder: tyro.conf.Positional[Path],
    episode: tyro.conf.Positional[int],
    filming: tyro.conf.OmitArgPrefixes[Filming] = _NO_FILM,
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
        filming: what is filmed, and how.
        json: print the outcome as JSON.
    """
    from dressing_sim.benchmark.run.folder import CONFIG, DEMONSTRATIONS, EPISODES
    from dressing_sim.benchmark.run.origin import Origin
    from dressing_sim.benchmark.run.replay import intended, replay_episode
    from dressing_sim.benchmark.run.store import load_run
    from dressing_sim.benchmark.studies import find_study
    from dressing_sim.numerics import numerics

    run = load_run(folder)
    run.line(episode)  # an episode that is not there is reported before a film is prepared
    inputs = [folder / CONFIG, folder / EPISODES, *(folder / DEMONSTRATIONS).glob("*")]
    films = filming.films(inputs)
    film = films[0] if films else None
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
    if film is not None:
        from dressing_sim.pictures.story import Story
        from dressing_sim.pictures.video import Shot

        title = f"{result.entry.policy} on {result.posture.name}"
        drawn = {"path", "demonstrations"} & set(names(filming.overlays))
        way, shown = intended(run, episode) if drawn else (None, ())
        story = Story(title, result.outcome, way, shown, again.config.thresholds)
        filming.write([Shot(film, again.posture, again.config.world, story)], inputs, json)
    if not agreement.holds:
        raise SystemExit(1)
