"""The study of tuning: what paths policies draw on postures, by hyper-parameters, without physics.

    python -m dressing_sim.benchmark.studies.tuning --suite val50 --sets 3

Demonstrations are the operator's paths, which the gripper follows to a millimetre. A path is
compared with the operator's own, without its variability. This chooses hyper-parameters worth
simulating; it does not predict success rates.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from rich.console import Console

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import Entry, Json, Protocol
from dressing_sim.benchmark.report.document import (
    Document,
    Paragraph,
    Section,
    Table,
    config_section,
)
from dressing_sim.benchmark.report.terminal import print_document
from dressing_sim.benchmark.run.executors import Processes, Workers
from dressing_sim.benchmark.run.plan import Plan, make_plan
from dressing_sim.benchmark.run.progress import Progress, show_progress
from dressing_sim.benchmark.run.store import OpenRun, RunFolder
from dressing_sim.benchmark.studies.study import Study, run_study
from dressing_sim.benchmark.studies.tuning_paths import (
    PathMetrics,
    operator_demonstrations,
    path_metrics,
    steady_path,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.path import checked_path
from dressing_sim.policies.paper import POLICIES
from dressing_sim.policies.registry import make_policy
from dressing_sim.provenance import versions
from dressing_sim.system import processors

#: Which policies on which demonstrations: the paper's rows.
ROWS = (
    *(Entry(policy, case) for case in ("case_a", "case_b") for policy in POLICIES),
    Entry("tp-gmm", "baseline7"),
)

#: Hyper-parameters to compare, as they stand after a policy's name; nothing for those as chosen.
CHANGES = (
    "",
    "relative_floor=true&position_floor=0.1&displacement_floor=0.1",
    "relative_floor=true&position_floor=0.03&displacement_floor=0.03",
    "relative_floor=true&position_floor=0.01&displacement_floor=0.01",
    "position_floor=1e-3",
    "position_floor=1e-3&displacement_floor=1e-6",
    "displacement_floor=1e-6",
    "displacement_floor=1e-7",
    "samples=100",
    "samples=50",
    "free_axes=arm-plane",
    "situations=frames",
    "angle_margin_deg=0&translation_margin=0",
    "angle_margin_deg=20",
    "end_radius=0",
    "end_radius=0.1",
    "fusion=product-then-regression",
    "shrinkage=true",
)


@dataclass(frozen=True, slots=True)
class Screening:
    """A policy to be screened, and its paths' metrics once it is.

    Attributes:
        index: Its place: all demonstration sets of the first row, then of the next.
        entry: Row: the policy, perhaps with hyper-parameters, and its demonstrations.
        demonstration_set: Which set; each is demonstrated with another seed.
        paths: Metrics of its paths, one a posture; none before it is screened.
    """

    index: int
    entry: Entry
    demonstration_set: int
    paths: tuple[PathMetrics, ...] = ()


def screen(job: Screening, demonstrated: Sequence[Posture], tested: Sequence[Posture]) -> Screening:
    """Let a policy learn from the operator, and compare its paths with the operator's."""
    number = job.demonstration_set
    policy = make_policy(job.entry.policy, number).fit(
        operator_demonstrations(demonstrated, number)
    )
    paths = []
    for posture in tested:
        expert = steady_path(posture)
        path = checked_path(policy.generate(posture.frames(), expert[0]), job.entry.policy)
        paths.append(path_metrics(path.positions, expert, posture))
    return Screening(job.index, job.entry, number, tuple(paths))


def tuning_plan(
    suite: str = "val50", sets: int = 3, changes: Sequence[str] = CHANGES, seed: int = 0
) -> Plan:
    """The plan of the study: every row under every change."""
    marks = [f"?{change}" if change else "" for change in changes]
    entries = [Entry(f"{row.policy}{mark}", row.demonstrations) for mark in marks for row in ROWS]
    protocol = Protocol("tuning", suite, tuple(entries), demonstration_sets=sets, study="tuning")
    return make_plan(protocol, seed)


