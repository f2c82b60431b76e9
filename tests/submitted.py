"""Submitted results without physics, and ways to change them."""

import hashlib
import json
from functools import partial

from fake_benchmark import Threads, fake_work

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.store import open_run
from dressing_sim.benchmark.scoreboard.rules import Statement
from dressing_sim.benchmark.scoreboard.submission import counted_rows, read_submission
from dressing_sim.benchmark.studies import STUDIES
from dressing_sim.benchmark.studies.study import run_jobs
from dressing_sim.benchmark.studies.success import Success

ADA = Statement("Ada Example", "2026-11-27", "https://example.org/~ada")
ROWS = (Entry("expert"), Entry("tp-gmm", "case_a"))


def fake_run(folder, monkeypatch, entries=ROWS, suite="paper5", seed=0, **options):
    """A finished run, ten episodes unless asked otherwise, of a study that stays without physics."""
    monkeypatch.setitem(STUDIES, "success", partial(Success, work=fake_work(folder)))
    plan = make_plan(Protocol("mine", suite, tuple(entries)), seed, **options)
    with Threads(2) as workers, open_run(folder / "run", plan) as run:
        run_jobs(STUDIES["success"](), run, workers)
    return folder / "run"


def episodes_of(values):
    return "".join(json.dumps(line) + "\n" for line in values["episodes"])


def changed(path, change, honest=True):
    """A submitted file with something changed by a function of its values.

    If it is to look honest, its checksum and its rows follow.
    """
    values = json.loads(path.read_text())
    values = change(values) or values
    if honest:
        values["episodes_sha256"] = hashlib.sha256(episodes_of(values).encode()).hexdigest()
        path.write_text(json.dumps(values))
        values["rows"] = _recounted(path, values)
    path.write_text(json.dumps(values))
    return path


def _recounted(path, values):
    from dressing_sim.benchmark.run.store import RunFolder

    return counted_rows(RunFolder(path, values["config"], episodes_of(values).encode()))


def flip(values, index=3):
    line = values["episodes"][index]
    line["success"] = not line["success"]
    line["failures"] = [] if line["success"] else [{"reason": "stuck", "detail": "made up"}]


__all__ = ["ADA", "ROWS", "changed", "episodes_of", "fake_run", "flip", "read_submission"]
