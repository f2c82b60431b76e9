"""Position and orientation over time: a time-based TP-GMM on R^3 x S3."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import NoneType
from typing import Protocol, Self

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import (
    LARGEST,
    of_kind,
    real_array,
    real_number,
    shown,
    truth_value,
    whole_number,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import quaternions
from dressing_sim.learning.demonstrations import (
    DemonstrationLike,
    SyntheticDemonstration,
    check_demonstrations,
    duration,
)
from dressing_sim.learning.em import EMOptions, EMRecord
from dressing_sim.learning.frame import FloatArray, Frame, situation
from dressing_sim.learning.motion import minimum_jerk
from dressing_sim.learning.pose_gaussians import PoseGaussians, exp, log, seen_from
from dressing_sim.learning.pose_mixture import PoseMixture, fit_mixture

#: Over this share of a path the offset of its start fades away, as in ``TimeTPGMM``.
_BLEND = 0.25


class PoseDemonstrationLike(DemonstrationLike, Protocol):
    """A demonstration in space with orientations; `dressing_sim.Demonstration` may be one."""

    @property
    def orientations(self) -> FloatArray | None:
        """(T, 4) unit quaternions x, y, z, w in world coordinates; their signs do not matter."""


@dataclass(frozen=True, eq=False)
class PoseDemonstration(SyntheticDemonstration):
    """A path of poses with its situation.

    Attributes:
        orientations: (T, 4) unit quaternions x, y, z, w in world coordinates.
    """

    orientations: FloatArray


@dataclass(frozen=True, eq=False)
class PosePath:
    """A generated path.

    Attributes:
        positions: (N, 3) in world coordinates.
        orientations: (N, 4) unit quaternions x, y, z, w; the sign changes nowhere along the path.
        dt: Time between two rows [s].
    """

    positions: FloatArray
    orientations: FloatArray
    dt: float


class TimePoseTPGMM:
    """A path of poses as a function of phase, from frames that turn and shift.

    Each demonstration counts from phase 0 to 1 of its own duration. A mixture over
    [phase, x, q] is learned in all frames (see `pose_mixture`); in a new situation each frame's
    regression moves to the world, where the frames' Gaussians are multiplied (`pose_gaussians`).

    Args:
        n_components: K.
        floor: Added to the variances of phase and position, as a fraction of the data's in the
            frame at hand, so that the unit of length does not matter.
        angle_floor: Added to the variances of the orientation [rad^2].
        coupled: Whether what a frame says of the position has a say in the orientation, and the
            other way round, when the frames' Gaussians are multiplied. Covariances between the two
            are the source's; from few demonstrations they are chance.
        samples: N, of a path, and of each demonstration once resampled.
        options: When expectation-maximisation stops.

    Attributes:
        dt: Time between two rows of a path [s], once fitted.
        mixture: The `PoseMixture`, once fitted.
        record: How expectation-maximisation went, once fitted.

    Raises:
        InvalidInputError: A setting out of range.

    Source: Zeestraten et al. (2017), doi:10.1109/LRA.2017.2657001, whose frames act on poses from
    the left as here. Phase instead of time, the floors, ``coupled=False`` and the blend from a
    given start are choices of this library.
    """

    def __init__(
        self,
        n_components: int = 6,
        *,
        floor: float = 1e-3,
        angle_floor: float = 1e-4,
        coupled: bool = False,
        samples: int = 100,
        options: EMOptions | None = None,
    ) -> None:
        self.n_components = whole_number(n_components, "n_components", 1, 1000)
        self.floor = real_number(floor, "floor", 0.0, LARGEST, above=True)
        self.angle_floor = real_number(angle_floor, "angle_floor", 0.0, LARGEST, above=True)
        truth_value(coupled, "coupled")
        self.coupled = coupled
        self.samples = whole_number(samples, "samples", 3, 100_000)
        of_kind(options, (EMOptions, NoneType), "options", "EMOptions or None")
        self.options = options
        self.dt: float | None = None
        self.mixture: PoseMixture | None = None
        self.record: EMRecord | None = None

    def fit(self, demonstrations: Sequence[PoseDemonstrationLike]) -> Self:
        """Learn from demonstrations of any lengths and return the model itself.

        Raises:
            InvalidInputError: Demonstrations that cannot be learned from, that have no
                orientations, or frames that are more than rotations and shifts in space.
        """
        checked = check_demonstrations(demonstrations)
        parts = [self._samples(one, index) for index, one in enumerate(checked)]
        data = np.concatenate(parts, axis=1)
        variances = data[..., :4].var(axis=1)
        floor = np.zeros((len(data), 7, 7))
        floor[:, 0, 0] = self.floor * variances[:, 0]
        floor[:, [1, 2, 3], [1, 2, 3]] = self.floor * variances[:, 1:].mean(axis=1, keepdims=True)
        floor[:, [4, 5, 6], [4, 5, 6]] = self.angle_floor
        self.mixture, self.record = fit_mixture(data, self.n_components, floor, self.options)
        self.dt = float(np.mean([duration(one) for one in checked])) / (self.samples - 1)
        return self

    def _samples(self, demonstration: DemonstrationLike, index: int) -> FloatArray:
        """[phase, x, q] of a demonstration in each frame, (P, N, 8)."""
        name = f"demonstration {index}"
        positions = real_array(demonstration.positions, ("T", 3), f"{name} has positions of")
        turned = getattr(demonstration, "orientations", None)
        if turned is None:
            raise InvalidInputError(f"{name} has no orientations, valid are (T, 4) quaternions")
        turned = quaternions.unit(turned, f"{name}: orientations")
        if turned.shape != (len(positions), 4):
            raise InvalidInputError(
                f"{name} has orientations of shape {turned.shape}, valid is one a position: "
                f"({len(positions)}, 4)"
            )
        rows = np.linspace(0.0, len(positions) - 1.0, self.samples)
        own = np.arange(len(positions))
        moved = np.stack([np.interp(rows, own, column) for column in positions.T], axis=1)
        poses = np.concatenate([moved, quaternions.interpolated(turned, rows)], axis=1)
        local = np.stack([seen_from(frame, poses) for frame in demonstration.frames])
        phase = np.broadcast_to(self._phase[None, :, None], (*local.shape[:2], 1))
        return np.concatenate([phase, local], axis=2)

    @property
    def _phase(self) -> FloatArray:
        return np.linspace(0.0, 1.0, self.samples)

    def gaussians(self, frames: Sequence[Frame]) -> PoseGaussians:
        """Where the path is and how sure the model is: means (N, 7), covariances (N, 6, 6).

        Positions and rotations x, y, z, w in world coordinates; the covariance of the rotations is
        in axes of the body [rad^2].

        Raises:
            InvalidInputError: Not fitted, or another number or kind of frames.
        """
        if self.mixture is None:
            raise InvalidInputError("the model has not been fitted: call fit(demonstrations) first")
        asked = situation(frames)
        if len(asked) != self.mixture.means.shape[1]:
            raise InvalidInputError(
                f"the situation has {len(asked)} frames, valid is as many as learned from: "
                f"{self.mixture.means.shape[1]}"
            )
        seen = self.mixture.over_time(self._phase)
        return (seen if self.coupled else seen.uncoupled()).in_world(asked).product()

    def generate(self, frames: Sequence[Frame], start: ArrayLike | None = None) -> PosePath:
        """The path for a situation.

        Args:
            frames: P frames, as in the demonstrations.
            start: Pose (7,) where the path begins, position and quaternion; what it is off the
                model's fades by a minimum-jerk blend. None begins where the model does.

        Raises:
            InvalidInputError: As for `gaussians`, or a start that is no pose.
        """
        poses = self.gaussians(frames).means
        assert self.dt is not None
        if start is not None:
            begin = real_array(start, (7,), f"start is {shown(start)}, a pose has")
            begin = np.concatenate([begin[:3], quaternions.unit(begin[3:], "start")])
            fade = 1.0 - minimum_jerk(self._phase / _BLEND)
            poses = exp(poses, fade[:, None] * log(poses[0], begin))
        return PosePath(poses[:, :3], quaternions.continuous(poses[:, 3:]), self.dt)
