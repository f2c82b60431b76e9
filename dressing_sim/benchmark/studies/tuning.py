"""The study of tuning: what paths policies draw on postures, by hyper-parameters, without physics.

    python -m dressing_sim.benchmark.studies.tuning --suite val50 --sets 3

Demonstrations are the operator's paths, which the gripper follows to a millimetre. A path is
compared with the operator's own, without its variability. This chooses hyper-parameters worth
simulating; it does not predict success rates.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import tyro
from rich.console import Console

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.report.document import (
    Cells,
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
from dressing_sim.benchmark.studies.columns import table_of
from dressing_sim.benchmark.studies.study import Calls, Study, Summary, run_study
from dressing_sim.benchmark.studies.tuning_paths import PathMetrics, tried
from dressing_sim.policies.paper import POLICIES
from dressing_sim.provenance import versions
from dressing_sim.seeds import derived_seed
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

_METRICS = tuple(one.name for one in fields(PathMetrics))


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


def screen(
    job: Screening, demonstrated: Sequence[Posture], tested: Sequence[Posture], seed: int = 0
) -> Screening:
    """Let a policy learn from the operator, and compare its paths with the operator's."""
    number = job.demonstration_set
    drawn = derived_seed(f"{seed}/screening/{number}") if seed else number
    found = tried(job.entry.policy, demonstrated, tested, drawn)
    return replace(job, paths=tuple(metrics for *_, metrics in found))


def tuning_plan(
    suite: str = "val50", sets: int = 3, changes: Sequence[str] = CHANGES, seed: int = 0
) -> Plan:
    """The plan of the study: every row under every change."""
    marks = [f"?{change}" if change else "" for change in changes]
    entries = [replace(row, policy=f"{row.policy}{mark}") for mark in marks for row in ROWS]
    protocol = Protocol("tuning", suite, tuple(entries), demonstration_sets=sets, study="tuning")
    return make_plan(protocol, seed)


@dataclass(frozen=True)
class Tuning(Study[Screening, Screening]):
    """Per cent of a policy's paths that would dress, by hyper-parameters and row."""

    stage = "policies"
    result = Screening

    def jobs(self, plan: Plan) -> Sequence[Screening]:
        """Each row with each demonstration set."""
        places = product(plan.protocol.entries, range(plan.protocol.demonstration_sets))
        return [Screening(index, *place) for index, place in enumerate(places)]

    def calls(
        self, folder: OpenRun, jobs: Sequence[Screening], workers: Workers, progress: Progress
    ) -> Calls[Screening, Screening]:
        """Each job is a policy that learns and draws all its paths."""
        shown, tested = folder.plan.demonstrated, folder.plan.tested
        return screen, (
            (job, (job, shown[job.entry.demonstrations or ""], tested, folder.plan.seed))
            for job in jobs
        )

    def summarise(self, folder: RunFolder, results: Sequence[Screening]) -> dict[str, Any]:
        """Shares and means by row.

        Returns:
            ``{"rows": [{"policy", "demonstrations", "pc_dresses", "pc_ends", "score", "means"},
            ...], "versions", "config"}``, means of `PathMetrics` in metres.
        """
        protocol, rows = folder.plan.protocol, []
        for entry in protocol.entries:
            paths = [path for result in results if result.entry == entry for path in result.paths]
            means = {
                name: float(np.mean([getattr(path, name) for path in paths]))
                for name in ("dresses", "ends", "score", *_METRICS)
            }
            rows.append(
                {
                    "policy": entry.policy,
                    "demonstrations": entry.demonstrations,
                    "pc_dresses": 100.0 * means.pop("dresses"),
                    "pc_ends": 100.0 * means.pop("ends"),
                    "score": means.pop("score"),
                    "means": means,
                }
            )
        config = {
            "suite": protocol.suite,
            "demonstration_sets": protocol.demonstration_sets,
            "seed": folder.plan.seed,
        }
        return {"rows": rows, "versions": versions(), "config": config}

    def document(
        self, folder: RunFolder, results: Sequence[Screening], summary: Summary, command: str
    ) -> Document:
        """A table of shares, and one of means."""
        told = Paragraph(
            "Per cent of paths that would dress, and in brackets of those that end where the "
            "operator's do; no physics, so no success rates."
        )
        columns = {"row": "{policy} on {demonstrations}"}
        columns |= {name: f"{{means[{name}]:.3f}}" for name in _METRICS}
        means = Table(table_of(columns, summary["rows"]))
        return Document(
            f"Kinematic screening on suite {summary['config']['suite']}",
            command,
            (told, Table(shares_table(summary["rows"]))),
            (Section("Means [m]", (means,), folded=True), config_section(summary)),
        )


def shares_table(rows: Sequence[Mapping[str, Any]]) -> Cells:
    """Shares, a line for each change and a column for each row, the first line the heading."""
    lines: dict[str, dict[str, str]] = {}
    for row in rows:
        stem, _, change = row["policy"].partition("?")
        line = lines.setdefault(f"`{change}`" if change else "as chosen", {})
        line[f"{stem} {row['demonstrations']}"] = f"{row['pc_dresses']:.0f} ({row['pc_ends']:.0f})"
    names = list(dict.fromkeys(name for line in lines.values() for name in line))
    body = [[change, *(line.get(name, "-") for name in names)] for change, line in lines.items()]
    return [["hyper-parameters", *names], *body]


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
        done = run_study(Tuning(), plan, crew, out, resume=resume, progress=report, command=command)
    print_document(done.document)


if __name__ == "__main__":
    tyro.cli(main)