@dataclass(frozen=True)
class Tuning(Study[Screening, Screening]):
    """Per cent of a policy's paths that would dress, by hyper-parameters and row."""

    stage = "policies"

    def jobs(self, plan: Plan) -> Sequence[Screening]:
        """Each row with each demonstration set."""
        sets = plan.protocol.demonstration_sets
        return [
            Screening(row * sets + number, entry, number)
            for row, entry in enumerate(plan.protocol.entries)
            for number in range(sets)
        ]

    def calls(
        self, folder: OpenRun, jobs: Sequence[Screening], workers: Workers, progress: Progress
    ) -> tuple[Callable[..., Screening], Iterable[tuple[Screening, tuple[Any, ...]]]]:
        """Each job is a policy that learns and draws all its paths."""
        plan = folder.plan
        postures = {
            entry: plan.demonstrated[entry.demonstrations or ""] for entry in plan.protocol.entries
        }
        return screen, ((job, (job, postures[job.entry], plan.tested)) for job in jobs)

    def values(self, plan: Plan, result: Screening) -> dict[str, Json]:
        """What the line of a screened policy holds."""
        return {
            "index": result.index,
            "policy": result.entry.policy,
            "demonstrations": result.entry.demonstrations,
            "demonstration_set": result.demonstration_set,
            "paths": [asdict(path) for path in result.paths],
            "versions": versions(),
        }

    def parse(self, plan: Plan, values: Mapping[str, Any]) -> Screening:
        """The screened policy of a line."""
        try:
            job = self.jobs(plan)[values["index"]]
            paths = tuple(PathMetrics(**path) for path in values["paths"])
            return Screening(job.index, job.entry, job.demonstration_set, paths)
        except (KeyError, TypeError, IndexError) as error:
            raise InvalidInputError(f"not a screening: {values!r:.60} ({error!r})") from error

    def summarise(self, folder: RunFolder, results: Sequence[Screening]) -> dict[str, Any]:
        """Shares and means by row.

        Returns:
            ``{"rows": [{"policy", "demonstrations", "pc_dresses", "pc_ends", "means"}, ...],
            "versions", "config"}``, means of `PathMetrics` in metres.
        """
        protocol = folder.plan.protocol
        paths = {
            entry: [p for r in results if r.entry == entry for p in r.paths]
            for entry in protocol.entries
        }
        return {
            "rows": [
                {
                    "policy": entry.policy,
                    "demonstrations": entry.demonstrations,
                    "pc_dresses": 100.0 * float(np.mean([path.dresses for path in own])),
                    "pc_ends": 100.0 * float(np.mean([path.ends for path in own])),
                    "means": {
                        field.name: float(np.mean([getattr(path, field.name) for path in own]))
                        for field in fields(PathMetrics)
                    },
                }
                for entry, own in paths.items()
            ],
            "versions": versions(),
            "config": {
                "suite": protocol.suite,
                "demonstration_sets": protocol.demonstration_sets,
                "seed": folder.plan.seed,
            },
        }

    def document(
        self,
        folder: RunFolder,
        results: Sequence[Screening],
        summary: Mapping[str, Any],
        command: str,
    ) -> Document:
        """A table of shares, and one of means."""
        told = Paragraph(
            "Per cent of paths that would dress, and in brackets of those that end where the "
            "operator's do; no physics, so no success rates."
        )
        return Document(
            f"Kinematic screening on suite {summary['config']['suite']}",
            command,
            (told, Table(shares_table(summary["rows"]))),
            (
                Section("Means [m]", (Table(means_table(summary["rows"])),), folded=True),
                config_section(summary),
            ),
        )


def shares_table(rows: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    """Shares, a line for each change and a column for each row, the first line the heading."""
    by_change: dict[str, dict[str, str]] = {}
    for row in rows:
        stem, _, change = row["policy"].partition("?")
        cell = f"{row['pc_dresses']:.0f} ({row['pc_ends']:.0f})"
        by_change.setdefault(change, {})[f"{stem} {row['demonstrations']}"] = cell
    names = list(dict.fromkeys(name for cells in by_change.values() for name in cells))
    body = [
        [f"`{change}`" if change else "as chosen", *(cells.get(name, "-") for name in names)]
        for change, cells in by_change.items()
    ]
    return [["hyper-parameters", *names], *body]


def means_table(rows: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    """Every metric's mean, a line for each row, the first line the heading."""
    names = [field.name for field in fields(PathMetrics)]
    body = [
        [f"{row['policy']} on {row['demonstrations']}", *(f"{row['means'][n]:.3f}" for n in names)]
        for row in rows
    ]
    return [["row", *names], *body]


def main(
    suite: str = "val50",
    sets: int = 3,
    changes: tuple[str, ...] = CHANGES,
    workers: int | None = None,
    out: Path = Path("results/tuning"),
    resume: bool = False,
) -> None:
    """Screen hyper-parameters of policies without physics, and print per cent of good paths.

    Args:
        suite: postures to ask for paths on; never those of a test.
        sets: demonstration sets.
        changes: hyper-parameters to compare, each as after a policy's name.
        workers: processes, as many as processors unless given.
        out: folder for the results.
        resume: continue the run in the folder.
    """
    plan = tuning_plan(suite, sets, changes)
    command = f"python -m dressing_sim.benchmark.studies.tuning {shlex.join(sys.argv[1:])}".strip()
    with Processes(workers or processors()) as crew, show_progress(Console(stderr=True)) as report:
        study = Tuning()
        finished = run_study(
            study, plan, crew, out, resume=resume, progress=report, command=command
        )
    print_document(finished.document)


if __name__ == "__main__":
    tyro.cli(main)
