"""Inputs for `fuzz`: sound files and lines, and what may become of them."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from dressing_sim.episode.demonstration import Demonstration, save_demonstrations
from dressing_sim.episode.operator import Operator
from dressing_sim.learning.storage import save_model
from dressing_sim.path import policy_path
from dressing_sim.planar.generator import generate
from dressing_sim.policies.host import PolicyLimits
from dressing_sim.policies.hosted import hosted_policy
from dressing_sim.policies.registry import make_policy
from dressing_sim.suites.suites import load_suite

Rng = np.random.Generator

#: Values that somebody may type, or find in a file.
TEXTS = (
    *("", " ", "0", "-1", "1", "1.5", "nan", "inf", "1e308", "-1e9", "99999999999999999999"),
    *("true", "None", "abc", "a" * 5000, "\x1b[31m", "\0", "..", "/", "~", "%s", "{}", "'", '"'),
    *("random:5", "random:0", "random:-1", "case_a", "bent40", "tp-gmm", "tp-gmm?samples=1e8"),
    *("expert", "builtins:exit", "os:system", "--seed", "-", "--", "ä", "\udcff", "0,0,0,0"),
)

NUMBERS: tuple[Any, ...] = (
    *(0, -1, 1, 2, 10**30, 1e200, -1e200, 1e-300, float("nan"), float("inf"), 0.5, 10**6),
    *(None, True, False, "", "x", [], {}, [[]], [1, "a"], {"a": 1}),
)

#: Options by command whose errors show before anything long is done.
COMMANDS: Mapping[str, tuple[str, ...]] = {
    "learn": ("--policy", "--out", "--json"),
    "evaluate": ("--protocol", "--suite", "--policies", "--variation", "--seed", "--out"),
    "validate": ("--suite", "--postures", "--only", "--seed", "--out"),
    "thresholds": ("--suite", "--policies", "--seed", "--out"),
    "dress": ("--posture", "--policy", "--demonstrations", "--seed", "--video", "--fps"),
    "demonstrate": ("--out", "--seed"),
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
        """Demonstrations, a policy, planar demonstrations, a suite."""
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
        return cls({path.name: path.read_bytes() for path in folder.iterdir()})


def _demonstrations() -> list[Demonstration]:
    made = []
    for seed, posture in enumerate(load_suite("case_a")):
        start = posture.wrist + [0.0, 0.0, 0.12]
        path = Operator().path(posture, start, np.random.default_rng(seed))
        made.append(Demonstration(path, 0.02, posture, seed, np.zeros((len(path), 7))))
    return made


def mutated_line(rng: Rng, material: Material, folder: Path) -> list[str]:
    """A command line in a folder with mutated files; nothing that it asks for takes long."""
    for name, content in material.files.items():
        (folder / name).write_bytes(mutated_file(rng, name, content))
    (folder / "mine.txt").write_text("somebody's own")
    kind = int(rng.integers(6))
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
    return _random_line(rng)


def _random_line(rng: Rng) -> list[str]:
    command = str(rng.choice(list(COMMANDS)))
    line = [command]
    for _ in range(int(rng.integers(1, 5))):
        line += [str(rng.choice(COMMANDS[command]))] * bool(rng.uniform() < 0.9)
        line += [str(rng.choice(TEXTS))] * bool(rng.uniform() < 0.9)
    # What would be sound must not run for long.
    last = {"dress": "--posture", "demonstrate": "--nothing", "replay": "--nothing"}
    if command in ("evaluate", "validate", "thresholds"):
        return [*line, "--workers", "0"]
    if command == "planar":
        return [*line, *_SHORT]
    return [*line, last[command], "nobody"] if command in last else line


def mutated_file(rng: Rng, name: str, content: bytes) -> bytes:
    """A file's bytes, some of them changed, or its content changed where it has a structure."""
    if rng.uniform() < 0.4:
        return _mutated_bytes(rng, content)
    if name.endswith(".npz"):
        return _mutated_npz(rng, content)
    if name.endswith(".json"):
        return json.dumps(_mutated_json(rng, json.loads(content))).encode()
    return _mutated_h5(rng, content)


def _mutated_bytes(rng: Rng, content: bytes) -> bytes:
    place = int(rng.integers(len(content)))
    length = int(rng.integers(1, 200))
    ways: tuple[Callable[[], bytes], ...] = (
        lambda: content[:place],
        lambda: content[:place] + rng.bytes(length) + content[place + length :],
        lambda: content[:place] + rng.bytes(length) + content[place:],
        lambda: content[:place] + content[place + length :],
        lambda: b"",
        lambda: content * 2,
    )
    return ways[int(rng.integers(len(ways)))]()


def _mutated_array(rng: Rng, array: np.ndarray) -> np.ndarray:
    spoilt = array.astype(float, copy=True) if array.dtype.kind in "fiu" else array
    if spoilt.dtype.kind == "f" and spoilt.size:
        spoilt.flat[int(rng.integers(spoilt.size))] = rng.choice([np.nan, np.inf, 1e200, -1e9])
    ways: tuple[Callable[[], np.ndarray], ...] = (
        lambda: array.T,
        lambda: array[..., None],
        lambda: array.ravel(),
        lambda: array[:0] if array.ndim else array,
        lambda: array[:1] if array.ndim else array,
        lambda: array * 1000.0 if array.dtype.kind == "f" else array,
        lambda: array.astype(complex) + 1j if array.dtype.kind == "f" else array,
        lambda: array.astype(str),
        lambda: np.zeros(0),
        lambda: np.array(0.0),
        lambda: array[::-1] if array.ndim else array,
        lambda: spoilt,
    )
    return ways[int(rng.integers(len(ways)))]()


def _mutated_npz(rng: Rng, content: bytes) -> bytes:
    with np.load(io.BytesIO(content)) as archive:
        arrays = dict(archive)
    name = str(rng.choice(list(arrays)))
    if rng.uniform() < 0.2:
        del arrays[name]
    else:
        arrays[name] = _mutated_array(rng, arrays[name])
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def _mutated_json(rng: Rng, value: Any) -> Any:
    """The value with one thing in it replaced, removed or added."""
    if rng.uniform() < 0.15 or not isinstance(value, dict | list) or not value:
        return NUMBERS[int(rng.integers(len(NUMBERS)))]
    if isinstance(value, list):
        place = int(rng.integers(len(value)))
        return [*value[:place], _mutated_json(rng, value[place]), *value[place + 1 :]]
    key = str(rng.choice(list(value)))
    if rng.uniform() < 0.1:
        return {name: one for name, one in value.items() if name != key}
    if rng.uniform() < 0.1:
        return {**value, str(rng.choice(["x", "", "name", "version"])): 1}
    return {**value, key: _mutated_json(rng, value[key])}


def _mutated_h5(rng: Rng, content: bytes) -> bytes:
    stream = io.BytesIO(content)
    with h5py.File(stream, "r+") as file:
        group = file[str(rng.choice(list(file)))]
        if rng.uniform() < 0.5:
            name = str(rng.choice(list(group)))
            array = np.array(group[name])
            del group[name]
            changed = _mutated_array(rng, array)
            if rng.uniform() < 0.8 and changed.dtype.kind != "U":
                group[name] = changed
        else:
            holder = group if rng.uniform() < 0.8 else file
            name = str(rng.choice(list(holder.attrs)))
            del holder.attrs[name]
            if rng.uniform() < 0.8:
                text = json.dumps(NUMBERS[int(rng.integers(len(NUMBERS)))])
                holder.attrs[name] = [np.bytes_(text.encode()), 5, [1.0, 2.0]][rng.integers(3)]
    return stream.getvalue()


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
