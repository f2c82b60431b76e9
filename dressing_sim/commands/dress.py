"""``dressing-sim dress``: one arm, and a film of it."""

from __future__ import annotations

import json as json_format
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from dressing_sim.checks import shown
from dressing_sim.commands.filming import Filming
from dressing_sim.commands.options import check_seed, names, print_outcome
from dressing_sim.errors import InvalidInputError, PolicyError
from dressing_sim.files import check_output, is_file

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from dressing_sim.arm import Posture
    from dressing_sim.episode.config import EpisodeConfig
    from dressing_sim.episode.demonstration import Demonstration
    from dressing_sim.episode.recording import Recording
    from dressing_sim.learning import Policy
    from dressing_sim.pictures.video import Film, Shot

_NO_FILM = Filming()


def dress(
    posture: str,
    policy: str = "default",
    demonstrations: str = "case_a",
    seed: int = 0,
    garment: str | None = None,
    person: str | None = None,
    robot: str | None = None,
    compare: str | None = None,
    explain: Path | None = None,
    filming: tyro.conf.OmitArgPrefixes[Filming] = _NO_FILM,
    json: bool = False,
) -> None:
    """Dress one arm, and film it if wanted.

    For example: dressing-sim dress --posture bent40 --video bent40.mp4

    Or: dressing-sim dress --posture 70,30,40,50,female --policy expert

    Or: dressing-sim dress --posture bent40 --garment hospital-gown --person ada.toml

    Or: dressing-sim dress --posture bent40 --policy tp-gmm-rf --demonstrations case_b

    Or: dressing-sim dress --posture bent40 --policy expert --robot ur10

    Or: dressing-sim dress --posture bent65 --compare expert,tp-gmm --video both.mp4 --camera auto

    Or: dressing-sim dress --posture bent65 --policy tp-gmm-rf --explain learned.svg

    Args:
        posture: name of a posture in a suite, or FLEXION,ABDUCTION,ROTATION,ELBOW[,SIZE] in
            degrees.
        policy: a name as of ``dressing-sim evaluate --policies``, with ?name=value&... for its
            hyper-parameters, or a file that ``dressing-sim learn`` wrote; expert is the operator.
        demonstrations: what a policy given by its name learns from: a suite that is demonstrated
            first, or a file that ``dressing-sim demonstrate`` wrote.
        seed: of the operator's variability, and of the policy's own randomness.
        garment: what is put on, in demonstrations too: tshirt-m, tshirt-l, tshirt-xl, long-sleeve,
            tshirt-m-body, hospital-gown, or a TOML file with a tape measure's sizes.
        person: whose arm is dressed: male, female_small, child-ten, tall-man, or a TOML file
            with a height or a tape measure's sizes.
        robot: which robot dresses, in demonstrations too: panda, ur10, or a TOML file with its
            URDF and servos.
        compare: two policies A,B instead, filmed side by side.
        explain: picture to write of what the policy learned and of its answer for this arm: .svg
            or .png. Of one of the paper's: what each frame saw, its ellipsoids before and after
            their fusion, and what Algorithm 1 kept and discarded; of transport: the demonstrations
            carried to this arm, and how sure it is.
        filming: what is filmed, and how.
        json: print the outcome as JSON.
    """
    from dressing_sim.episode.record import record
    from dressing_sim.suites.people import as_person, load_person
    from dressing_sim.suites.robots import with_robot
    from dressing_sim.suites.suites import find_posture
    from dressing_sim.suites.wardrobe import world_with

    arm = find_posture(posture)
    check_seed(seed)
    if person is not None:
        if posture.count(",") == 4:
            raise InvalidInputError("--person and a SIZE after the angles exclude each other")
        (arm,) = as_person([arm], load_person(person))
    config = with_robot(world_with(garment), robot)
    policies = [policy] if compare is None else names(compare)
    if compare is not None and len(policies) != 2:
        raise InvalidInputError(f"compare is {compare!r:.80}, valid is two policies, A,B")
    if compare is not None and explain is not None:
        raise InvalidInputError("--compare and --explain exclude each other")
    given = (posture, *policies, demonstrations, garment, person, robot)
    inputs = [name for name in given if name]
    films = filming.films(inputs, len(policies))
    if explain is not None:
        from dressing_sim.explain.picture import check_picture

        check_picture(explain)
        check_output(explain, filming.force, inputs)
    shots, printed = [], []
    for number, one in enumerate(policies):
        film = films[number] if films else None
        try:
            source, learned = _source(one, demonstrations, seed, config, explain is not None)
            recording = record(source, arm, seed, config, None if film is None else film.expose)
        except PolicyError as error:
            raise PolicyError(f"policy {one!r} gave no answer: {error}") from error
        outcome = recording.outcome
        printed.append({"posture": arm.to_dict(), "policy": one, **outcome.to_dict()})
        if not json:
            print_outcome(arm.name if compare is None else f"{one}, {arm.name}", outcome)
        if explain is not None:
            check_output(explain, filming.force, inputs)  # it took long
            begin = recording.positions[0]
            written = _explained(explain, source, one, arm, begin, learned)
            print(written, file=sys.stderr if json else sys.stdout)
        if film is not None:
            shots.append(_shot(film, recording, f"{one} on {arm.name}", arm, config, learned))
    if json:
        print(json_format.dumps(printed[0] if compare is None else printed, indent=2))
    if shots:
        filming.write(shots, inputs, json)


