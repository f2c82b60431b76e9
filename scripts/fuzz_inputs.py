"""Inputs for `fuzz`: sound files and lines, and what may become of them."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from fuzz_mutations import NUMBERS, TEXTS, Rng, mutated_file

from dressing_sim.datasets.robomimic_files import write_robomimic
from dressing_sim.episode.demonstration import Demonstration, save_demonstrations
from dressing_sim.episode.operator import Operator
from dressing_sim.learning.storage import save_model
from dressing_sim.path import policy_path
from dressing_sim.planar.generator import generate
from dressing_sim.policies.host import PolicyLimits
from dressing_sim.policies.hosted import hosted_policy
from dressing_sim.policies.registry import make_policy
from dressing_sim.suites.suites import load_suite

#: Options by command whose errors show before anything long is done.
COMMANDS: Mapping[str, tuple[str, ...]] = {
    "learn": ("--policy", "--out", "--json"),
    "import": ("--out", "--dt", "--turn-deg", "--max-gap", "--person", "--topics.wrist"),
    "export": ("--to", "--out", "--json"),
    "evaluate": (
        *("--protocol", "--suite", "--policies", "--variation", "--seed", "--out"),
        *("--garment", "--person"),
    ),
    "validate": ("--suite", "--postures", "--settings", "--seed", "--out"),
    "thresholds": ("--suite", "--policies", "--seed", "--out"),
    "tune": ("--seed", "--workers"),
    "practise": ("--demonstrations", "--postures", "--population", "--seed", "--workers"),
    "confidence": ("--out", "--workers"),
    "dress": (
        *("--posture", "--policy", "--demonstrations", "--seed", "--video", "--fps"),
        *("--garment", "--person"),
    ),
    "demonstrate": ("--out", "--seed", "--garment", "--person"),
    "replay": ("--video", "--camera", "--fps", "--width"),
    "planar": ("--demos", "--validation", "--components", "--runs", "--snr-db", "--out"),
}


#: What a planar study does last, so that it ends soon.
_SHORT = ("--runs", "1", "--method", "noise", "--max-iterations", "1")


@dataclass(frozen=True)
class Material:
    """Sound files: their bytes by name."""

    files: Mapping[str, bytes]

    @classmethod
    def make(cls, folder: Path) -> Material:
        """Demonstrations, a policy, planar demonstrations, a suite, recordings, measurements."""
        recorded = _demonstrations()
        save_demonstrations(folder / "d.h5", recorded)
        save_model(make_policy("tp-gmm").fit(recorded), folder / "p.npz")  # type: ignore[arg-type]
        data = generate(0)
        arrays = {
            "t": 0.01 * np.arange(1, len(data.training[0].positions) + 1),
            "xy": np.array([d.positions for d in data.training]),
            "A": np.array([[f.A for f in d.frames] for d in data.training]),
            "b": np.array([[f.b for f in d.frames] for d in data.training]),
        }
        np.savez(folder / "planar.npz", **arrays)  # type: ignore[arg-type]
        suite = {"postures": [posture.to_dict() for posture in load_suite("case_a")]}
        (folder / "suite.json").write_text(json.dumps(suite), encoding="utf-8")
        _recordings(folder, recorded[0])
        write_robomimic(folder / "r.hdf5", recorded, lambda *_: None)
        for name, text in MEASURED.items():
            (folder / name).write_text(text, encoding="utf-8")
        return cls({path.name: path.read_bytes() for path in folder.iterdir()})


def _demonstrations() -> list[Demonstration]:
    made = []
    for seed, posture in enumerate(load_suite("case_a")):
        start = posture.wrist + [0.0, 0.0, 0.12]
        path = Operator().path(posture, start, np.random.default_rng(seed))
        made.append(Demonstration(path, 0.02, posture, seed, np.zeros((len(path), 7))))
    return made


#: A person and a garment by file.
MEASURED: Mapping[str, str] = {
    "person.toml": "name = 'Ada'\nsex = 'female'\nheight_m = 1.52\n"
    "forearm_circumference_m = 0.24\n[joints]\nupper_arm_length_m = 0.25\n",
    "garment.toml": "sleeve_length_m = 0.22\narmhole_m = 0.54\nopening_m = 0.44\n"
    "[fabric]\nlike = 'jersey'\nfriction_coefficient = 0.5\n",
}


def _recordings(folder: Path, demonstration: Demonstration) -> None:
    """The demonstration as a lab would write it, in both kinds of table."""
    posture, rows = demonstration.posture, demonstration.positions[::5]
    arrays = {"time_s": 0.1 * np.arange(len(rows)), "gripper_m": rows}
    arrays |= {f"{one}_m": getattr(posture, one) for one in ("shoulder", "elbow", "wrist")}
    # numpy's types take any keyword for its own `allow_pickle`.
    np.savez(folder / "lab.npz", **arrays)  # type: ignore[arg-type]
    names, parts = ["time_s"], [arrays["time_s"][:, None]]
    for name in ("gripper", "shoulder", "elbow", "wrist"):
        names += [f"{name}_{axis}_m" for axis in "xyz"]
        parts.append(np.broadcast_to(arrays[f"{name}_m"], (len(rows), 3)))
    lines = [",".join(f"{one:.6g}" for one in row) for row in np.hstack(parts)]
    (folder / "lab.csv").write_text("\n".join([",".join(names), *lines]), encoding="utf-8")


def mutated_line(rng: Rng, material: Material, folder: Path) -> list[str]:
    """A command line in a folder with mutated files; nothing that it asks for takes long."""
    for name, content in material.files.items():
        (folder / name).write_bytes(mutated_file(rng, name, content))
    (folder / "mine.txt").write_text("somebody's own")
    kind = int(rng.integers(10))
    if kind == 0:
        return ["learn", "d.h5", "--out", "out.npz"]
    if kind == 1:
        return ["dress", "--posture", "nobody", "--policy", "p.npz"]
    if kind == 2:
        line = ["planar", "--demos", "planar.npz", "--components", "2", *_SHORT]
        # Figures take longer than all else.
        return [*line, "--out", "out"] if rng.uniform() < 0.03 else line
    if kind == 3:
        return ["evaluate", "--suite", "suite.json", "--workers", "0", "--out", "out"]
    if kind in (4, 5):
        source = str(rng.choice(["lab.csv", "lab.npz", "r.hdf5"]))
        trim = ["--trim-pauses"] * int(rng.integers(2))
        return ["import", source, *trim, "--out", "out.h5"]
    if kind == 6:
        return ["export", "d.h5", "--to", "robomimic", "--out", "out.hdf5"]
    if kind == 7:
        worn = ["--garment", "garment.toml", "--person", "person.toml"]
        return ["dress", "--posture", "bent40", *worn, "--policy", "nobody"]
    return _random_line(rng)


def _random_line(rng: Rng) -> list[str]:
    command = str(rng.choice(list(COMMANDS)))
    line = [command]
    for _ in range(int(rng.integers(1, 5))):
        line += [str(rng.choice(COMMANDS[command]))] * bool(rng.uniform() < 0.9)
        line += [str(rng.choice(TEXTS))] * bool(rng.uniform() < 0.9)
    # What would be sound must not run for long.
    last = {"dress": "--posture", "demonstrate": "--nothing", "replay": "--nothing"}
    if command in ("evaluate", "validate", "thresholds", "tune", "practise", "confidence"):
        return [*line, "--workers", "0"]
    if command == "planar":
        return [*line, *_SHORT]
    return [*line, last[command], "nobody"] if command in last else line


def mutated_policy(rng: Rng) -> str:
    """The name of a policy that does one of many things."""
    does = int(rng.integers(len(ANSWERS)))
    return f"fuzz_inputs:Odd?does={does}&where={rng.choice(['fit', 'generate'])}"


class _Answers:
    """Asks policies for a path, in one process after the other."""

    limits = PolicyLimits(fit_time=5.0, generate_time=2.0, memory=1.0)

    def answer(self, name: str) -> None:
        """Let it learn, and ask it."""
        posture = load_suite("case_a")[0]
        policy = hosted_policy(name, 0, self.limits).fit(_demonstrations()[:1])
        policy_path(policy, posture, posture.wrist, 0, 0.05, 60.0)

    def close(self) -> None:
        """End the last process."""
        from dressing_sim.policies.hosted import _host

        _host.cache_clear()


POLICIES = _Answers()


def _endless() -> Any:
    while True:
        pass


def _exit() -> Any:
    raise SystemExit(5)


def _die() -> Any:
    import os

    os._exit(9)


#: What a policy may do or return.
ANSWERS: tuple[Callable[[], Any], ...] = (
    *(lambda value=value: value for value in NUMBERS),
    *(
        lambda shape=shape, fill=fill: np.full(shape, fill)
        for shape in ((10, 3), (3, 10), (1, 3), (0, 3), (10,), (2, 2, 3), ())
        for fill in (np.nan, 0.3, 1e200, 1j, "x")
    ),
    lambda: np.ma.masked_equal(np.ones((10, 3)), 1.0),
    lambda: (one for one in range(3)),
    lambda: object(),
    lambda: 1 / 0,
    lambda: dict[str, int]()["nothing"],
    lambda: np.ones((10**6, 10**6)),
    _exit,
    _die,
    _endless,
)


class Odd:
    """A policy that does what its number says, in `fit` or in `generate`."""

    def __init__(self, does: int = 0, where: str = "generate") -> None:
        self.does, self.where = does, where

    def fit(self, demonstrations: Any) -> Any:
        """Learn nothing."""
        return ANSWERS[self.does]() if self.where == "fit" else self

    def generate(self, frames: Any, start: Any) -> Any:
        """An answer, or none."""
        return ANSWERS[self.does]()
