"""Checks of an installation, each with what to do if it fails."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from dressing_sim.errors import DressingSimError
from dressing_sim.numerics import common_settings, numerics
from dressing_sim.provenance import versions
from dressing_sim.system import processors


@dataclass(frozen=True, slots=True)
class Finding:
    """Result of one check.

    Attributes:
        name: What was checked.
        ok: Whether it works.
        detail: What was found, or what to do.
        needed: Whether evaluation needs it; pictures alone do not make an installation broken.
    """

    name: str
    ok: bool
    detail: str
    needed: bool = True


def examine() -> Iterator[Finding]:
    """Run all checks, one after the other."""
    yield Finding("python", sys.version_info >= (3, 11), platform.python_version())
    yield _check("packages", lambda: ", ".join(f"{k} {v}" for k, v in versions().items()))
    yield _check("numerics", _numerics)
    yield _check("compiled loops", _compiled)
    yield _check("robot description", _robot)
    yield _check("simulation", _simulation)
    yield _check("suites", _suites)
    yield from _rendering()
    yield Finding("processors", True, f"{processors()}", needed=False)


def _check(name: str, work: Callable[[], str]) -> Finding:
    try:
        return Finding(name, True, work())
    except Exception as error:  # a doctor reports whatever is wrong and goes on
        return Finding(name, False, f"{type(error).__name__}: {error}")


def _numerics() -> str:
    told = ", ".join(f"{name} {value}" for name, value in numerics().items())
    apart = " ".join(f"{name}='{value}'" for name, value in common_settings().items())
    return f"{told}; as on other processors with: {apart}" if apart else told


def _compiled() -> str:
    from dressing_sim.learning import dtw_distance

    # Two points a metre apart of two: the first pair counts once, the step to the next twice,
    # and the sum is of four points.
    distance = dtw_distance(np.zeros((2, 3)), np.eye(1, 3).repeat(2, axis=0))
    if not np.isclose(distance, 0.75):
        raise DressingSimError(f"a distance of 0.75 comes out as {distance:g}; reinstall numba")
    return "work"


def _robot() -> str:
    from dressing_sim.control import RobotKinematics
    from dressing_sim.world.description import urdf_path
    from dressing_sim.world.robot import PANDA

    position, _ = RobotKinematics().tcp_pose(np.array(PANDA.home))
    return f"{urdf_path()}, gripper at rest at {position.round(3).tolist()} m"


def _simulation() -> str:
    from dressing_sim.episode.dressing import Dressing
    from dressing_sim.suites.suites import load_suite

    dressing = Dressing(load_suite("paper5")[0])
    dressing.reset()
    if dressing.invalid is not None:
        raise DressingSimError(dressing.invalid)
    return f"the sleeve has settled in {dressing.world.time:.2f} s of simulated time"


def _suites() -> str:
    from dressing_sim.suites.suites import load_suite, suite_names

    return ", ".join(f"{name} ({len(load_suite(name))})" for name in suite_names())


def _rendering() -> Iterator[Finding]:
    from dressing_sim.pictures.rendering import BACKENDS, INSTALL_HINT, probe

    faults = {backend: probe(backend) for backend in BACKENDS}
    for backend, fault in faults.items():
        yield Finding(f"pictures through {backend}", fault is None, fault or "works", needed=False)
    wanted = os.environ.get("MUJOCO_GL", "").lower()
    if faults.get(wanted):
        told = f"MUJOCO_GL={wanted}, which does not work here; unset it"
        yield Finding("pictures", False, told, needed=False)
    elif all(faults.values()):
        yield Finding("pictures", False, INSTALL_HINT, needed=False)