def _shot(
    film: Film,
    recording: Recording,
    title: str,
    posture: Posture,
    config: EpisodeConfig,
    learned: Sequence[Demonstration],
) -> Shot:
    """An episode that was filmed, with what there is to tell of it."""
    from dressing_sim.pictures.story import Story
    from dressing_sim.pictures.video import Shot

    story = Story(
        title,
        recording.outcome,
        None if recording.trajectory is None else recording.trajectory.targets,
        tuple(demonstration.positions for demonstration in learned),
        config.thresholds,
    )
    return Shot(film, posture, config.world, story)


def _explained(
    file: Path,
    policy: Policy,
    name: str,
    arm: Posture,
    start: NDArray[np.float64],
    learned: Sequence[Demonstration],
) -> str:
    """Draw what a policy has learned, and say so."""
    from dressing_sim.explain.learned import explain
    from dressing_sim.explain.picture import write_explanation

    told = f", learned from {', '.join(one.posture.name for one in learned)}" if learned else ""
    explanation = explain(policy, name, arm, start, learned)
    write_explanation(file, explanation, f"{name} on {arm.name}{told}")
    return f"picture of what {name} learned written to {file}"


def _source(
    policy: str, demonstrations: str, seed: int, config: EpisodeConfig, explained: bool = False
) -> tuple[Policy, Sequence[Demonstration]]:
    """A fitted policy, and what it has learned from, if that is known.

    It is from a file, or by its name, as a row of a table learns in its first set. One that is to
    be `explained` is refused, if it cannot be, before anything takes long.
    """
    from dressing_sim.benchmark.records import Entry
    from dressing_sim.benchmark.run.plan import fitting_seed
    from dressing_sim.explain.learned import check_explained
    from dressing_sim.policies.files import load_policy
    from dressing_sim.policies.hosted import hosted_policy
    from dressing_sim.policies.registry import known_name, learns

    if is_file(policy):
        loaded = load_policy(policy)
        if explained:
            check_explained(loaded, policy)
        return loaded, ()
    name = known_name(policy)
    try:
        fresh = hosted_policy(name, fitting_seed(seed, Entry(name, demonstrations), 0))
    except InvalidInputError as error:
        unknown, _, valid = str(error).partition("; ")
        if not unknown.startswith("unknown policy"):
            raise
        raise InvalidInputError(
            f"policy {shown(policy, 400)}: no such file, and no policy's name; {valid}, or a file "
            "written by 'dressing-sim learn'"
        ) from error
    if explained:
        check_explained(fresh, name)
    if not learns(name):
        return fresh, ()
    recorded = _recorded(demonstrations, seed, config)
    return fresh.fit(recorded), recorded


def _recorded(demonstrations: str, seed: int, config: EpisodeConfig) -> Sequence[Demonstration]:
    """Demonstrations of a file, or on the postures of a suite."""
    import h5py

    from dressing_sim.benchmark.run.runner import record_demonstration
    from dressing_sim.episode.demonstration import load_demonstrations
    from dressing_sim.suites.suites import load_suite

    if is_file(demonstrations) and h5py.is_hdf5(demonstrations):
        return load_demonstrations(demonstrations)
    recorded = []
    for posture in load_suite(demonstrations):
        print(f"demonstrating on {posture.name}", file=sys.stderr)
        recorded.append(record_demonstration(seed, posture, 0, config))
    return recorded
