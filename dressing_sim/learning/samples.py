"""Demonstrations as a mixture's samples, seen from each frame: (P, D, N), see ``tpgmm``."""

from collections.abc import Sequence

import numpy as np

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.demonstrations import DemonstrationLike, in_frames, resample
from dressing_sim.learning.frame import FloatArray


def time_samples(demonstration: DemonstrationLike, time_scale: float) -> FloatArray:
    """[t, x] of each sample, t the time in [s] times ``time_scale``: (P, 1 + p, N)."""
    local = in_frames(np.asarray(demonstration.positions), demonstration.frames)
    times = np.arange(local.shape[1]) * (demonstration.dt * time_scale)
    column = np.broadcast_to(times[None, :, None], (*local.shape[:2], 1))
    return np.concatenate([column, local], axis=2).transpose(0, 2, 1)


def trajectory_samples(demonstration: DemonstrationLike, step_time: float) -> FloatArray:
    """[x, dx] of each sample but the last, ``step_time`` [s] apart: (P, 2 p, N)."""
    path = resample(np.asarray(demonstration.positions), demonstration.dt, step_time)
    steps = np.diff(path, axis=0)
    views = []
    for frame in demonstration.frames:
        local = frame.to_local(path[:-1])
        views.append(np.concatenate([local, frame.displacements_to_local(steps)], axis=1).T)
    return np.stack(views)


def common_step_time(demonstrations: Sequence[DemonstrationLike]) -> float:
    """The sampling time of all demonstrations in [s].

    Raises:
        InvalidInputError: they have different ones.
    """
    step_times = {float(demonstration.dt) for demonstration in demonstrations}
    if max(step_times) - min(step_times) > 1e-9 * max(step_times):
        raise InvalidInputError(
            f"the demonstrations have different dt {sorted(step_times)}: pass dt="
        )
    return max(step_times)
