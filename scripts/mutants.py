"""Which changes of the code do the tests not see? A random sample of mutants, each one tested.

    python scripts/mutants.py dressing_sim/learning [--count 80] [--seed 0] [--limit 90]

Each mutant (see ``mutations``) meets the tests of its room in a copy of the tree, the nearest
file first, without those that take longer than ``--slow`` seconds: the share killed is a lower
bound. A mutated kernel is compiled anew, with those that call it.

The mutations are our own, of a hundred lines. Cosmic-ray has the same ones, but mutates annotations
too, draws no seeded sample, loads MuJoCo and Pinocchio again for every mutant, and does not know
that numba's cache outlives a change of a kernel that another one calls.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import importlib
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mutations import Mutant, mutants
from scipy import stats

ROOT = Path(__file__).resolve().parents[1]
PYTEST = ["-x", "-q", "-p", "no:cacheprovider", "--durations=0"]
#: Prints the environment and the libraries that tests need, which are then loaded once for all.
PROBE = """import sys; sys.path[:0] = ["tests"]; import conftest, os
names = [name for name in sys.modules if name.partition(".")[0] not in ("dressing_sim", "conftest")]
print(repr((dict(os.environ), names)))"""


def tests_of(path: Path) -> list[str]:
    """The test files of a module's room, the nearest first; all below the room for its packages."""
    folder = ROOT / "tests" / path.relative_to("dressing_sim").parent
    while not list(folder.glob("test_*.py")):
        folder = folder.parent
    names = (f"test_{path.stem}", f"test_{path.parent.name}")

    def distance(test: Path) -> tuple[bool, bool, bool]:
        named = re.search(rf"\b{path.stem}\b", test.read_text(encoding="utf-8")) is not None
        return test.stem not in names, not test.stem.startswith(names[0][:-1]), not named

    return [
        str(test.relative_to(ROOT))
        for test in sorted(sorted(folder.glob("test_*.py")), key=distance)
    ]


def run(scratch: Path, arguments: list[str], cache: Path, limit: float) -> int | None:
    """Exit code of pytest in a fork, negative by a signal; None where time is up."""
    copy, log = scratch / "tree", scratch / "log"
    child = os.fork()
    if child == 0:
        os.setsid()
        out = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(out, 1)
        os.dup2(out, 2)
        os.chdir(copy)
        sys.path.insert(0, str(copy))
        os.environ.update(PYTHONPATH=str(copy), NUMBA_CACHE_DIR=str(cache))
        config = importlib.import_module("numba").config
        config.CACHE_DIR = str(cache)
        if cache.name == "fresh":  # the compiler need not do its best for a mutant
            config.OPT = type(config.OPT)(0)
        os._exit(int(importlib.import_module("pytest").main([*PYTEST, *arguments])))
    end = time.monotonic() + limit
    while time.monotonic() < end:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return None


def cache_for(mutant: Mutant, warm: Path, fresh: Path) -> Path:
    """Numba's cache without what a mutated kernel is part of."""
    if mutant.path.parent.name != "kernels":
        return warm
    shutil.rmtree(fresh, ignore_errors=True)
    shutil.copytree(warm, fresh)
    stem = mutant.path.stem
    for module in (ROOT / mutant.path.parent).glob("*.py"):
        if module.stem == stem or f".{stem} import" in module.read_text(encoding="utf-8"):
            for file in fresh.rglob(f"{module.stem}.*"):
                file.unlink()
    return fresh


def slow_tests(log: Path, limit: float) -> list[str]:
    """The tests that a run's table of durations says took longer."""
    rows = re.findall(r"^([\d.]+)s (?:call|setup) +(.+)$", log.read_text(), re.MULTILINE)
    return sorted({test for seconds, test in rows if float(seconds) > limit})


def verdict(mutant: Mutant, tests: list[str], scratch: Path, limit: float) -> str:
    """killed or survived; a mutant that comes to no end is killed too."""
    target = scratch / "tree" / mutant.path
    original, stamp = target.read_bytes(), target.stat()
    target.write_bytes(mutant.source(original))
    code = run(scratch, tests, cache_for(mutant, scratch / "numba", scratch / "fresh"), limit)
    target.write_bytes(original)
    os.utime(target, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    return "killed (time)" if code is None else "killed" if code else "survived"


def main() -> None:
    """Draw, run and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("where", type=Path, nargs="+", help="modules and rooms")
    for name, default in (("count", 80), ("seed", 0), ("limit", 90), ("slow", 1), ("files", 99)):
        parser.add_argument(f"--{name}", type=int, default=default)
    asked = parser.parse_args()
    os.chdir(ROOT)
    files = [file for where in asked.where for file in sorted(where.rglob("*.py")) or [where]]
    pool = [mutant for file in files for mutant in mutants(file)]
    sample = random.Random(asked.seed).sample(pool, min(asked.count, len(pool)))
    probe = subprocess.run(
        [sys.executable, "-c", PROBE], capture_output=True, text=True, check=True
    )
    environment, modules = ast.literal_eval(probe.stdout)
    os.environ.update(environment)
    for module in modules:
        with contextlib.suppress(ImportError):
            importlib.import_module(module)
    nearest = {mutant.path: tests_of(mutant.path)[: asked.files] for mutant in sample}
    slow = sorted({test for tests in nearest.values() for test in tests})
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        shutil.copytree(ROOT, scratch / "tree", ignore=shutil.ignore_patterns(".*", "__pycache__"))
        for _ in range(2):  # the second time, those only that were slow, and now without compiling
            begin = time.monotonic()
            if slow and run(scratch, slow, scratch / "numba", 3600.0) != 0:
                sys.exit("without a mutant:\n" + (scratch / "log").read_text())
            print(f"without a mutant: {time.monotonic() - begin:.0f} s", flush=True)
            slow = slow_tests(scratch / "log", asked.slow)
        sys.dont_write_bytecode = True  # in every fork from here on
        without = [word for test in slow for word in ("--deselect", test)]
        killed = 0
        for number, mutant in enumerate(sample, 1):
            begin = time.monotonic()
            result = verdict(mutant, [*nearest[mutant.path], *without], scratch, asked.limit)
            killed += result != "survived"
            print(f"{number:3} {result} {time.monotonic() - begin:.0f} s {mutant}", flush=True)
    interval = stats.binomtest(killed, len(sample)).proportion_ci(method="wilson")
    print(
        f"{killed} of {len(sample)} killed ({len(pool)} in all, seed {asked.seed}): "
        f"{killed / len(sample):.0%}, 95 % interval {interval.low:.0%} to {interval.high:.0%}"
    )


if __name__ == "__main__":
    main()
