"""``dressing-sim dress``: one arm, and a film of it."""

from __future__ import annotations

import json as json_format
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from dressing_sim.checks import shown
from dressing_sim.commands.options import check_seed, new_film, print_outcome
from dressing_sim.errors import InvalidInputError, PolicyError
from dressing_sim.files import check_output, is_file

if TYPE_CHECKING:
    from collections.abc import Sequence

    from dressing_sim.episode.config import EpisodeConfig
    from dressing_sim.episode.demonstration import Demonstration
    from dressing_sim.learning import Policy


def dress(
    posture: str,
    policy: str = "expert",
    demonstrations: str = "case_a",
    seed: int = 0,
    garment: str | None = None,
    person: str | None = None,
    video: Path | None = None,
    camera: str = "front",
    fps: int = 25,
    width: int = 640,
    height: int = 480,
    force: bool = False,
    json: bool = False,
) -> None:
    """Dress one arm, and film it if wanted.

    For example: dressing-sim dress --posture bent40 --video bent40.mp4

    Or: dressing-sim dress --posture 70,30,40,50,female --policy case_a.npz

    Or: dressing-sim dress --posture bent40 --garment hospital-gown --person ada.toml

    Or: dressing-sim dress --posture bent40 --policy tp-gmm-rf --demonstrations case_b

    Args:
        posture: name of a posture in a suite, or FLEXION,ABDUCTION,ROTATION,ELBOW[,SIZE] in
            degrees.
        policy: a name as of ``dressing-sim evaluate --policies``, with ?name=value&... for its
            hyper-parameters, or a file that ``dressing-sim learn`` wrote.
        demonstrations: what a policy given by its name learns from: a suite that is demonstrated
            first, or a file that ``dressing-sim demonstrate`` wrote.
        seed: of the operator's variability, and of the policy's own randomness.
        garment: what is put on, in demonstrations too: tshirt-m, tshirt-l, tshirt-xl, long-sleeve,
            tshirt-m-body, hospital-gown, or a TOML file with a tape measure's sizes.
        person: whose arm is dressed: male, female_small, child-ten, tall-man, or a TOML file
            with a height or a tape measure's sizes.
        video: film to write: .mp4 or .gif.
        camera: front, close or above.
        fps: pictures a second.
        width: of a picture, in pixels; even for .mp4.
        height: of a picture, in pixels; even for .mp4.
        force: replace a film that is there already.
        json: print the outcome as JSON.
    """
    from dressing_sim.episode.record import record
    from dressing_sim.suites.people import as_person, load_person
    from dressing_sim.suites.suites import find_posture
    from dressing_sim.suites.wardrobe import world_with

    arm = find_posture(posture)
    check_seed(seed)
    if person is not None:
        (arm,) = as_person([arm], load_person(person))
    config = world_with(garment)
    inputs = [name for name in (posture, policy, demonstrations, garment, person) if name]
    film = new_film(video, camera, fps, width, height, force, inputs)
    try:
        source = _source(policy, demonstrations, seed, config)
        outcome = record(source, arm, seed, config, None if film is None else film.expose).outcome
    except PolicyError as error:
        raise PolicyError(f"policy {policy!r} gave no answer: {error}") from error
    if json:
        print(
            json_format.dumps(
                {"posture": arm.to_dict(), "policy": policy, **outcome.to_dict()}, indent=2
            )
        )
    else:
        print_outcome(arm.name, outcome)
    if film is not None and video is not None:
        check_output(video, force, inputs)  # it took long
        film.write(video, arm, config.world, camera, width, height)
        print(f"film written to {video}", file=sys.stderr if json else sys.stdout)


def _source(policy: str, demonstrations: str, seed: int, config: EpisodeConfig) -> Policy:
    """A fitted policy: from a file, or by its name, as row of a table learns in its first set."""
    from dressing_sim.benchmark.records import Entry
    from dressing_sim.benchmark.run.plan import fitting_seed
    from dressing_sim.policies.files import load_policy
    from dressing_sim.policies.hosted import hosted_policy
    from dressing_sim.policies.registry import known_name, learns

    if is_file(policy):
        return load_policy(policy)
    name = known_name(policy)
    try:
        fresh = hosted_policy(name, fitting_seed(seed, Entry(name, demonstrations), 0))
    except InvalidInputError as error:
        if not str(error).startswith("unknown policy"):
            raise
        raise InvalidInputError(
            f"policy {shown(policy, 400)}: no such file, and {error}, or a file written by "
            "'dressing-sim learn'"
        ) from error
    return fresh.fit(_recorded(demonstrations, seed, config)) if learns(name) else fresh


def _recorded(demonstrations: str, seed: int, config: EpisodeConfig) -> Sequence[Demonstration]:
    """Demonstrations of a file, or on the postures of a suite."""
    import h5py

    from dressing_sim.benchmark.run.runner import record_demonstration
    from dressing_sim.episode.demonstration import load_demonstrations
    from dressing_sim.suites.suites import demonstration_postures

    if is_file(demonstrations) and h5py.is_hdf5(demonstrations):
        return load_demonstrations(demonstrations)
    recorded = []
    for posture in demonstration_postures(demonstrations):
        print(f"demonstrating on {posture.name}", file=sys.stderr)
        recorded.append(record_demonstration(seed, posture, 0, config))
    return recorded
