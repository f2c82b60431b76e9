"""Which bits this machine computes: what is common to processors, and a fingerprint of the rest.

Floating-point results repeat to the bit on one machine. From one kind of processor to another they
differ where a library chooses its code by what the processor can do: OpenBLAS by the processor's
name, numpy by its vector instructions, the C library's sin and exp by whether it has fused
multiply-add. Compiled loops of ours do not: numba multiplies and adds as it is written.

`common_environment` makes OpenBLAS and numpy choose what every x86-64 processor with AVX2 and FMA
has (nearly all since 2013), whatever else it can do; `fingerprint` says what came out.
"""

from __future__ import annotations

import hashlib
import math
import os
import platform
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

#: For OpenBLAS, the kernels of processors with AVX2 and FMA.
_BLAS = {"OPENBLAS_CORETYPE": "Haswell"}

#: For numpy, what goes beyond: names of numpy 2.4 and later, then of those before.
_AVX512 = {
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR "
    "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL"
}


def common_settings(flags: frozenset[str] | None = None) -> dict[str, str]:
    """Environment variables under which processors of different kinds compute the same bits.

    Libraries read them as they are loaded.

    Args:
        flags: What the processor can do, by its Linux names; of this one by default.

    Returns:
        None of them where they would do harm: without AVX2 and FMA, and beyond Linux on x86-64.
    """
    flags = _processor_flags() if flags is None else flags
    wanted: dict[str, str] = {}
    if {"avx2", "fma"} <= flags:
        wanted |= _BLAS
        # Where there is nothing to switch off numpy would warn.
        wanted |= _AVX512 if "avx512f" in flags else {}
    return wanted


def common_environment(flags: frozenset[str] | None = None) -> dict[str, str]:
    """Those of `common_settings` that are not set already: what a user has chosen stays."""
    wanted = common_settings(flags)
    return {name: value for name, value in wanted.items() if name not in os.environ}


def _processor_flags() -> frozenset[str]:
    if platform.machine() != "x86_64":
        return frozenset()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return frozenset()
    return frozenset(next((line for line in lines if line.startswith("flags")), "").split())


@contextmanager
def common_to_children() -> Iterator[None]:
    """Start processes in the `common_environment`; this one stays as it is."""
    added = common_environment()
    os.environ.update(added)
    try:
        yield
    finally:
        for name in added:
            del os.environ[name]


@cache
def numerics() -> Mapping[str, str]:
    """What this process computes with: plain values for a file.

    Returns:
        ``fingerprint``, and what a reader can look for when it differs: ``blas``, ``simd``,
        ``libm`` and ``machine``.
    """
    system, machine = platform.system(), platform.machine()
    return {
        "fingerprint": fingerprint(),
        "blas": _blas(),
        "simd": _simd(),
        "libm": " ".join(platform.libc_ver()).strip() or f"{system} {platform.release()}",
        "machine": f"{machine} {system}",
    }


def fingerprint() -> str:
    """A short hash of what a fixed set of computations gives here, about 20 ms.

    Products of the sizes that kinematics and learning have, a solution, factors, and elementary
    functions of numpy and of the C library. Compiled code of other packages has no choice by
    processor of its own but differs by architecture, which is hashed too. numba's is left out: it
    takes longer to load than all this, and its bits were the same for every target that was tried.
    """
    import numpy as np
    from threadpoolctl import threadpool_limits

    digest = hashlib.sha256(f"{platform.machine()} {sys.platform}".encode())
    rng = np.random.default_rng(2022)
    values = rng.uniform(0.0, 3.0, 2000)
    a, b, c = (rng.uniform(-1.0, 1.0, shape) for shape in ((6, 7), (400, 6), (41, 3)))
    rotation = b[:3, :3]
    definite = a @ a.T + np.eye(6)
    with threadpool_limits(limits=1):
        results = [
            *(rotation @ rotation, c @ rotation, c[0] @ rotation, b[:, 0] @ b[:, 1]),
            *(a.T @ a, b @ a, b.T @ b, definite @ b[0], np.convolve(c[:, 0], c[:15, 1])),
            *(np.linalg.solve(definite, b.T), np.linalg.inv(definite)),
            *(np.linalg.cholesky(definite), *np.linalg.svd(a), *np.linalg.eigh(definite)),
            *(np.sin(values), np.cos(values), np.tan(values), np.exp(values), np.log1p(values)),
            *(np.arctan2(values, values[::-1]), np.arccos(values / 3.0), values**3, values**-0.5),
            *(np.linalg.norm(c, axis=1), np.einsum("ij,ij->i", c, c), np.sum(values)),
        ]
    functions = (math.sin, math.cos, math.tan, math.atan, math.exp, math.log1p, math.sinh)
    results += [np.array([function(v) for v in values.tolist()]) for function in functions]
    for result in results:
        digest.update(np.ascontiguousarray(result, dtype="<f8").tobytes())
    return digest.hexdigest()[:12]


def _blas() -> str:
    import numpy as np  # noqa: F401  # loads its BLAS
    from threadpoolctl import threadpool_info

    found = [library for library in threadpool_info() if library["user_api"] == "blas"]
    if not found:
        return "unknown"
    # scipy may have one of its own, loaded or not; numpy's is always there.
    chosen = next((library for library in found if "numpy" in library["filepath"]), found[0])
    name, core = chosen["internal_api"], chosen.get("architecture", "")
    return f"{name} {chosen['version']} {core}".strip()


def _simd() -> str:
    """The vector instructions beyond its own build's that numpy found here."""
    import numpy as np

    found = np.show_config(mode="dicts") or {}
    extensions = found.get("SIMD Extensions", {})
    return " ".join(extensions.get("found") or extensions.get("baseline") or ["unknown"])


def unlike(one: Mapping[str, str], other: Mapping[str, str], here: str, there: str) -> str:
    """In which parts numerics differ, in one line; empty if their fingerprints are the same.

    Args:
        one: As of `numerics`.
        other: The like.
        here: What the first are called, as in ``blas X recorded, Y now``.
        there: What the second are called.
    """
    if one["fingerprint"] == other["fingerprint"]:
        return ""
    # The fingerprint comes first: it alone is named if all that a reader can look for is the same.
    told = [
        f"{name} {one.get(name, 'unknown')} {here}, {other.get(name, 'unknown')} {there}"
        for name in dict.fromkeys([*one, *other])
        if one.get(name) != other.get(name)
    ]
    return "; ".join(told[1:] or told)


def single_threaded(function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Any:
    """Call a function while linear algebra uses one thread: with more, bits can be others."""
    from threadpoolctl import threadpool_limits

    with threadpool_limits(limits=1):
        return function(*args, **kwargs)
