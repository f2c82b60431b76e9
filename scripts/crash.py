"""Is anything lost if a command is killed? Each writing command, killed at random, then run again.

    python scripts/crash.py [--count 100] [--seed 0] [--only evaluate learn] [--minutes 60]

A round begins a command in an empty folder or over an earlier result, kills its process group
(``kill -9``) at a random moment, mostly while files change, and runs it to its end. Every whole
line and file that was there must still be there with the same bytes, no line twice, nothing may
be left over, and the end must have the same bits as a run that nobody disturbed.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from importlib import import_module
from pathlib import Path

from crash_checks import STUDIES, Whole, check_end, check_killed, contents, stamps

from dressing_sim.cli import main as command_line
from dressing_sim.numerics import common_environment

#: Loaded once for all commands, which are forks of this process.
LIBRARIES = (
    "dressing_sim.benchmark.studies.success",
    "dressing_sim.benchmark.studies.change",
    "dressing_sim.commands.studies",
    "dressing_sim.learning.storage",
    "dressing_sim.pictures.video",
    "dressing_sim.planar.figures",
    "dressing_sim.policies.hosted",
)
ANGLES = {"flexion_deg": 75, "abduction_deg": 20, "rotation_deg": 40}
RUN = "--workers 1 --no-pictures --out OUT"
FILM = "--fps 2 --width 64 --height 48 --video OUT/film.mp4"
#: Once, for all rounds: what the commands read.
MATERIAL = (
    "demonstrate one.json --out shown.h5",
    "evaluate --suite one.json --policies expert --workers 1 --no-pictures --out run",
)
#: What is begun, where OUT is a folder, and how often of ten rounds.
COMMANDS = {
    "demonstrate": ("demonstrate one.json --out OUT/shown.h5", 1),
    "learn": ("learn shown.h5 --policy tp-gmm?samples=60 --out OUT/policy.npz", 1),
    "planar": ("planar --runs 1 --max-iterations 1 --method noise --out OUT", 1),
    "dress": (f"dress --posture 75,20,40,5 --policy expert {FILM}", 1),
    "evaluate": (f"evaluate --suite two.json --policies expert,tp-gmm?samples=60 {RUN}", 4),
    "export": ("export shown.h5 --to robomimic --out OUT/shown.hdf5", 0.5),
    "replay": (f"replay run 0 {FILM}", 0.5),
    "thresholds": ("thresholds --suite one.json --policies expert --workers 1 --out OUT", 1),
    "validate": ("validate --suite one.json --change edge=0.05 --workers 1 --out OUT", 1),
}


def begin(arguments: list[str]) -> int:
    """The command line in a fork that leads a group of its own; its process."""
    child = os.fork()
    if child == 0:
        os.setsid()
        silent = os.open("log", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        sys.argv = ["dressing-sim", *arguments]
        code = 1
        try:
            command_line(arguments)
            code = 0
        except SystemExit as end:
            code = int(end.code or 0)
        finally:
            os._exit(code)
    return child


def finish(child: int) -> None:
    """Wait for a command that must succeed, which may be exit code 1: a verdict."""
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if code not in (0, 1):
        raise AssertionError(f"exit code {code}: {Path('log').read_text()[-500:]}")


def disturb(child: int, out: Path, draw: random.Random, seconds: float, most: int) -> bool:
    """Kill a command at a random moment or after some changes; whether it had not ended by then."""
    end = time.monotonic() + draw.uniform(0.0, seconds)
    changes, pause = draw.randint(1, most), draw.choice((0.0, 0.0, 0.0005, 0.01, 0.1))
    by_change, seen = draw.random() < 0.7, stamps(out)
    while by_change or time.monotonic() < end:
        if os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None:
            break
        now = stamps(out)
        changes -= now != seen
        seen = now
        if by_change and changes <= 0:
            time.sleep(pause)
            break
    alive = os.waitid(os.P_PID, child, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return alive


def typed(name: str, out: Path, *more: str) -> list[str]:
    """A command line."""
    return [word.replace("OUT", str(out)) for word in COMMANDS[name][0].split()] + list(more)


def undisturbed(name: str) -> Whole:
    """The result of a command, after that of another seed, as the first may compile."""
    earlier, out = Path("earlier") / name, Path("whole") / name
    seeded = name not in ("learn", "export", "replay")
    finish(begin(typed(name, earlier, *(["--seed", "5"] if seeded else []))))
    start = time.monotonic()
    finish(begin(typed(name, out)))
    return Whole(contents(out), time.monotonic() - start, earlier)


def one_round(name: str, out: Path, whole: Whole, draw: random.Random) -> int:
    """Kill a command a few times and run it to its end; how often it was killed while it ran."""
    shutil.rmtree(out, ignore_errors=True)
    wanted = dict(whole.files)
    if draw.random() < 0.4:  # over what is there
        shutil.copytree(whole.earlier, out)
        wanted["notes.txt"] = b"somebody's"
        (out / "notes.txt").write_bytes(wanted["notes.txt"])
    kills = [True] * draw.randint(1, 3) + [False]
    killed = 0
    for kill in kills:
        before = contents(out)
        resumed = "config.json" in before and "summary.json" not in before
        more = ["--resume"] if name in STUDIES and resumed else ["--force"]
        child = begin(typed(name, out, *more))
        if kill:
            killed += disturb(child, out, draw, whole.seconds, 15 if name in STUDIES else 3)
        else:
            finish(child)
        check_killed(name, before, contents(out), whole, resumed)
    check_end(contents(out), wanted)
    return killed


def main() -> None:
    """Run the rounds and print the counts; exit code 1 if anything was lost."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=100, help="kills, after which none is begun")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--minutes", type=float, default=1e9, help="begin no round after that")
    parser.add_argument("--only", nargs="+", choices=COMMANDS, default=list(COMMANDS))
    asked = parser.parse_args()
    last = time.monotonic() + 60.0 * asked.minutes
    os.environ.update(common_environment())
    for library in LIBRARIES:
        import_module(library)
    draw, faults = random.Random(asked.seed), []
    rounds: Counter[str] = Counter()
    kills: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for number, file in enumerate(("one.json", "two.json"), start=1):
            arms = [{"name": f"arm{i}", "elbow_deg": 5.0 + i, **ANGLES} for i in range(number)]
            Path(file).write_text(json.dumps({"postures": arms}))
        for command in MATERIAL:
            finish(begin(command.split()))
        wholes: dict[str, Whole] = {}
        weights = [COMMANDS[name][1] for name in asked.only]
        while kills.total() < asked.count and time.monotonic() < last:
            (name,) = draw.choices(asked.only, weights)
            if name not in wholes:
                wholes[name] = undisturbed(name)
            rounds[name] += 1
            try:
                kills[name] += one_round(name, Path("out"), wholes[name], draw)
            except AssertionError as fault:
                faults.append(f"round {rounds.total()}, {name}: {fault}")
                print(faults[-1], file=sys.stderr, flush=True)
    told = {"rounds": dict(rounds), "kills": dict(kills), "faults": faults}
    print(json.dumps({"seed": asked.seed, **told}))
    print(f"{rounds.total()} rounds, {kills.total()} kills, {len(faults)} faults")
    raise SystemExit(1 if faults else 0)


if __name__ == "__main__":
    main()
