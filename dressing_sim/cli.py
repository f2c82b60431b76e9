"""The command line: ``dressing-sim COMMAND``; every command has ``--help`` with an example."""

from __future__ import annotations

import json as json_format
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import tyro
from rich.console import Console
from rich.table import Table

from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.files import check_writable

if TYPE_CHECKING:
    from dressing_sim.episode import PathSource

# Simulation and robotics libraries are imported inside the commands: --help and errors in the
# arguments should not wait for them.


def evaluate(
    protocol: str = "paper",
    suite: str | None = None,
    policies: str | None = None,
    seed: int = 0,
    workers: int | None = None,
    out: Path = Path("results/evaluate"),
    json: bool = False,
) -> None:
    """Measure how often policies dress an arm in a posture that they were not shown.

    Demonstrations are recorded in the simulator, the policies learn from them, and each dresses
    every test posture once. Writes episodes.jsonl, summary.json and report.md.

    For example: dressing-sim evaluate

    Or: dressing-sim evaluate --suite random:20 --policies expert,tp-gmm --workers 4

    Or: dressing-sim evaluate --policies mypackage.policies:MyPolicy --out results/mine

    Args:
        protocol: which policies learn from which demonstrations.
        suite: test postures instead of the protocol's: a name, a JSON file, or random:N.
        policies: other policies than the protocol's, separated by commas: expert, default,
            tp-gmm, the name of an installed one, or module:Class.
        seed: of the operator's variability.
        workers: processes, as many as processors unless given; the results do not depend on it.
        out: folder for the results.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dataclasses import replace

    from dressing_sim.benchmark.progress import progress_bar
    from dressing_sim.benchmark.protocol import find_protocol
    from dressing_sim.benchmark.report import summarise, table, write_report
    from dressing_sim.benchmark.runner import process_pool, run_protocol
    from dressing_sim.episode import EpisodeConfig
    from dressing_sim.settings import to_plain

    chosen = find_protocol(protocol)
    if policies is not None:
        chosen = chosen.with_policies([name.strip() for name in policies.split(",")])
    if suite is not None:
        chosen = replace(chosen, suite=suite)
    workers = _processors() if workers is None else workers
    _positive("workers", workers)
    _seed(seed)
    check_writable(out / "report.md")
    config = EpisodeConfig()
    with progress_bar(Console(stderr=True)) as progress, process_pool(workers) as executor:
        results = run_protocol(chosen, executor, seed, config, progress)
    summary = summarise(chosen, results, {"seed": seed, "episode": to_plain(config)})
    write_report(out, chosen, results, summary, f"dressing-sim {shlex.join(sys.argv[1:])}".strip())
    if json:
        print(json_format.dumps(summary, indent=2))
    else:
        _print_table(table(summary))
        print(f"written to {out}/: report.md, summary.json, episodes.jsonl")


def demonstrate(
    suite: tyro.conf.Positional[str],
    out: Path = Path("demonstrations.h5"),
    seed: int = 0,
    json: bool = False,
) -> None:
    """Record the scripted operator on the postures of a suite, in an HDF5 file.

    For example: dressing-sim demonstrate case_a --out case_a.h5

    Or: dressing-sim demonstrate random:7:3 --seed 1 --out seven.h5

    Args:
        suite: postures to demonstrate on: a name, a JSON file, or random:N[:SEED].
        out: file to write.
        seed: of the operator's variability.
        json: print what was recorded as JSON.
    """
    from dressing_sim.benchmark.runner import posture_seed
    from dressing_sim.benchmark.suites import load_suite
    from dressing_sim.demonstration import save_demonstrations
    from dressing_sim.episode import demonstrate as record_one

    _seed(seed)
    check_writable(out)
    recorded, lines = [], []
    for posture in load_suite(suite):
        demonstration, outcome = record_one(posture, posture_seed(seed, posture))
        verdict = "success" if outcome.success else outcome.void or ", ".join(outcome.reasons)
        print(f"{posture.name}: {verdict}", file=sys.stderr)
        if demonstration is None or not outcome.success:
            raise DressingSimError(
                f"the demonstration on posture {posture.name!r} failed ({verdict}); nothing was "
                "written, choose another seed or posture"
            )
        recorded.append(demonstration)
        lines.append(
            {"posture": posture.to_dict(), "seed": demonstration.seed, **outcome.to_dict()}
        )
    save_demonstrations(out, recorded)
    if json:
        print(json_format.dumps({"file": str(out), "demonstrations": lines}, indent=2))
    else:
        print(f"{len(recorded)} demonstrations written to {out}")


def learn(
    demonstrations: tyro.conf.Positional[Path],
    policy: str = "default",
    out: Path = Path("policy.npz"),
    json: bool = False,
) -> None:
    """Learn a policy from recorded demonstrations and save it.

    For example: dressing-sim learn case_a.h5 --out case_a.npz

    Args:
        demonstrations: file that ``dressing-sim demonstrate`` wrote.
        policy: name of the policy.
        out: file to write.
        json: print what was learned as JSON.
    """
    from dressing_sim.benchmark.policies import make_policy
    from dressing_sim.demonstration import load_demonstrations
    from dressing_sim.learning.storage import Storable, save_model

    fresh = make_policy(policy)
    if not isinstance(fresh, Storable):
        raise InvalidInputError(f"policy {policy!r} cannot be saved; valid is one with state()")
    recorded = load_demonstrations(demonstrations)
    fitted = fresh.fit(recorded)
    save_model(fitted, out)
    if json:
        print(
            json_format.dumps(
                {"policy": policy, "n_demonstrations": len(recorded), "file": str(out)}
            )
        )
    else:
        print(f"{policy} learned from {len(recorded)} demonstrations, written to {out}")


def dress(
    posture: str,
    policy: str = "expert",
    seed: int = 0,
    video: Path | None = None,
    camera: str = "front",
    fps: int = 25,
    width: int = 640,
    height: int = 480,
    json: bool = False,
) -> None:
    """Dress one arm, and film it if wanted.

    For example: dressing-sim dress --posture bent40 --video bent40.mp4

    Or: dressing-sim dress --posture 70,30,40,50,female --policy case_a.npz

    Args:
        posture: name of a posture in a suite, or FLEXION,ABDUCTION,ROTATION,ELBOW[,SIZE] in
            degrees.
        policy: expert, or a file that ``dressing-sim learn`` wrote.
        seed: of the operator's variability.
        video: film to write: .mp4 or .gif.
        camera: front, close or above.
        fps: pictures a second.
        width: of a picture, in pixels.
        height: of a picture, in pixels.
        json: print the outcome as JSON.
    """
    from dressing_sim.benchmark.suites import find_posture
    from dressing_sim.episode import EpisodeConfig, record
    from dressing_sim.video import Film, check_format

    arm = find_posture(posture)
    _seed(seed)
    config = EpisodeConfig()
    for option, number in (("fps", fps), ("width", width), ("height", height)):
        _positive(option, number)
    film = Film(fps) if video is not None else None
    if video is not None:
        from dressing_sim.world.rendering import CAMERAS, gl_backend

        check_format(video)
        check_writable(video)
        if camera not in CAMERAS:
            raise InvalidInputError(f"unknown camera {camera!r}; valid is {', '.join(CAMERAS)}")
        gl_backend()  # without OpenGL, say so before simulating
    source = _source(policy)
    outcome = record(source, arm, seed, config, None if film is None else film.expose).outcome
    if film is not None and video is not None:
        film.write(video, arm, config.world, camera, width, height)
    if json:
        print(
            json_format.dumps(
                {"posture": arm.to_dict(), "policy": policy, **outcome.to_dict()}, indent=2
            )
        )
        return
    print(f"{arm.name}: {'success' if outcome.success else outcome.void or 'failure'}")
    for failure in outcome.failures:
        when = "" if failure.time is None else f" at {failure.time:.2f} s"
        print(f"  {failure.reason}{when}: {failure.detail}")
    for name, value in outcome.figures.items():
        print(f"  {name:18} {value:.3f}")
    if video is not None:
        print(f"film written to {video}")


def _source(policy: str) -> PathSource:
    from dressing_sim.benchmark.policies import EXPERT
    from dressing_sim.learning import Policy
    from dressing_sim.learning.storage import load_model
    from dressing_sim.operator import Operator

    if policy == EXPERT:
        return Operator()
    if not Path(policy).is_file():
        raise InvalidInputError(
            f"policy {policy!r}: no such file; valid is {EXPERT} or a file written by "
            "'dressing-sim learn'"
        )
    fitted = load_model(policy)
    if not isinstance(fitted, Policy):
        raise InvalidInputError(f"policy {policy}: holds a model that cannot generate a path")
    return fitted


def doctor(json: bool = False) -> None:
    """Check this installation: packages, robot, simulation, pictures.

    Exit code 1 if something that evaluation needs does not work.

    For example: dressing-sim doctor

    Args:
        json: print the findings as JSON.
    """
    from dataclasses import asdict

    from dressing_sim.doctor import examine

    findings = []
    for finding in examine():
        findings.append(finding)
        if not json:
            mark = "ok" if finding.ok else "FAILED" if finding.needed else "missing"
            print(f"{mark:8} {finding.name}: {finding.detail}", flush=True)
    if json:
        print(json_format.dumps([asdict(finding) for finding in findings], indent=2))
    if any(finding.needed and not finding.ok for finding in findings):
        raise SystemExit(1)


def _processors() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _positive(name: str, value: int) -> None:
    if value < 1:
        raise InvalidInputError(f"{name} is {value}, valid is 1 or more")


def _seed(value: int) -> None:
    if value < 0:
        raise InvalidInputError(f"seed is {value}, valid is 0 or more")


def _print_table(cells: Sequence[Sequence[str]]) -> None:
    heading, *body = cells
    grid = Table(*heading)
    for line in body:
        grid.add_row(*line)
    Console(width=None if sys.stdout.isatty() else 120).print(grid)


def _commands() -> dict[str, Any]:
    from dressing_sim.planar.command import planar

    return {
        "evaluate": evaluate,
        "demonstrate": demonstrate,
        "learn": learn,
        "dress": dress,
        "planar": planar,
        "doctor": doctor,
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command; an error that a user can mend is one line on standard error, exit code 2."""
    try:
        tyro.extras.subcommand_cli_from_dict(
            _commands(),
            prog="dressing-sim",
            description="A simulated dressing-robot benchmark.",
            args=arguments,
        )
    except DressingSimError as error:
        print(f"dressing-sim: {error}", file=sys.stderr)
        raise SystemExit(2) from None
    except BrokenPipeError:
        # Whoever read our output has had enough; do not complain at exit either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise SystemExit(141) from None
    except KeyboardInterrupt:
        print("dressing-sim: interrupted", file=sys.stderr)
        raise SystemExit(130) from None
