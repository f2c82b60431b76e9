"""A process of its own for other people's policies, which may do anything.

A policy that raises, exits, hangs, prints or eats memory costs an answer, and nothing else: the
process is given so much time for each answer, and so much memory, and a new one is started when it
has died. What policies print goes to a log. It guards against accidents, not against malice.
"""

from __future__ import annotations

import faulthandler
import multiprocessing
import os
import sys
import threading
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import invalidate_caches
from multiprocessing.connection import Connection, wait
from multiprocessing.reduction import ForkingPickler
from pathlib import Path
from typing import Any

import numpy as np

from dressing_sim.config import check_numbers
from dressing_sim.errors import (
    Abstained,
    DressingSimError,
    InvalidInputError,
    PolicyError,
    one_line,
)
from dressing_sim.inputs import fit, inputs_of
from dressing_sim.numerics import single_threaded
from dressing_sim.path import checked_path, reset_policy, seed_argument
from dressing_sim.policies.registry import make_policy, policy_origin
from dressing_sim.system import (
    end_group,
    ignore_interrupt,
    lead_own_group,
    leave,
    limit_own_resources,
    starting_process,
)

#: How much the log of what policies print may grow to [bytes].
_LOG = 64 * 2**20

#: How long a process may take to begin: Python, numpy and the policy's own imports [s].
START = 60.0


@dataclass(frozen=True, slots=True)
class PolicyLimits:
    """What a policy of other people may use."""

    fit_time: float = 60.0
    """Longest time to learn [s]."""
    generate_time: float = 10.0
    """Longest time for a path, or for one target in closed loop [s]."""
    memory: float = 4.0
    """Most memory that it may allocate, where the platform has such a limit [GiB]."""

    def __post_init__(self) -> None:
        check_numbers(self, "policy limits", ("fit_time", "generate_time", "memory"))


class Host:
    """The process, started when it is first asked, and anew after it has died.

    Args:
        limits: What a policy may use.
        log: File for what it prints; without one that goes to standard error.
    """

    def __init__(self, limits: PolicyLimits | None = None, log: Path | None = None) -> None:
        self.limits = limits or PolicyLimits()
        self._log = log
        self._process: Any = None
        self._connection: Connection

    def ask(self, seconds: float, what: str, *arguments: Any) -> Any:
        """Let the process answer one of the requests of `_Server`.

        Args:
            seconds: How long it may take.
            what: Name of the request.
            arguments: Of the request.

        Raises:
            PolicyError: The policy raised, took too long, or ended its process.
            Abstained: It chose to.
        """
        if self._process is None or not self._process.is_alive():
            self._start()
        try:
            # Where modules are found may have changed since the process began.
            self._connection.send((what, arguments, sys.path))
            if not self._connection.poll(seconds):
                self.close()
                raise PolicyError(f"took longer than {seconds:g} s to {what}")
            failed, answer = self._connection.recv()
        except (EOFError, OSError) as error:
            self._process.join(1.0)
            code = self._process.exitcode
            self.close()
            raise PolicyError(f"its process ended (exit code {code}) in {what}") from error
        if failed is not None:
            raise failed(answer)
        return answer

    def _start(self) -> None:
        self.close()
        context = multiprocessing.get_context("spawn")
        self._connection, other = context.Pipe()
        arguments = other, self._log, int(self.limits.memory * 2**30)
        self._process = context.Process(target=_serve, args=arguments, daemon=True)
        with starting_process():
            self._process.start()
        other.close()
        try:
            begun = self._connection.poll(START) and self._connection.recv() == "begun"
        except (EOFError, OSError):
            begun = False
        if not begun:
            self.close()
            raise DressingSimError(
                "no process can be started for a policy; is there enough memory?"
            )

    def __del__(self) -> None:
        if not sys.is_finalizing():  # else Python ends its children itself
            self.close()

    def close(self) -> None:
        """End the process, and those that it started."""
        process, self._process = self._process, None
        if process is None:
            return
        if process.pid is not None:
            end_group(process.pid)
            process.kill()
            process.join()
        self._connection.close()


