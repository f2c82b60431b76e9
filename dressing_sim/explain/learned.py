"""What a policy has learned, and how its answer for one arm comes of it: as arrays, to be drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import DemonstrationLike, Frame, Policy, TrajectoryTPGMM
from dressing_sim.learning.augmented import AugmentedTPGMM
from dressing_sim.learning.demonstrations import in_frames
from dressing_sim.learning.density import GaussianMixture
from dressing_sim.learning.tpgmm import TPGMM
from dressing_sim.path import checked_path
from dressing_sim.policies.cleared import ClearPolicy
from dressing_sim.policies.hosted import Guarded
from dressing_sim.policies.situations import ArmPlanePolicy, in_arm_plane, in_arm_planes
from dressing_sim.policies.transported import TransportPolicy

Paths: TypeAlias = tuple[NDArray[np.float64], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Learned:
    """Mixtures of positions in the robot's base frame [m].

    Attributes:
        final: What the policy ends with.
        initial: What it learned from the expert's demonstrations alone, where Algorithm 1 went on.
    """

    final: GaussianMixture
    initial: GaussianMixture | None = None


@dataclass(frozen=True, slots=True, eq=False)
class FrameView:
    """What one frame has seen, laid over the frame of the arm that is asked for.

    Attributes:
        name: Of the frame.
        learned: Its mixture.
        experts: Paths (T, 3) that were shown, in the robot's base frame [m].
        synthetic: Those that Algorithm 1 made and kept.
        discarded: Those that it made and did not keep.
    """

    name: str
    learned: Learned
    experts: Paths = ()
    synthetic: Paths = ()
    discarded: Paths = ()


@dataclass(frozen=True, slots=True, eq=False)
class MixtureExplanation:
    """A TP-GMM and its answer for an arm.

    Attributes:
        joints: Shoulder, elbow and wrist of the arm (3, 3), in the robot's base frame [m].
        path: The answer (T, 3) [m].
        views: The frames, before their fusion.
        fused: The product of their mixtures (equation 5 of the paper).
    """

    joints: NDArray[np.float64]
    path: NDArray[np.float64]
    views: tuple[FrameView, ...]
    fused: Learned


@dataclass(frozen=True, slots=True, eq=False)
class TransportExplanation:
    """Carried demonstrations and what they agree on for an arm.

    Attributes:
        joints: Shoulder, elbow and wrist of the arm (3, 3), in the robot's base frame [m].
        path: The answer (N, 3) by phase [m]; half-way it passes the elbow.
        deviation: Its standard deviation (N,), of each coordinate [m].
        carried: The demonstrations (M, N, 3), carried to the arm [m].
    """

    joints: NDArray[np.float64]
    path: NDArray[np.float64]
    deviation: NDArray[np.float64]
    carried: NDArray[np.float64]


Explanation: TypeAlias = MixtureExplanation | TransportExplanation

#: Any policy that can be explained, without what surrounds it.
_Core: TypeAlias = TrajectoryTPGMM | AugmentedTPGMM | TransportPolicy


def check_explained(policy: Policy, name: str) -> None:
    """Raise InvalidInputError unless what a policy has learned can be drawn; fitted or not."""
    if not isinstance(_core(policy)[0], _Core):
        raise InvalidInputError(
            f"policy {name!r:.200} cannot be explained; valid is transport or one of the paper's: "
            "tp-gmm, tp-gmm-noise, tp-gmm-rf, tp-gmm-rf-noise"
        )


def explain(
    policy: Policy,
    name: str,
    posture: Posture,
    start: NDArray[np.float64],
    demonstrations: Sequence[DemonstrationLike] = (),
) -> Explanation:
    """What a fitted policy has learned, and its answer for an arm.

    Args:
        policy: Fitted.
        name: What it is called in errors.
        posture: The arm.
        start: Where the gripper is (3,), in the robot's base frame [m].
        demonstrations: What it was fitted to. With them Algorithm 1 runs once more, as of its
            candidates the policy keeps none; without them no path is known that was learned from.

    Raises:
        InvalidInputError: A policy of another kind, or one that gives no answer.
    """
    check_explained(policy, name)
    core, in_plane = _core(policy)
    frames: Sequence[Frame] = posture.frames()
    joints = np.stack([posture.shoulder, posture.elbow, posture.wrist])
    if isinstance(core, TransportPolicy):
        answer = core.answer(frames, start)
        return TransportExplanation(joints, answer.points, answer.deviation, answer.carried)
    path = checked_path(policy.generate(frames, start), name).positions
    seen = in_arm_plane(frames) if in_plane else frames
    shown = in_arm_planes(demonstrations) if in_plane else list(demonstrations)
    synthetic: list[DemonstrationLike] = []
    discarded: list[DemonstrationLike] = []
    model, initial = _core_model(core), None
    if isinstance(core, AugmentedTPGMM) and shown:
        result = core.augment(shown)
        assert isinstance(result.initial_policy, TrajectoryTPGMM)
        initial = result.initial_policy.model
        for candidate in result.history:
            if candidate.demonstration is not None:
                kept = synthetic if candidate.accepted else discarded
                kept.append(candidate.demonstration)
    names = ("shoulder", "wrist")
    views = tuple(
        FrameView(
            names[place],
            Learned(
                _from_frame(model, seen, place),
                None if initial is None else _from_frame(initial, seen, place),
            ),
            *(_laid_over(group, seen, place) for group in (shown, synthetic, discarded)),
        )
        for place in range(len(seen))
    )
    fused = Learned(_fused(model, seen), None if initial is None else _fused(initial, seen))
    return MixtureExplanation(joints, path, views, fused)


def _core(policy: object) -> tuple[object, bool]:
    """The policy inside what surrounds it, and whether it sees frames in the arm's plane."""
    in_plane = False
    while isinstance(policy, Guarded | ClearPolicy | ArmPlanePolicy):
        in_plane |= isinstance(policy, ArmPlanePolicy)
        policy = policy.policy
    return policy, in_plane


def _core_model(core: object) -> TPGMM:
    policy = core.policy if isinstance(core, AugmentedTPGMM) else core
    assert isinstance(policy, TrajectoryTPGMM)
    return policy.model


def _from_frame(model: TPGMM, frames: Sequence[Frame], place: int) -> GaussianMixture:
    """A frame's own components over positions, in a situation: mean A m + b, covariance A S A'."""
    model.fitted()
    mixture, frame = model.predictive, frames[place]
    assert mixture is not None
    n = frame.dimension
    means = frame.to_world(mixture.means[:, place, :n])
    covariances = frame.A @ mixture.covariances[:, place, :n, :n] @ frame.A.T
    return GaussianMixture(mixture.priors, means, covariances)


def _fused(model: TPGMM, frames: Sequence[Frame]) -> GaussianMixture:
    return model.in_situation(frames).marginal(frames[0].dimension)


def _laid_over(
    demonstrations: Sequence[DemonstrationLike], frames: Sequence[Frame], place: int
) -> Paths:
    """Paths as a frame saw them, seen from the same frame of another situation."""
    return tuple(
        frames[place].to_world(in_frames(np.asarray(one.positions), one.frames)[place])
        for one in demonstrations
    )
