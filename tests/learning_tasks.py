"""Small made-up tasks for the tests of the learning library, and its reference data."""

import os
from pathlib import Path

import numpy as np
import pytest

from dressing_sim.learning import Frame, SyntheticDemonstration, rotation

REFERENCE = Path(
    os.environ.get("DRESSING_SIM_REFERENCE_DATA")
    or Path(__file__).resolve().parents[1] / ".." / "shared" / "data"
)
PLANAR_FILE = REFERENCE / "paper_planar.npz"

needs_reference = pytest.mark.skipif(
    not PLANAR_FILE.is_file(),
    reason=f"the paper's demonstrations are not in {REFERENCE} (DRESSING_SIM_REFERENCE_DATA)",
)


def reaching_situation(rng):
    """Two frames in space: where the movement starts and where it ends."""
    angles = rng.uniform(-0.5, 0.5, 3), rng.uniform(-0.5, 0.5, 3)
    start = Frame(rotation(angles[0]), rng.uniform(-0.1, 0.1, 3))
    end = Frame(rotation(angles[1]), np.array([0.5, 0.2, 0.3]) + rng.uniform(-0.1, 0.1, 3))
    return start, end


def reaching(frames, rng, samples=120, dt=0.05, wobble=0.004):
    """A reach that leaves along the start's x axis and comes in along the end's z axis."""
    start, end = frames
    corners = np.array(
        [start.b, start.to_world([0.15, 0, 0]), end.to_world([0, 0, 0.15]), end.b]
    ) + wobble * rng.standard_normal((4, 3))
    phase = np.linspace(0.0, 1.0, samples)[:, None]
    phase = phase**3 * (10 - 15 * phase + 6 * phase**2)
    # A cubic Bezier curve through the ends.
    path = (
        (1 - phase) ** 3 * corners[0]
        + 3 * (1 - phase) ** 2 * phase * corners[1]
        + 3 * (1 - phase) * phase**2 * corners[2]
        + phase**3 * corners[3]
    )
    return SyntheticDemonstration(path, dt, frames)


def reaching_demonstrations(count=4, seed=0, **settings):
    """Demonstrations of the reach in random situations."""
    rng = np.random.default_rng(seed)
    return [reaching(reaching_situation(rng), rng, **settings) for _ in range(count)]


def moved(demonstration, turn, shift):
    """The same demonstration in a world that is turned and then shifted."""
    return SyntheticDemonstration(
        demonstration.positions @ turn.T + shift,
        demonstration.dt,
        moved_frames(demonstration.frames, turn, shift),
    )


def moved_frames(frames, turn, shift):
    return tuple(Frame(turn @ frame.A, turn @ frame.b + shift) for frame in frames)


def rebased(demonstration, changes):
    """The same demonstration with each frame's coordinates changed: A -> A C."""
    return SyntheticDemonstration(
        demonstration.positions, demonstration.dt, rebased_frames(demonstration.frames, changes)
    )


def rebased_frames(frames, changes):
    return tuple(Frame(f.A @ change, f.b) for f, change in zip(frames, changes, strict=True))
