"""What may become of a sound file: bytes, numbers, words and structure, changed at random."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable
from typing import Any

import h5py
import numpy as np

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


def mutated_file(rng: Rng, name: str, content: bytes) -> bytes:
    """A file's bytes, some of them changed, or its content changed where it has a structure."""
    if rng.uniform() < 0.4:
        return _mutated_bytes(rng, content)
    if name.endswith(".npz"):
        return _mutated_npz(rng, content)
    if name.endswith((".toml", ".csv")):
        return _mutated_text(rng, content)
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


def _mutated_text(rng: Rng, content: bytes) -> bytes:
    """A word of a text replaced, taken out or doubled."""
    words = re.split(rb"([\s,=]+)", content)
    place = int(rng.integers(len(words)))
    other = str(rng.choice([*TEXTS, *map(str, NUMBERS)])).encode("utf-8", "surrogateescape")
    ways = ([other], [], [words[place]] * 2, [words[int(rng.integers(len(words)))]])
    return b"".join([*words[:place], *ways[int(rng.integers(len(ways)))], *words[place + 1 :]])


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
        while rng.uniform() < 0.8:
            inner = [one for one in group.values() if isinstance(one, h5py.Group)]
            if not inner:
                break
            group = inner[int(rng.integers(len(inner)))]
        arrays = [name for name in group if isinstance(group[name], h5py.Dataset)]
        if arrays and (rng.uniform() < 0.5 or not group.attrs):
            name = str(rng.choice(arrays))
            array = np.array(group[name])
            del group[name]
            changed = _mutated_array(rng, array)
            if rng.uniform() < 0.8 and changed.dtype.kind != "U":
                group[name] = changed
        else:
            holder = group if rng.uniform() < 0.8 or not file.attrs else file
            name = str(rng.choice(list(holder.attrs)))
            del holder.attrs[name]
            if rng.uniform() < 0.8:
                text = json.dumps(NUMBERS[int(rng.integers(len(NUMBERS)))])
                holder.attrs[name] = [np.bytes_(text.encode()), 5, [1.0, 2.0]][rng.integers(3)]
    return stream.getvalue()
