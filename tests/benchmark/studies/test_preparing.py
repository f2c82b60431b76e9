"""What one worker does while others demonstrate: compile the loops of learning."""

import subprocess
import sys

import pytest
from fake_benchmark import Threads, fake_demonstrate

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.progress import silent
from dressing_sim.benchmark.run.runner import Work, record_demonstrations
from dressing_sim.benchmark.run.store import open_run

COMPILES = """
import os, sys
from pathlib import Path
import numpy as np
from dressing_sim.benchmark.studies.preparing import compile_learning
from dressing_sim.benchmark.studies.tuning_paths import tried
from dressing_sim.policies import paper, transported
from dressing_sim.suites.suites import load_suite

def kept():
    return {path.name for path in Path(os.environ["NUMBA_CACHE_DIR"]).rglob("*.nbc")}

compile_learning()
prepared = kept()
for name in (*paper.POLICIES, *transported.POLICIES):
    for suite in ("case_b", "baseline7"):
        for _ in tried(name, load_suite(suite), load_suite("paper5"), seed=3):
            pass
print(len(prepared), sorted(kept() - prepared))
"""


def test_it_compiles_all_that_policies_learn_with(tmp_path):
    told = subprocess.run(
        [sys.executable, "-c", COMPILES],
        capture_output=True,
        text=True,
        env={"NUMBA_CACHE_DIR": str(tmp_path), "PATH": ""},
    )
    assert told.returncode == 0, told.stderr
    count, more = told.stdout.split(maxsplit=1)
    assert int(count) > 5
    assert more.strip() == "[]"


@pytest.mark.parametrize(("count", "done"), [(1, 0), (2, 1)])
def test_it_is_done_once_and_only_if_others_demonstrate_meanwhile(tmp_path, count, done):
    plan = make_plan(Protocol("p", "case_b", (Entry("tp-gmm", "case_a"),), demonstration_sets=2))
    prepared = []

    def demonstrate(*arguments):
        return fake_demonstrate(tmp_path, *arguments)

    work = Work(demonstrate, prepare=lambda: prepared.append(1))
    with Threads(count) as workers, open_run(tmp_path / "run", plan) as folder:
        for _ in range(2):  # the second time they are all there
            record_demonstrations(folder, workers, silent, work)
    assert len(prepared) == done
