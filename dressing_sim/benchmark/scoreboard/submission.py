"""A result as one file that others can verify: docs/scoreboard.md has its form."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np

from dressing_sim.archives import read_by_others, read_strict_json, to_json
from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.run.agreement import compare
from dressing_sim.benchmark.run.folder import CONFIG, DEMONSTRATIONS, EPISODES, read_config
from dressing_sim.benchmark.run.runner import learned_from
from dressing_sim.benchmark.run.store import RunFolder, load_run
from dressing_sim.benchmark.scoreboard.rules import Statement, check_run, others_policies
from dressing_sim.benchmark.studies import find_study
from dressing_sim.benchmark.studies.study import read_results
from dressing_sim.benchmark.studies.success_summary import summary_rows
from dressing_sim.checks import of_kind, shown
from dressing_sim.config import from_plain, to_plain
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import write_file
from dressing_sim.numerics import numerics

FORMAT: Final = "dressing_sim submission"
VERSION: Final = 1

#: What a file holds, in this order.
_KEYS = (
    "format",
    "version",
    "submitted",
    "rows",
    "episodes_sha256",
    "demonstrations",
    "config",
    "episodes",
)

#: What a row says, of what a summary's does; a later version of the package may know more.
_ROW = (
    "policy",
    "demonstrations",
    "n_episodes",
    "n_success",
    "pc_success",
    "pc_success_ci95",
    "pc_success_ci95_sets",
    "failures",
    "n_void",
    "n_abstained",
    "inputs",
)


@dataclass(frozen=True, slots=True)
class Taught:
    """The demonstrations that a row learned from.

    Attributes:
        sha256: Of what they are, see `taught_digest`; not of a file.
        file: A file of somebody's own, in base64; empty where they are recorded again from seeds.
    """

    sha256: str
    file: str = ""


@dataclass(frozen=True, eq=False)
class Submission:
    """A submitted result that keeps the rules; whether it can be reproduced is another question.

    Attributes:
        statement: What its submitter says.
        rows: As in ``summary.json``, counted from the episodes here.
        demonstrations: By the name that rows use.
        config: Of the run, as in its folder.
        run: Config and episodes; demonstrations are not on disk, see `unpacked`.
    """

    statement: Statement
    rows: list[dict[str, Any]]
    demonstrations: Mapping[str, Taught]
    config: Mapping[str, Any]
    run: RunFolder

    @property
    def episodes_sha256(self) -> str:
        """Of the file of episodes."""
        return _digest(self.run)

    @contextmanager
    def unpacked(self) -> Iterator[RunFolder]:
        """A folder of the run for a while, in which built-in demonstrations are still missing."""
        with TemporaryDirectory() as made:
            folder = Path(made)
            (folder / DEMONSTRATIONS).mkdir()
            write_file(folder / CONFIG, json.dumps(self.config))
            write_file(folder / EPISODES, _episodes(self.run))
            run = load_run(folder)
            for name in run.plan.own:
                content = base64.b64decode(self.demonstrations[name].file, validate=True)
                write_file(run.own_file(name), content)
            yield run


def submit(folder: Path, statement: Statement) -> str:
    """The text of a file that submits the finished run in a folder.

    Raises:
        InvalidInputError: No run is there, or it does not keep the rules.
    """
    run = load_run(folder)
    if not others_policies(run.plan) and not statement.package:
        ours = run.origin.versions.get("dressing-sim", "")
        statement = replace(statement, package=f"dressing-sim=={ours}")
    try:
        check_run(run, statement)
    except InvalidInputError as error:
        raise InvalidInputError(f"{folder}: {error}") from error
    own = run.plan.own
    taught = {
        name: Taught(
            taught_digest(run, name),
            base64.b64encode(run.own_file(name).read_bytes()).decode() if name in own else "",
        )
        for name in run.plan.demonstrated
    }
    values = {
        "format": FORMAT,
        "version": VERSION,
        "submitted": to_plain(statement),
        "rows": counted_rows(run),
        "episodes_sha256": _digest(run),
        "demonstrations": {name: to_plain(one) for name, one in taught.items()},
        "config": read_config(folder),
    }
    # A line each, so that a reader sees the head, and a difference is one of a line.
    head = [f"{json.dumps(key)}: {to_json(value, key)}" for key, value in values.items()]
    lines = ",\n".join(to_json(line, "episodes") for line in run.lines)
    return "{\n" + ",\n".join(head) + ',\n"episodes": [\n' + lines + "\n]\n}\n"


def read_submission(path: Path) -> Submission:
    """A submitted result, once its file keeps the rules.

    Nothing that it names is imported or run.

    Raises:
        InvalidInputError: It cannot be read, contradicts itself, or breaks a rule.
    """
    values = read_strict_json(path)
    with read_by_others(path, FORMAT):
        return _parsed(values, path)


def _parsed(values: Any, path: Path) -> Submission:
    of_kind(values, dict, "it", "an object")
    kind, version = values.get("format"), values.get("version")
    if kind != FORMAT or type(version) is not int or version != VERSION:
        told = f"format {shown(kind)}, version {shown(version)}"
        raise InvalidInputError(f"{told}; valid is {FORMAT!r}, {VERSION}")
    if set(values) != set(_KEYS):
        raise InvalidInputError(f"keys {shown(sorted(values), 200)}; valid are {', '.join(_KEYS)}")
    statement = from_plain(Statement, values["submitted"])
    config, lines = values["config"], values["episodes"]
    of_kind(config, dict, "config", "that of a run")
    of_kind(lines, list, "episodes", "a list of lines of a run")
    if [line["index"] for line in lines] != list(range(len(lines))):
        raise InvalidInputError("episodes are not all there, or not in order; valid is 0, 1, ...")
    run = RunFolder(path, config, "".join(json.dumps(line) + "\n" for line in lines).encode())
    if values["episodes_sha256"] != _digest(run):
        raise InvalidInputError("episodes do not match episodes_sha256; they were changed")
    check_run(run, statement)
    rows = counted_rows(run)
    other = run.origin.other_numerics(numerics())
    found = compare({"rows": values["rows"]}, {"rows": rows}, other).beyond
    if found:
        raise InvalidInputError(f"rows are not what the episodes give: {found[0]}")
    taught = {name: from_plain(Taught, one) for name, one in values["demonstrations"].items()}
    files = {name for name, one in taught.items() if one.file}
    if set(taught) != set(run.plan.demonstrated) or files != set(run.plan.own):
        raise InvalidInputError("demonstrations are not those of config; valid is as in a run")
    return Submission(statement, rows, taught, config, run)


def counted_rows(run: RunFolder) -> list[dict[str, Any]]:
    """The rows of a run's summary, counted again from its episodes."""
    results = read_results(find_study("success"), run)
    rows = summary_rows(run.plan.protocol, EpisodeTable.of(results))
    kept = [{key: row[key] for key in _ROW if key in row} for row in rows]
    plain: list[dict[str, Any]] = json.loads(json.dumps(kept))
    return plain


def taught_digest(run: RunFolder, name: str) -> str:
    """SHA-256 of what can be learned from demonstrations of a run, by the name that rows use.

    Of each, set by set: its arrays, by name, as little-endian float64; its time step, its seed and
    its posture as JSON. Not of versions, so that other ones can give the same.
    """
    sets = 1 if name in run.plan.own else run.plan.protocol.demonstration_sets
    digest = hashlib.sha256()
    for one in (one for number in range(sets) for one in learned_from(run, name, number)):
        for kind, array in {"positions": one.positions, **one.optional}.items():
            digest.update(kind.encode() + np.ascontiguousarray(array, dtype="<f8").tobytes())
        digest.update(json.dumps([one.dt, one.seed, one.posture.to_dict()]).encode())
    return digest.hexdigest()


def _episodes(run: RunFolder) -> str:
    """What a finished run has in its file of episodes, to the byte."""
    return "".join(json.dumps(line) + "\n" for line in run.lines)


def _digest(run: RunFolder) -> str:
    return hashlib.sha256(_episodes(run).encode()).hexdigest()
