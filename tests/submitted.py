"""Submitted results without physics, and ways to change them."""

import hashlib
import json
from functools import partial

from fake_benchmark import Threads, fake_work

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.store import RunFolder, open_run
from dressing_sim.benchmark.scoreboard.rules import Statement
from dressing_sim.benchmark.scoreboard.submission import counted_rows
from dressing_sim.benchmark.studies import STUDIES
from dressing_sim.benchmark.studies.study import run_jobs
from dressing_sim.benchmark.studies.success import Success

ADA = Statement("Ada Example", "2026-11-27", "https://example.org/~ada")
ROWS = (Entry("expert"), Entry("tp-gmm", "case_a"))


def fake_run(folder, monkeypatch, entries=ROWS, **options):
    """A finished run, of ten episodes unless asked otherwise; the study stays without physics."""
    monkeypatch.setitem(STUDIES, "success", partial(Success, work=fake_work(folder)))
    plan = make_plan(Protocol("mine", "paper5", tuple(entries)), **options)
    with Threads(2) as workers, open_run(folder / "run", plan) as run:
        run_jobs(STUDIES["success"](), run, workers)
    return folder / "run"


def others_run(folder, monkeypatch):
    """The same of a policy of somebody else's, which is not installed."""
    monkeypatch.setattr("dressing_sim.benchmark.run.plan.hosted_policy", lambda *_, **__: None)
    monkeypatch.setattr("dressing_sim.benchmark.run.origin.policy_origins", lambda *_: {})
    return fake_run(folder, monkeypatch, [Entry("nobodys_module:Policy", "case_a")])


def episodes_of(values):
    return "".join(json.dumps(line) + "\n" for line in values["episodes"])


def changed(path, change, seal=True, recount=True):
    """A submitted file with something changed by a function of its values.

    If it is to look honest, it is sealed, its checksum follows, and so do its rows.
    """
    values = json.loads(path.read_text())
    values = change(values) or values
    if seal:
        content = episodes_of(values).encode()
        values["episodes_sha256"] = hashlib.sha256(content).hexdigest()
        if recount:
            values["rows"] = counted_rows(RunFolder(path, values["config"], content))
    path.write_text(json.dumps(values))
    return path


def flip(values, index=3):
    line = values["episodes"][index]
    line["success"] = not line["success"]
    line["failures"] = [] if line["success"] else [{"reason": "stuck", "detail": "made up"}]
