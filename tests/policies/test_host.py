"""Other people's policies may do anything; it costs an answer."""

import subprocess
import time
from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.errors import InvalidInputError, PolicyError
from dressing_sim.path import policy_path
from dressing_sim.policies import hosted
from dressing_sim.policies.host import Host, PolicyLimits
from dressing_sim.policies.hosted import hosted_policy

LIMITS = PolicyLimits(fit_time=3.0, generate_time=3.0, memory=1.0)

#: For those who come to an end, however busy the machine is.
PATIENT = replace(LIMITS, fit_time=120.0, generate_time=120.0)

BROKEN = {
    "Raises": r"ValueError: no idea what to do \(broken\.py, line \d+, in generate: raise",
    "RaisesInFit": "RuntimeError: cannot learn this",
    "Hangs": "took longer than 3 s to generate",
    "HangsInFit": "took longer than 3 s to fit",
    "Nan": "not finite",
    "Shape": r"shape \(10, 2\)",
    "Text": "straight ahead",
    "Nothing": "None|shape",
    "Endless": "generator",
    "EndlessArray": "took longer than 3 s to generate",
    "Exits": "SystemExit: 3",
    "ExitsAtOnce": r"its process ended \(exit code 7\) in generate",
    "ExitsInFit": r"its process ended \(exit code 0\) in fit",
    "Aborts": r"its process ended \(exit code -6\) in generate",
    "Recurses": "RecursionError",
    "Eats": "MemoryError",
    "Closes": "its process ended",
    "LeavesChildren": "took longer than 3 s to generate",
    "Kept": "pickle",
    "ReturnsNothingFromFit": "fit returned None",
    "Timeless": "dt",
}


@pytest.fixture
def asked(posture):
    return posture.frames(), np.array([0.4, 0.1, 0.3])


def answer(name, posture, demonstration, log=None):
    limits = LIMITS if "took longer" in BROKEN.get(name, "") else PATIENT
    policy = hosted_policy(f"broken:{name}", 0, limits, log).fit([demonstration])
    return policy_path(policy, posture, np.array([0.4, 0.1, 0.3]), 0, 0.05, 60.0)


@pytest.mark.parametrize("name", sorted(BROKEN))
def test_whatever_a_policy_does_is_one_error_of_one_line(name, posture, demonstration):
    with pytest.raises(PolicyError, match=BROKEN[name]) as caught:
        answer(name, posture, demonstration)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400
    # The next one is not concerned.
    assert len(answer("Fine", posture, demonstration).positions) == 40


def test_a_hosted_policy_gives_the_bits_that_it_gives_here(posture, demonstration):
    from broken import Fine

    start = np.array([0.4, 0.1, 0.3])
    here = policy_path(Fine().fit([demonstration]), posture, start, 0, 0.05, 60.0)
    assert np.array_equal(answer("Fine", posture, demonstration).positions, here.positions)


def test_what_a_policy_prints_goes_to_the_log_and_nowhere_else(
    posture, demonstration, tmp_path, capfd
):
    log = tmp_path / "policies.log"
    answer("Talks", posture, demonstration, log)
    text = log.read_text()
    assert text.count("x") >= 500_000
    assert text.count("y") >= 500_000
    assert "from below" in text
    assert capfd.readouterr() == ("", "")


def test_what_a_policy_started_ends_with_it(posture, demonstration):
    with pytest.raises(PolicyError):
        answer("LeavesChildren", posture, demonstration)
    time.sleep(0.2)
    running = subprocess.run(["ps", "ax", "-o", "args"], capture_output=True, text=True, check=True)
    assert "left behind" not in running.stdout


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("builtins:exit", "not a class"),
        ("builtins:int", "not a class"),
        ("os:system", "not a class"),
        ("no_such_module:Class", "no_such_module"),
        ("broken:NoSuchClass", "NoSuchClass"),
        ("broken:MakesNoInstance", "weights.bin"),
        ("broken:Fine?speed=3", "speed"),
    ],
)
def test_what_is_no_policy_is_named_before_anything_is_done(name, told):
    with pytest.raises(InvalidInputError, match=told):
        hosted_policy(name, 0, LIMITS)


def test_a_module_that_is_there_only_now_is_found_by_a_process_that_runs(tmp_path, monkeypatch):
    host = Host(LIMITS)
    try:
        host.ask(60.0, "describe", "broken:Fine")
        first = host._process.pid
        (tmp_path / "only_now.py").write_text("from broken import Fine as Late\n")
        monkeypatch.syspath_prepend(tmp_path)
        host.ask(60.0, "describe", "only_now:Late")
        assert host._process.pid == first
    finally:
        host.close()


def test_a_folder_that_has_gone_is_no_reason_to_give_up(tmp_path, monkeypatch):
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    host = Host(LIMITS)
    try:
        host.ask(60.0, "describe", "broken:Fine")
        gone.rmdir()
        host.ask(60.0, "describe", "broken:Fine")
    finally:
        host.close()


def test_the_process_is_used_again_while_it_lives_and_replaced_when_it_has_died():
    host = Host(LIMITS)
    try:
        host.ask(60.0, "describe", "broken:Fine")
        first = host._process.pid
        host.ask(60.0, "describe", "broken:Fine")
        assert host._process.pid == first
        host._process.kill()
        host._process.join()
        host.ask(60.0, "describe", "broken:Fine")
        assert host._process.pid != first
    finally:
        host.close()


def test_a_policy_has_one_process_however_often_it_learns(demonstration, tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(hosted, "Host", lambda *given: made.append(given) or Host(*given))
    hosted._host.cache_clear()
    try:
        for seed in range(3):
            hosted_policy("broken:Fine", seed, PATIENT, tmp_path / "log").fit([demonstration])
    finally:
        hosted._host.cache_clear()
    assert len(made) == 1
