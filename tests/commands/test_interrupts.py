"""Ctrl-C: exit code 130, soon, and no traceback, whatever the process is doing."""

import os
import signal
import subprocess
import sys
import time

import pytest

#: A terminal's Ctrl-C reaches a child of the tests even where they run in the background.
START = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"

COMMAND = (
    START
    + """
import sys
from dressing_sim import cli
real = cli._run
def run(given):
    print("ready", flush=True)
    real(given)
cli._run = run
cli.main(sys.argv[1:])
"""
)

#: A command that is in one call of compiled code for a long time.
COMPILED = (
    START
    + """
import numpy as np
from dressing_sim import cli
def run(given):
    from dressing_sim.learning import dtw_distance
    dtw_distance(np.zeros(10), np.ones(10))
    path = np.random.default_rng(0).random((200_000, 3))
    print("ready", flush=True)
    dtw_distance(path, path)
cli._run = run
cli.main([])
"""
)

#: One that does not hear, as a module that is being imported may not.
SWALLOWED = (
    START
    + """
import time
from dressing_sim import cli
def run(given):
    print("ready", flush=True)
    try:
        time.sleep(60)
    except KeyboardInterrupt:
        raise ImportError("initialization failed") from None
cli._run = run
cli.main([])
"""
)

#: One whose main thread waits while another is handed the signal.
ELSEWHERE = (
    START
    + """
import sys, threading, time
from dressing_sim import cli
def handed():
    time.sleep(0.3)
    signal.pthread_kill(threading.get_ident(), signal.SIGINT)
def run(given):
    threading.Thread(target=handed, daemon=True).start()
    try:
        threading.Event().wait(60)
    finally:
        print("to continue", file=sys.stderr)
cli._run = run
cli.main([])
"""
)

#: One that hears in a callback of C, whose exceptions go nowhere.
DROPPED = (
    START
    + """
import ctypes, time
from dressing_sim import cli
@ctypes.CFUNCTYPE(None)
def callback():
    print("ready", flush=True)
    time.sleep(60)
def run(given):
    callback()
    time.sleep(60)
cli._run = run
cli.main([])
"""
)

#: One whose first answer somebody clears, as C may while a module is imported.
CLEARED = (
    START
    + """
import time
from dressing_sim import cli
def run(given):
    try:
        print("ready", flush=True)
        time.sleep(60)
    except KeyboardInterrupt:
        pass
    time.sleep(60)
cli._run = run
cli.main([])
"""
)


def interrupted(code, arguments=(), after=0.3, cwd=None):
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=cwd,
    )
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(after)
        assert process.poll() is None
        begun = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        return process.returncode, errors, time.monotonic() - begun
    finally:
        process.kill()
        process.communicate()


def assert_soon(found):
    code, errors, seconds = found
    assert code == 130
    assert errors.splitlines()[-1] == "dressing-sim: interrupted"
    assert "Traceback" not in errors
    # A second on a machine that has nothing else to do.
    assert seconds < 1.0 + 0.5 * os.getloadavg()[0]


@pytest.mark.parametrize("after", [0.0, 0.1, 0.3, 0.6])
def test_while_the_command_line_s_modules_are_imported(after, tmp_path):
    arguments = ["planar", "--runs", "10000"]
    assert_soon(interrupted(COMMAND, arguments, after, tmp_path))


def test_while_it_learns(tmp_path):
    assert_soon(interrupted(COMMAND, ["planar", "--runs", "10000"], 6.0, tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_while_it_simulates(tmp_path):
    arguments = ["demonstrate", "val50", "--out", "some.h5"]
    assert_soon(interrupted(COMMAND, arguments, 6.0, tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_in_a_compiled_loop():
    assert_soon(interrupted(COMPILED))


def test_where_an_import_makes_another_error_of_it():
    assert_soon(interrupted(SWALLOWED))


def test_in_a_callback_that_drops_the_answer():
    assert_soon(interrupted(DROPPED))


def test_where_the_answer_is_cleared():
    assert_soon(interrupted(CLEARED))


def test_where_another_thread_is_handed_the_signal():
    done = subprocess.run(
        [sys.executable, "-c", ELSEWHERE], capture_output=True, text=True, check=False
    )
    assert done.returncode == 130
    assert done.stderr.splitlines() == ["to continue", "dressing-sim: interrupted"]


def test_a_process_that_ignores_it_goes_on():
    code = (
        "import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        "from dressing_sim import cli\n"
        "def run(given): print('ready', flush=True); time.sleep(2.0)\n"
        "cli._run = run\ncli.main([])\n"
    )
    returned, errors, _ = interrupted(code)
    assert (returned, errors) == (0, "")


def test_afterwards_all_is_as_it_was(capsys):
    from dressing_sim.cli import main

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(SystemExit):
        main(["undress"])
    assert signal.getsignal(signal.SIGINT) is before
    assert signal.set_wakeup_fd(-1) == -1
