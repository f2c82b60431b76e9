"""Evaluation from Python: the same numbers as ``dressing-sim evaluate``, as typed values."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import MISSING, asdict, dataclass, fields, replace
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from tempfile import TemporaryDirectory
from types import NoneType
from typing import TYPE_CHECKING, Any

from dressing_sim.benchmark.records import EpisodeResult, Protocol
from dressing_sim.benchmark.run.executors import Processes
from dressing_sim.benchmark.run.plan import Plan, dressing_person, make_plan
from dressing_sim.benchmark.run.progress import Progress, silent
from dressing_sim.benchmark.studies import find_study
from dressing_sim.benchmark.studies.protocols import find_protocol
from dressing_sim.benchmark.studies.study import EpisodeStudy, Study, run_study
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.benchmark.studies.success_films import MOST_FILMS
from dressing_sim.checks import listed, of_kind, shown, truth_value, whole_number
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.variation import factor_names
from dressing_sim.errors import InvalidInputError
from dressing_sim.pictures.rendering import gl_backend
from dressing_sim.policies.host import PolicyLimits
from dressing_sim.suites.robots import with_robot
from dressing_sim.suites.suites import suite_names
from dressing_sim.suites.wardrobe import world_with
from dressing_sim.system import check_may_start_processes, processors
from dressing_sim.world.robot import PANDA

if TYPE_CHECKING:
    import pandas

    from dressing_sim.learning import Policy


@dataclass(frozen=True, slots=True)
class EvaluationRow:
    """One row of the table.

    Attributes:
        policy: Name of the policy.
        demonstrations: Suite of the postures it learned from; None for the expert.
        variation: What was drawn anew for each episode, or fixed.
        n_episodes: Episodes that count.
        n_success: Those in which the arm was dressed.
        pc_success: Success rate [%]; None where no episode counts.
        pc_success_ci95: Its 95 % Wilson interval [%].
        failures: Episodes by what went wrong in them.
        n_void: Invalid episodes, which count neither way.
        n_abstained: Episodes that the policy did not try, which count as no success.
        robot: Name of the robot that dressed.
    """

    policy: str
    demonstrations: str | None
    variation: tuple[str, ...]
    n_episodes: int
    n_success: int
    pc_success: float | None
    pc_success_ci95: tuple[float, float]
    failures: Mapping[str, int]
    n_void: int
    n_abstained: int = 0
    robot: str = PANDA.name

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> EvaluationRow:
        """A row of ``summary.json``."""
        values: dict[str, Any] = {
            one.name: row[one.name]
            for one in fields(cls)
            if one.name in row or one.default is MISSING  # only what is unusual is told
        }
        lists = {name: tuple(value) for name, value in values.items() if isinstance(value, list)}
        return cls(**{**values, **lists})


@dataclass(frozen=True)
class Evaluation:
    """What became of an evaluation.

    Attributes:
        rows: The table, a row for each policy and what it learned from.
        episodes: Every episode, in the order of the rows and, within each, of the test postures.
        summary: What ``summary.json`` holds, comparisons and the paper's claims included.
    """

    rows: tuple[EvaluationRow, ...]
    episodes: tuple[EpisodeResult, ...]
    summary: Mapping[str, Any]

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a data frame, a line a row.

        Raises:
            InvalidInputError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise InvalidInputError("pandas is not installed: pip install pandas") from error
        return pandas.DataFrame([asdict(row) for row in self.rows])


def evaluate(
    policies: Sequence[str | type[Policy]] | str | None = None,
    *,
    protocol: str = "paper",
    suite: str | None = None,
    variation: Sequence[str] | None = None,
    seed: int = 0,
    workers: int | None = None,
    demonstrations: str | Path | None = None,
    garment: str | None = None,
    person: str | None = None,
    robot: str | None = None,
    policy_limits: PolicyLimits | None = None,
    out: str | Path | None = None,
    resume: bool = False,
    force: bool = False,
    pictures: bool = False,
    films: int = 0,
    progress: Progress = silent,
) -> Evaluation:
    """Measure how often policies dress an arm in a posture that they did not learn from.

    In a script, call it under ``if __name__ == "__main__":``, as it starts processes.

    Args:
        policies: Names as on the command line, in a list or separated by commas, or classes; those
            of the protocol if None.
        protocol: Which policies learn from which demonstrations, such as ``paper``.
        suite: Test postures instead of the protocol's: a name, a JSON file, or ``random:N``.
        variation: Factors drawn anew for each episode, or fixed.
        seed: Of the operator's variability, of the policies' own randomness, and of variation.
        workers: Processes, as many as processors if None; the results do not depend on it.
        demonstrations: What every policy learns from instead of the protocol's: suites, such as
            ``case_a`` or ``case_a?speed=0.16,baseline7:3``, or a file of demonstrations.
        garment: What is put on, in demonstrations too: a name or a TOML file, see
            `dressing_sim.suites.wardrobe.load_garment`.
        person: Whose arm the test postures have: a name or a TOML file, see
            `dressing_sim.suites.people.load_person`.
        robot: Which dresses, in demonstrations too: a name or a TOML file, see
            `dressing_sim.suites.robots.load_robot`.
        policy_limits: Time and memory that other people's policies may use.
        out: Folder for the results; a temporary one if None.
        resume: Continue the run in the folder, if there is one.
        force: Begin anew whatever the folder holds; only files of a run's names are replaced.
        pictures: Draw the hardest postures in the report.
        films: Film so many typical failures of each row in the report; needs OpenGL.
        progress: Told after each demonstration, policy and episode.

    Raises:
        InvalidInputError: An argument is not valid, or the protocol measures no episodes.
        DressingSimError: A demonstration failed, or there is no OpenGL to film with.
    """
    check_may_start_processes()
    of_kind(out, (str, Path, NoneType), "out", "a folder or None")
    truth_value(resume, "resume")
    truth_value(pictures, "pictures")
    of_kind(demonstrations, (str, Path, NoneType), "demonstrations", "suites, a file or None")
    of_kind(policy_limits, (PolicyLimits, NoneType), "policy_limits", "PolicyLimits or None")
    plan = evaluation_plan(
        protocol,
        suite,
        policies,
        variation,
        seed,
        demonstrations,
        policy_limits,
        garment,
        person,
        robot,
    )
    study = evaluation_study(plan, pictures, films)
    if not isinstance(study, EpisodeStudy):
        raise InvalidInputError(f"protocol {protocol!r} dresses nobody; valid is one that does")
    count = processors() if workers is None else workers
    whole_number(count, "workers", 1, 1024)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(TemporaryDirectory()) if out is None else out)
        crew = stack.enter_context(Processes(count))
        command = f"dressing_sim.evaluate({policies!r}, {protocol=}, {suite=}, {seed=})"
        options = {"resume": resume, "force": force}
        finished = run_study(
            study, plan, crew, folder, progress=progress, command=command, **options
        )
    rows = tuple(map(EvaluationRow.of, finished.summary["rows"]))
    return Evaluation(rows, tuple(finished.results), finished.summary)


def evaluation_plan(
    protocol: str,
    suite: str | None,
    policies: Sequence[str | type[Policy]] | str | None,
    variation: Sequence[str] | None,
    seed: int,
    demonstrations: str | Path | None = None,
    policy_limits: PolicyLimits | None = None,
    garment: str | None = None,
    person: str | None = None,
    robot: str | None = None,
) -> Plan:
    """The plan of a protocol, with other postures, policies, arms, clothes or robot if wanted.

    Raises:
        InvalidInputError: There is no such protocol, suite, policy, factor, garment, person or
            robot, or what is given is varied as well.
    """
    of_kind(protocol, str, "protocol", "a name")
    chosen = find_protocol(protocol)
    if chosen.study == "cost" and any(
        given is not None for given in (suite, policies, variation, garment, person, robot)
    ):
        raise InvalidInputError(
            f"protocol {protocol!r} dresses nobody: --suite, --policies, --variation, --garment, "
            "--person, --robot do not apply"
        )
    if policies is not None:
        names = policies.split(",") if isinstance(policies, str) else policies
        found = listed(names, "policies", "names or classes in a list, or separated by commas")
        chosen = chosen.with_policies([policy_name(policy) for policy in found])
    if variation is not None:
        factors = listed(variation, "variation", "names of factors in a list")
        for factor in factors:
            of_kind(factor, str, "a factor of variation", "a name")
        chosen = chosen.with_variation(factors)
    if suite is not None:
        of_kind(suite, str, "suite", "a name, a JSON file, or random:N")
        chosen = replace(chosen, suite=suite)
    whole_number(seed, "seed", 0, 2**63 - 1)
    suites = suites_in(demonstrations)
    if suites:
        chosen = chosen.with_suites(suites)
    file = None if demonstrations is None or suites else Path(demonstrations)
    config = _world(chosen, garment, person, robot)
    plan = make_plan(chosen, seed, config, policy_limits=policy_limits, demonstrations=file)
    return dressing_person(plan, person)


def _world(
    protocol: Protocol, garment: str | None, person: str | None, robot: str | None
) -> EpisodeConfig:
    """The world with a garment and a robot, once neither garment nor arm is varied as well."""
    of_kind(robot, (str, NoneType), "robot", "a name, a TOML file or None")
    for name, given, factor in (("garment", garment, "garment"), ("person", person, "arm")):
        of_kind(given, (str, NoneType), name, "a name, a TOML file or None")
        if given is not None and any(
            factor in factor_names(entry.variation) for entry in protocol.entries
        ):
            raise InvalidInputError(
                f"{name} is {given!r}, but the {factor} is varied as well; valid is one of them"
            )
    return with_robot(world_with(garment), robot)


def suites_in(demonstrations: str | Path | None) -> list[str]:
    """The suites that are meant, ``NAME`` or ``NAME:n`` each; none if it is a file.

    After a ``?`` may stand the operator's style, see `dressing_sim.policies.expert.operator_of`.

    Raises:
        InvalidInputError: It is neither.
    """
    if not isinstance(demonstrations, str):
        return []
    names = demonstrations.split(",")
    if all(re.split("[:?]", name)[0] in suite_names() for name in names):
        return names
    if not os.path.exists(demonstrations):
        raise InvalidInputError(
            f"{shown(demonstrations)}: no such file and no suite; valid is an HDF5 file of "
            f"demonstrations, or of {', '.join(suite_names())}"
        )
    return []


def evaluation_study(plan: Plan, pictures: bool, films: int = 0) -> Study[Any, Any]:
    """The study of a plan; with pictures if it can draw them, and films if they are wanted.

    Raises:
        InvalidInputError: There are no episodes to film.
        DressingSimError: There is no OpenGL to film with.
    """
    study = find_study(plan.protocol.study)
    whole_number(films, "films", 0, MOST_FILMS)
    if films and not isinstance(study, Success):
        raise InvalidInputError(
            f"films is {films}, valid is 0 with protocol {plan.protocol.name!r}, which does not "
            "tell how often an arm is dressed"
        )
    if films:
        gl_backend()  # without OpenGL, say so before simulating
    if isinstance(study, Success):
        return replace(study, pictures=pictures, films=films)
    return study


def policy_name(policy: str | type[Policy]) -> str:
    """The name that a policy goes by in a run: as given, or ``module:Class`` of a class.

    Raises:
        InvalidInputError: Other processes could not import the class.
    """
    if isinstance(policy, str):
        return policy.strip()
    of_kind(policy, type, "a policy", "a name or a class")
    module, place = policy.__module__, policy.__qualname__
    try:
        found = None if module == "__main__" else attrgetter(place)(import_module(module))
    except (ImportError, AttributeError):
        found = None
    if found is not policy:
        raise InvalidInputError(
            f"policy {module}:{place} cannot be imported by other processes; valid is a class at "
            "the top of a module"
        )
    return f"{module}:{place}"
