"""A policy that gives no answer costs its own row, and is in its denominator."""

import json

import pytest

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.executors import Processes
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.replay import replay_episode
from dressing_sim.benchmark.run.runner import Work, record_demonstration
from dressing_sim.benchmark.run.store import load_run
from dressing_sim.benchmark.studies.study import run_study
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.policies.host import PolicyLimits

GONE = ("Raises", "RaisesInFit", "Hangs", "Nan", "Exits", "ExitsAtOnce", "ActsWrong")

#: What they have learned is a function, which cannot be sent to a worker.
OURS = ("straight", "warp")

#: So short that nobody dresses anybody: what is tested is who answered.
CONFIG = EpisodeConfig(hold=0.1, time_limit=1.0)

LIMITS = PolicyLimits(fit_time=5.0, generate_time=3.0)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    out = tmp_path_factory.mktemp("run") / "out"
    names = (*(f"broken:{name}" for name in (*GONE, "Talks")), *OURS)
    entries = [Entry("expert"), *(Entry(name, "case_b") for name in names)]
    plan = make_plan(Protocol("few", "case_b", tuple(entries)), config=CONFIG, policy_limits=LIMITS)
    study = Success(Work(demonstrate=demonstrate_in_full))
    with Processes(2) as workers:
        return out, study, run_study(study, plan, workers, out)


def demonstrate_in_full(seed, posture, number, config, style=""):
    return record_demonstration(seed, posture, number, EpisodeConfig())


def test_each_row_has_all_its_episodes_and_says_what_happened(ran):
    out, _, finished = ran
    rows = {row["policy"]: row for row in finished.summary["rows"]}
    for name in GONE:
        row = rows[f"broken:{name}"]
        assert row["failures"] == {"policy_error": 2}
        assert (row["n_episodes"], row["n_success"], row["n_void"]) == (2, 0, 0)
    for name in ("expert", "broken:Talks", *OURS):
        assert "policy_error" not in rows[name]["failures"]
        assert rows[name]["n_episodes"] == 2
    text = (out / "report.md").read_text()
    assert "ValueError: no idea what to do (broken.py, line" in text
    assert "took longer than 3 s to generate" in text
    assert "its process ended (exit code 7)" in text


def test_limits_stand_in_the_run_s_config_and_prints_in_its_log(ran):
    out, _, _ = ran
    config = json.loads((out / "config.json").read_text())
    assert config["policy_limits"] == {"fit_time": 5.0, "generate_time": 3.0, "memory": 4.0}
    origin = config["provenance"]["sources"]["broken:Raises"]
    assert set(origin) == {"sha256", "version"}
    assert "from below" in (out / "policies.log").read_text()


@pytest.mark.parametrize("name", ["expert", "broken:Raises", "broken:ActsWrong", "broken:Talks"])
def test_an_episode_without_an_answer_is_replayed_like_any_other(ran, name):
    out, study, finished = ran
    index = next(r.index for r in finished.results if r.entry.policy == name)
    assert replay_episode(study, load_run(out), index).agreement.differences == []
