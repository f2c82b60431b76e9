"""``dressing-sim dress``: one arm, and a film of it."""

from __future__ import annotations

import json as json_format
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from dressing_sim.commands.options import check_seed, new_film, print_outcome
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import is_file

if TYPE_CHECKING:
    from dressing_sim.episode.record import PathSource


def dress(
    posture: str,
    policy: str = "expert",
    seed: int = 0,
    video: Path | None = None,
    camera: str = "front",
    fps: int = 25,
    width: int = 640,
    height: int = 480,
    json: bool = False,
) -> None:
    """Dress one arm, and film it if wanted.

    For example: dressing-sim dress --posture bent40 --video bent40.mp4

    Or: dressing-sim dress --posture 70,30,40,50,female --policy case_a.npz

    Args:
        posture: name of a posture in a suite, or FLEXION,ABDUCTION,ROTATION,ELBOW[,SIZE] in
            degrees.
        policy: expert, or a file that ``dressing-sim learn`` wrote.
        seed: of the operator's variability.
        video: film to write: .mp4 or .gif.
        camera: front, close or above.
        fps: pictures a second.
        width: of a picture, in pixels; even for .mp4.
        height: of a picture, in pixels; even for .mp4.
        json: print the outcome as JSON.
    """
    from dressing_sim.episode.config import EpisodeConfig
    from dressing_sim.episode.record import record
    from dressing_sim.suites.suites import find_posture

    arm = find_posture(posture)
    check_seed(seed)
    config = EpisodeConfig()
    film = new_film(video, camera, fps, width, height)
    source = _source(policy)
    outcome = record(source, arm, seed, config, None if film is None else film.expose).outcome
    if json:
        print(
            json_format.dumps(
                {"posture": arm.to_dict(), "policy": policy, **outcome.to_dict()}, indent=2
            )
        )
    else:
        print_outcome(arm.name, outcome)
    if film is not None and video is not None:
        film.write(video, arm, config.world, camera, width, height)
        print(f"film written to {video}", file=sys.stderr if json else sys.stdout)


def _source(policy: str) -> PathSource:
    from dressing_sim.episode.operator import Operator
    from dressing_sim.learning import Policy
    from dressing_sim.learning.storage import load_model
    from dressing_sim.policies.registry import EXPERT

    if policy == EXPERT:
        return Operator()
    if not is_file(policy):
        raise InvalidInputError(
            f"policy {policy!r}: no such file; valid is {EXPERT} or a file written by "
            "'dressing-sim learn'"
        )
    fitted = load_model(policy)
    if not isinstance(fitted, Policy):
        raise InvalidInputError(f"policy {policy}: holds a model that cannot generate a path")
    return fitted
