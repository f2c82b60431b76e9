"""The one shape of a study, and the one loop that carries it out.

A study is a class in a module of its own: its jobs, what one job does, a summary, a document. The
loop opens the folder, runs what is missing, keeps each result as soon as it is there, and writes
the report.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import (
    Any,
    ClassVar,
    Generic,
    Protocol,
    TypeAlias,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
)

from dressing_sim.benchmark.analysis.episodes import count
from dressing_sim.benchmark.records import Entry, EpisodeResult, Json, Outcome
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.report.write import write_report
from dressing_sim.benchmark.run.executors import WorkerDied, Workers, completed
from dressing_sim.benchmark.run.lines import episode_values, parse_episode, parse_outcome
from dressing_sim.benchmark.run.origin import Accept
from dressing_sim.benchmark.run.plan import Job, Plan
from dressing_sim.benchmark.run.progress import Progress, silent
from dressing_sim.benchmark.run.runner import (
    Work,
    job_result,
    learned_by,
    learned_source,
    learned_sources,
)
from dressing_sim.benchmark.run.store import OpenRun, RunFolder, open_run
from dressing_sim.benchmark.studies.preparing import compile_learning
from dressing_sim.config import to_plain
from dressing_sim.episode.rollout import Observer
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.provenance import versions


class HasIndex(Protocol):
    """Anything with a place in a run, from 0."""

    @property
    def index(self) -> int: ...


JobT = TypeVar("JobT", bound=HasIndex)
ResultT = TypeVar("ResultT")

#: A function of a module, and its arguments for each job.
Calls: TypeAlias = tuple[Callable[..., ResultT], Iterable[tuple[JobT, tuple[Any, ...]]]]

#: What ``summary.json`` holds.
Summary: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True)
class Study(ABC, Generic[JobT, ResultT]):
    """What is measured, and what is made of it.

    To add one, put a class in a module; a protocol names it in `study`, by a name of
    `dressing_sim.benchmark.studies.STUDIES` or as ``module:Class``.
    """

    #: What a job is called while the run goes on.
    stage = "episodes"

    #: The dataclass of a result, whose fields are what a line holds.
    result: ClassVar[type[Any]]

    @abstractmethod
    def jobs(self, plan: Plan) -> Sequence[JobT]:
        """All that is to be done, by index."""

    def more(self, plan: Plan, results: Sequence[ResultT]) -> Sequence[JobT]:
        """What is to be done besides, by index; nothing where results decide nothing.

        Args:
            plan: Of the run.
            results: Of all jobs so far, in the order of `jobs` and of what this has added.
        """
        return ()

    @abstractmethod
    def calls(
        self, folder: OpenRun, jobs: Sequence[JobT], workers: Workers, progress: Progress
    ) -> Calls[ResultT, JobT]:
        """What one job does: a function of a module, and its arguments for each of the jobs.

        What the jobs need beforehand, such as demonstrations, is done here.
        """

    @abstractmethod
    def summarise(self, folder: RunFolder, results: Sequence[ResultT]) -> dict[str, Any]:
        """What ``summary.json`` holds; the results are in the order of the jobs."""

    @abstractmethod
    def document(
        self, folder: RunFolder, results: Sequence[ResultT], summary: Summary, command: str
    ) -> Document:
        """The report."""

    def values(self, plan: Plan, result: ResultT) -> dict[str, Json]:
        """What the line of a result holds, its ``index`` first."""
        return line_of(result)

    def parse(self, plan: Plan, values: Mapping[str, Any]) -> ResultT:
        """The result of a line; an `InvalidInputError` if it is damaged."""
        parsed: ResultT = result_of(self.result, values)
        return parsed

    def lost(self, plan: Plan, job: JobT, why: str) -> ResultT:
        """The result of a job under which workers die; an error unless a study says otherwise."""
        raise DressingSimError(f"job {job.index}: {why}")

    def note(self, results: Sequence[ResultT]) -> str:
        """How the run goes, in a few words."""
        return ""

    def repeat(
        self, folder: RunFolder, job: Job, observer: Observer | None = None
    ) -> EpisodeResult:
        """Run a job of a run again, if it is an episode."""
        raise InvalidInputError(
            f"{folder.path}: its study {folder.plan.protocol.study!r} cannot be replayed; valid "
            "is a run of policies that dress"
        )


@dataclass(frozen=True)
class EpisodeStudy(Study[Job, EpisodeResult]):
    """A study whose jobs are the episodes of a protocol.

    Attributes:
        work: What workers are asked to do.
    """

    work: Work = field(default_factory=lambda: Work(prepare=compile_learning))

    def jobs(self, plan: Plan) -> Sequence[Job]:
        """All episodes of the protocol."""
        return plan.jobs

    def calls(
        self, folder: OpenRun, jobs: Sequence[Job], workers: Workers, progress: Progress
    ) -> Calls[EpisodeResult, Job]:
        """Demonstrate and learn; then each job dresses.

        Posture by posture: an arm's settled world is used by all rows, and a run that is cut short
        has compared them all on the same arms.
        """
        plan = folder.plan
        ordered = sorted(jobs, key=lambda job: job.index % len(plan.tested))
        sources = learned_sources(folder, ordered, workers, progress, self.work)
        return self.work.dress, (
            (job, (sources[learned_by(job)], job, plan.config)) for job in ordered
        )

    def values(self, plan: Plan, result: EpisodeResult) -> dict[str, Json]:
        """What the line of an episode holds."""
        return episode_values(plan, result)

    def parse(self, plan: Plan, values: Mapping[str, Any]) -> EpisodeResult:
        """The episode of a line."""
        return parse_episode(plan, values)

    def lost(self, plan: Plan, job: Job, why: str) -> EpisodeResult:
        """An episode that cannot be run is invalid."""
        return job_result(job, job.posture, {}, Outcome(False, invalid=why))

    def note(self, results: Sequence[EpisodeResult]) -> str:
        """The success rate so far, and how many episodes are void."""
        rate = count(results)
        dressed = f"{rate.n_success} of {rate.n} dressed ({rate.percent:.0f} %)" if rate.n else ""
        return ", ".join(filter(None, [dressed, f"{rate.n_void} void" if rate.n_void else ""]))

    def repeat(
        self, folder: RunFolder, job: Job, observer: Observer | None = None
    ) -> EpisodeResult:
        """Run an episode again, with a policy that learns again."""
        source = learned_source(folder, job, self.work)
        return self.work.dress(source, job, folder.plan.config, observer)


def line_of(result: Any) -> dict[str, Json]:
    """The fields of a dataclass as a line: an entry and an outcome as in the lines of episodes."""
    line: dict[str, Json] = {}
    for name, value in ((one.name, getattr(result, one.name)) for one in fields(result)):
        if isinstance(value, Entry):
            line |= {"policy": value.policy, "demonstrations": value.demonstrations}
        elif isinstance(value, Outcome):
            line |= value.to_dict()
        else:
            line[name] = list(map(to_plain, value)) if isinstance(value, tuple) else value
    return {**line, "versions": versions()}


def result_of(kind: type[ResultT], line: Mapping[str, Any]) -> ResultT:
    """The inverse of `line_of`."""
    try:
        values = {name: _value(name, hint, line) for name, hint in get_type_hints(kind).items()}
        return kind(**values)
    except (KeyError, TypeError) as error:
        raise InvalidInputError(f"not a {kind.__name__}: {line!r:.60} ({error!r})") from error


def _value(name: str, hint: Any, line: Mapping[str, Any]) -> Any:
    if hint is Entry:
        return Entry(line["policy"], line["demonstrations"])
    if hint is Outcome:
        return parse_outcome(line)
    if get_origin(hint) is tuple:
        inside = get_args(hint)[0]
        nested = isinstance(inside, type) and is_dataclass(inside)
        return tuple(inside(**one) if nested else one for one in line[name])
    return line[name]


@dataclass(frozen=True)
class Finished(Generic[ResultT]):
    """A study that was carried out: its results, its summary, and its report."""

    results: list[ResultT]
    summary: dict[str, Any]
    document: Document


def run_study(
    study: Study[JobT, ResultT],
    plan: Plan,
    workers: Workers,
    out: Path,
    *,
    resume: bool = False,
    accept_numerics: bool = False,
    accept_changes: bool = False,
    force: bool = False,
    progress: Progress = silent,
    command: str = "",
) -> Finished[ResultT]:
    """Carry a study out, from plan to report.

    Args:
        study: What is measured.
        plan: On what, and with which seeds.
        workers: Where jobs run; results do not depend on how many there are.
        out: Folder for the results; a finished run in it is replaced.
        resume: Continue the run in the folder, if there is one.
        accept_numerics: Continue it with other numerics too.
        accept_changes: Continue it with other code too; rows with episodes of both say so.
        force: Begin anew whatever the folder holds; only files of a run's names are replaced.
        progress: Told after each demonstration, policy and job.
        command: What was typed, for the report.

    Raises:
        InvalidInputError: The folder cannot be used, or a policy's path is not valid.
        DressingSimError: A demonstration failed, or a worker died twice.
    """
    accept = Accept(accept_numerics, accept_changes)
    with open_run(out, plan, resume, workers.numerics, accept, force) as folder:
        results = run_jobs(study, folder, workers, progress)
        summary = study.summarise(folder, results)
        for row in summary.get("rows", ()):
            if "policy" in row and folder.origin.mixed(row["policy"]):
                row["mixed_code"] = True
        summary["provenance"] = dict(folder.origin.provenance)
        document = study.document(folder, results, summary, command)
        write_report(out, document, summary)
    return Finished(results, summary, document)


def run_jobs(
    study: Study[JobT, ResultT], folder: OpenRun, workers: Workers, progress: Progress = silent
) -> list[ResultT]:
    """Do what is not yet on disk; one result a job is returned, in the order of the jobs."""
    jobs, results = list(study.jobs(folder.plan)), list[ResultT]()
    while len(results) < len(jobs):
        wanted = jobs[len(results) :]
        missing = [job for job in wanted if job.index not in folder.finished]
        _do(study, folder, missing, jobs, workers, progress)
        results += [study.parse(folder.plan, folder.line(job.index)) for job in wanted]
        jobs += study.more(folder.plan, results)
    folder.sort()
    return read_results(study, folder)


def _do(
    study: Study[JobT, ResultT],
    folder: OpenRun,
    missing: Sequence[JobT],
    known: Sequence[JobT],
    workers: Workers,
    progress: Progress,
) -> None:
    """Do the missing ones of all jobs that are known so far; the others are on disk."""
    plan = folder.plan
    function, calls = study.calls(folder, missing, workers, progress)
    done = [job.index for job in known if job.index in folder.finished]
    results = [study.parse(plan, folder.line(index)) for index in done]
    progress(study.stage, len(results), len(known), study.note(results))
    for job, future in completed(workers, function, calls):
        try:
            result = future.result()
        except WorkerDied as death:
            result = study.lost(plan, job, str(death))
        line = folder.append(study.values(plan, result))
        results.append(study.parse(plan, line))
        progress(study.stage, len(results), len(known), study.note(results))


def read_results(study: Study[JobT, ResultT], folder: RunFolder) -> list[ResultT]:
    """The results that are on disk, in the order of the jobs."""
    return [study.parse(folder.plan, line) for line in folder.lines]
