"""Hostile input, many times: files, command lines and policies that are mutated at random.

python scripts/fuzz.py                          # half an hour
python scripts/fuzz.py --inputs 10000 --seed 7  # so many inputs, however long they take
python scripts/fuzz.py --minutes 1

Each input must end well: with exit code 0, or with exit code 2 (of `demonstrate` 3) and one line on
standard error. Counted are tracebacks, wrong exit codes, more or less than one line, files that are
left over, and files that were there before and are not the same. Exit code 1 if there is any.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import tyro
from fuzz_inputs import COMMANDS, POLICIES, Material, mutated_line, mutated_policy

from dressing_sim.cli import main as command_line
from dressing_sim.errors import DressingSimError

FAULTS = ("traceback", "exit code", "lines", "leftover", "lost bytes")


def run(arguments: Sequence[str]) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of a command in this process."""
    out, err, code = io.StringIO(), io.StringIO(), 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            command_line(list(arguments))
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
        except BaseException:
            code = -1
            traceback.print_exc()
    return code, out.getvalue(), err.getvalue()


def faults_of(arguments: Sequence[str], folder: Path) -> Iterator[tuple[str, str]]:
    """What is wrong with how a command ended, each with a detail."""
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    code, _, err = run(arguments)
    after = {path for path in folder.rglob("*") if path.is_file()}
    if "Traceback" in err:
        yield "traceback", err.strip().splitlines()[-1]
    elif code not in (0, 2, 3):
        yield "exit code", f"{code}: {err[-200:]}"
    elif code and err.rstrip("\n").count("\n"):
        yield "lines", err
    new = after - set(before)
    if code and new:
        yield "leftover", ", ".join(sorted(path.name for path in new))
    for path, content in before.items():
        if not path.is_file() or (code and path.read_bytes() != content):
            yield "lost bytes", path.name
    for path in new:
        path.unlink()


def of_policy(rng: np.random.Generator, _: Material) -> Iterator[tuple[str, str]]:
    """A policy in a process of its own: a path, or one error of one line."""
    name = mutated_policy(rng)
    try:
        POLICIES.answer(name)
    except DressingSimError as error:
        if "\n" in str(error):
            yield "lines", f"{name}: {error}"
    except Exception as error:
        yield "traceback", f"{name}: {error!r}"


def of_command(rng: np.random.Generator, material: Material) -> Iterator[tuple[str, str]]:
    """A command with a mutated file or a mutated line."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        arguments = mutated_line(rng, material, folder)
        before = os.getcwd()
        os.chdir(folder)
        try:
            for fault, detail in faults_of(arguments, folder):
                yield fault, f"{' '.join(map(repr, arguments))}: {detail}"
        finally:
            os.chdir(before)


def main(minutes: float = 30.0, inputs: int | None = None, seed: int = 0, show: int = 20) -> None:
    """Try inputs until the time is over.

    Args:
        minutes: how long, unless a number of inputs is given.
        inputs: how many.
        seed: of the inputs; input n of a seed is always the same.
        show: how many faults to print.
    """
    counts: Counter[str] = Counter()
    end = time.monotonic() + 60.0 * minutes
    shown, n = 0, 0
    with tempfile.TemporaryDirectory() as folder:
        material = Material.make(Path(folder))
        kinds: list[Callable[..., Iterator[tuple[str, str]]]] = [of_command] * 19 + [of_policy]
        while n < inputs if inputs is not None else time.monotonic() < end:
            rng = np.random.default_rng([seed, n])
            for fault, detail in kinds[int(rng.integers(len(kinds)))](rng, material):
                counts[fault] += 1
                if shown < show:
                    shown += 1
                    print(f"input {n}: {fault}: {detail[:2000]}", file=sys.stderr)
            n += 1
            if n % 500 == 0:
                print(f"{n} inputs, {sum(counts.values())} faults", file=sys.stderr)
    POLICIES.close()
    found = {fault: counts[fault] for fault in FAULTS}
    print(json.dumps({"inputs": n, "seed": seed, "commands": len(COMMANDS), **found}))
    raise SystemExit(1 if any(found.values()) else 0)


if __name__ == "__main__":
    tyro.cli(main)