def _serve(connection: Connection, log: Path | None, memory: int) -> None:
    """What the process does: answer until the other end is closed."""
    lead_own_group()
    ignore_interrupt()
    _print_to(log)
    limit_own_resources(memory, _LOG)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    server = _Server()
    connection.send("begun")
    while True:
        try:
            what, arguments, path = connection.recv()
        except (EOFError, OSError):
            os._exit(0)
        sys.path[:] = [*path, *_here()]
        invalidate_caches()
        answer: tuple[type[PolicyError] | None, Any]
        try:
            answer = None, single_threaded(getattr(server, what), *arguments)
        except Abstained as error:
            answer = Abstained, str(error)
        except BaseException as error:  # also what exits: the policy's, not ours
            answer = PolicyError, described_error(error)
        sys.stdout.flush()
        try:
            connection.send(answer)
        except Exception as error:  # an answer that cannot be sent
            connection.send((PolicyError, described_error(error)))


def _here() -> list[str]:
    """The folder where the command was typed, as a policy may be a file in it; it may be gone."""
    try:
        return [os.getcwd()]
    except OSError:
        return []


def _print_to(log: Path | None) -> None:
    try:
        file = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666) if log else os.dup(2)
    except OSError:  # a log is not worth a policy
        file = os.open(os.devnull, os.O_WRONLY)
    null = os.open(os.devnull, os.O_RDONLY)
    for source, target in ((null, 0), (file, 1), (file, 2)):
        os.dup2(source, target)
    # What follows stays open as long as the process.
    sys.stdin = open(0, closefd=False, encoding="utf-8")  # noqa: SIM115
    sys.stdout = open(1, "w", 1, closefd=False, encoding="utf-8", errors="replace")  # noqa: SIM115
    sys.stderr = open(2, "w", 1, closefd=False, encoding="utf-8", errors="replace")  # noqa: SIM115
    faulthandler.enable(2)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
    leave(1)


def described_error(error: BaseException) -> str:
    """An exception in a line: its type, its message, and the last line of its traceback."""
    if isinstance(error, DressingSimError):
        return one_line(str(error))
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if frame.filename != __file__]
    where = ""
    if own:
        last = own[-1]
        where = f" ({Path(last.filename).name}, line {last.lineno}, in {last.name}: {last.line})"
    message = one_line(str(error)) if str(error) else ""
    return one_line(f"{type(error).__name__}{': ' if message else ''}{message}{where}")


class _Server:
    """Requests, answered in the process; plain values and arrays go back."""

    def __init__(self) -> None:
        self._acting: Any = None

    def describe(self, name: str) -> Mapping[str, Any]:
        """What there is to know of a policy before it learns."""
        policy = make_policy(name)
        return {
            "inputs": inputs_of(policy),
            "stream": getattr(policy, "stream", type(policy).__qualname__),
            "acts": callable(getattr(policy, "act", None)),
            "origin": policy_origin(name),
        }

    def fit(self, name: str, seed: int, demonstrations: Any) -> tuple[bytes, Any]:
        """A policy that has learned, and its time step."""
        fitted = fit(make_policy(name, seed), demonstrations)
        if fitted is None:
            raise InvalidInputError("fit returned None, valid is the policy itself")
        # As objects pass between processes; it never gets into a file.
        return bytes(ForkingPickler.dumps(fitted)), getattr(fitted, "dt", None)

    def generate(self, fitted: bytes, asked: Any, start: Any, seed: int) -> tuple[Any, ...]:
        """What a `Path` is made of."""
        policy = ForkingPickler.loads(fitted)
        drawn = seed_argument(policy.generate, seed)
        path = checked_path(policy.generate(asked, start, **drawn), "the policy")
        return np.array(path.positions), path.dt, path.probability

    def begin(self, fitted: bytes, seed: int) -> None:
        """Prepare an episode in closed loop."""
        self._acting = ForkingPickler.loads(fitted)
        reset_policy(self._acting, seed)

    def act(self, observation: Any) -> Any:
        """The next target (3,) [m], or None at the end."""
        target = self._acting.act(observation)
        return None if target is None else np.array(target, dtype=float)
