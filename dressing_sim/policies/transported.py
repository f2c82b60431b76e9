"""Transport regression: demonstrations carried along with the arm, and what they agree on.

Of the two frames it makes the skeleton of the arm. Demonstrations are brought into phase, carried
to the arm that is to be dressed along landmarks of the skeletons, and combined by a regression on
how far the elbow is bent (`dressing_sim.learning.carried`). The answer keeps as clear of the
skeleton, phase by phase, as the demonstrations did, and begins where the gripper is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Self, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

from dressing_sim.arm import UP, up_across
from dressing_sim.checks import one_of, real_array, real_number, real_vector
from dressing_sim.config import check_kinds, from_plain, to_plain
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import DemonstrationLike, Frame
from dressing_sim.learning.carried import Answer, CarriedDemonstrations
from dressing_sim.learning.demonstrations import check_demonstrations
from dressing_sim.learning.registration import Phased, by_length, in_phase, moving
from dressing_sim.path import Path
from dressing_sim.policies.clearance import Clearances
from dressing_sim.policies.skeleton import Skeleton

#: A path that is still within this fraction of its length of an end has not begun, or has ended.
_STILL = 2e-3

#: Landmarks beyond the elbow.
_AHEAD = 3

#: Hyper-parameters that practice chooses.
ELBOW_OFFSETS = ("elbow_out", "elbow_along", "elbow_up")

Feature = Literal["bend", "sideways"]


@dataclass(frozen=True, slots=True)
class TransportConfig:
    """Hyper-parameters. Lengths are fractions of the demonstrated arms' mean length.

    Raises:
        InvalidInputError: A value that no policy can have.
    """

    slope_to_noise: float = 5.0
    """What is believed of the slope: how much carried demonstrations differ between a straight and
    a right-angled elbow, over how much they differ anyway."""
    feature: Feature = "bend"
    """What the slope is over: how far the elbow is bent, or how far it is bent sideways."""
    curvature: float = 1.0
    """Of the deviation alone: how far the relation to the feature may be from a straight line, over
    the standard deviation of the carried demonstrations."""
    length: float = 0.45
    """Over which the displacements of landmarks are alike."""
    landmark_noise: float = 0.05
    """How far a landmark may be missed, over how far landmarks are displaced."""
    height: float = 0.15
    """Of the landmarks over the bones, and over a straight elbow; a right-angled one is passed at
    its level."""
    ahead: float = 0.4
    """Of the farthest landmark beyond the elbow."""
    dip: float = 0.25
    """Which part of the forearm's slope from the upper arm landmarks beyond the elbow keep: where
    the elbow is the lowest point of the arm, the sleeve is led below it too."""
    stations: int = 5
    """Landmarks on each bone."""
    clearance: bool = True
    """Whether the path stays, phase by phase, between the demonstrations' least and largest
    distance from the skeleton."""
    hand: float = 0.2
    """How high above the fingertips the hand is that must keep clear of the arm too, sideways; zero
    for fingertips alone."""
    elbow_out: float = 0.0
    """How much farther out a path passes an elbow that is bent sideways at a right angle. This and
    the next two are not learned from demonstrations, but by practice."""
    elbow_along: float = 0.0
    """How much farther along the upper arm it passes an elbow bent at a right angle."""
    elbow_up: float = 0.0
    """How much higher it passes one."""
    phases: int = 100
    """Points of a path before the elbow, and after it."""
    warp_width: float = 0.05
    """Over which fraction of a path the alignment is smoothed."""

    def __post_init__(self) -> None:
        check_kinds(self, "policy")
        one_of(self.feature, "feature", get_args(Feature))
        for name in ("length", "landmark_noise", "warp_width"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise InvalidInputError(f"{name} is {getattr(self, name)}, valid is > 0")
        for name in ("slope_to_noise", "curvature", "height", "ahead", "dip", "hand"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise InvalidInputError(f"{name} is {getattr(self, name)}, valid is >= 0")
        for name in ELBOW_OFFSETS:
            if not abs(getattr(self, name)) < 1.0:
                raise InvalidInputError(f"{name} is {getattr(self, name)}, valid is -1 to 1")
        for name, least in (("stations", 2), ("phases", 10)):
            if not least <= getattr(self, name) <= 1000:
                raise InvalidInputError(
                    f"{name} is {getattr(self, name)}, valid is {least} to 1000"
                )

    def make(self, seed: int = 0) -> TransportPolicy:
        """A new policy, not yet fitted; nothing about it is random."""
        return TransportPolicy(self)


class TransportPolicy:
    """Dresses arms from demonstrations carried along with the skeleton.

    Args:
        config: Hyper-parameters.
    """

    def __init__(self, config: TransportConfig | None = None) -> None:
        self.config = config or TransportConfig()
        self._fitted: _Fitted | None = None

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Learn from one demonstration or more.

        Raises:
            InvalidInputError: None, frames that are not an arm's, or a path that does not pass the
                elbow.
        """
        checked = check_demonstrations(demonstrations)
        met = [Skeleton.of(one.frames) for one in checked]
        # Where the axes of a nearly straight arm meet says little of its bones.
        certain = np.array([1e-6 + np.sum(np.cross(s.forearm, s.upper_arm) ** 2) for s in met])
        bones = np.average([s.bones for s in met], axis=0, weights=certain)
        skeletons = [Skeleton.of(one.frames, bones) for one in checked]
        paths = [
            _by_phase(one, skeleton, self.config.phases, f"demonstration {number}")
            for number, (one, skeleton) in enumerate(zip(checked, skeletons, strict=True))
        ]
        places = np.array([[s.shoulder, s.elbow, s.wrist] for s in skeletons])
        starts = np.array([path.points[0] for path in paths])
        scale = float(bones.sum())
        landmarks = [
            _landmarks(s, start, self.config, scale)
            for s, start in zip(skeletons, starts, strict=True)
        ]
        phased = in_phase(
            paths,
            landmarks,
            self.config.length * scale,
            self.config.landmark_noise,
            self.config.warp_width,
        )
        points = np.stack([one.points for one in phased])
        times = np.stack([one.times for one in phased])
        dt = float(np.mean([one.dt for one in checked]))
        self._fitted = _Fitted.of(self.config, points, times, places, bones, dt)
        return self

    @property
    def bones(self) -> NDArray[np.float64]:
        """Mean lengths of the demonstrated upper arms and forearms, (2,) [m]."""
        return self._known().bones

    @property
    def clearances(self) -> Clearances:
        """How far from the skeleton the demonstrations were, phase by phase."""
        return self._known().clearances

    def generate(self, frames: Sequence[Frame], start: ArrayLike) -> Path:
        """A path for the situation of an arm.

        Args:
            frames: Of the shoulder and of the wrist.
            start: Where the gripper is, (3,), in the robot's base frame [m].
        """
        answer, dt = self.answer(frames, start), self._known().dt
        count = max(int(np.ceil(answer.times[-1] / dt)), 1)
        times = np.linspace(0.0, answer.times[-1], count + 1)
        return Path(PchipInterpolator(answer.times, answer.points)(times), times[1])

    def answer(self, frames: Sequence[Frame], start: ArrayLike) -> Answer:
        """The path of `generate` by phase, with its standard deviation.

        Args:
            frames: Of the shoulder and of the wrist.
            start: Where the gripper is, (3,), in the robot's base frame [m].
        """
        known, begin = self._known(), real_vector(start, 3, "start has", "m")
        skeleton = Skeleton.of(frames, known.bones)
        scale = float(known.bones.sum())
        landmarks = _landmarks(skeleton, begin, self.config, scale)
        answer = known.carried.answer(landmarks, getattr(skeleton, self.config.feature))
        points, deviation = answer.points, answer.deviation
        if self.config.clearance:
            points = known.clearances.kept(points, skeleton)
            # What is corrected was not known better than by the correction.
            corrected = np.sum((points - answer.points) ** 2, axis=1) / 3.0
            deviation = np.sqrt(deviation**2 + corrected)
        points = points + _at_the_elbow(skeleton, self.config, scale, len(points))
        return Answer(self._begun(points, begin), answer.times, deviation, answer.carried)

    def cleared(self, frames: Sequence[Frame], points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Any path (T, 3), kept as clear of an arm, phase by phase, as the demonstrations were.

        It is moved, but begins where it did. A path that does not pass the elbow has no phases and
        stays as it is.

        Args:
            frames: Of the shoulder and of the wrist.
            points: In the robot's base frame [m].
        """
        known = self._known()
        skeleton = Skeleton.of(frames, known.bones)
        cut = skeleton.passed(points)
        if cut is None:
            return points
        phased = by_length(points, 1.0, [cut], self.config.phases)  # its times are rows
        moved = self._begun(known.clearances.kept(phased.points, skeleton), points[0])
        offsets = moved - phased.points
        rows = np.arange(len(points))
        return points + np.column_stack([np.interp(rows, phased.times, o) for o in offsets.T])

    def _begun(
        self, points: NDArray[np.float64], begin: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """A path (N, 3) that begins elsewhere; it moves what is near, as a landmark does."""
        reach = self.config.length * float(self._known().bones.sum())
        distance = np.linalg.norm(points - points[0], axis=1) / reach
        return points + np.exp(-0.5 * distance**2)[:, None] * (begin - points[0])

    def state(self) -> tuple[dict[str, Any], dict[str, NDArray[np.float64]]]:
        """Settings and arrays, see `dressing_sim.learning.storage`."""
        known = self._known()
        arrays = {
            "points": known.carried.points,
            "times": known.carried.times,
            "places": known.places,
            "bones": known.bones,
        }
        return {"config": to_plain(self.config), "dt": known.dt}, arrays

    @classmethod
    def from_state(
        cls, settings: dict[str, Any], arrays: Mapping[str, NDArray[np.float64]]
    ) -> Self:
        """The policy that `state` came from."""
        policy = cls(from_plain(TransportConfig, settings["config"]))
        points, times, places, bones = (
            arrays[name] for name in ("points", "times", "places", "bones")
        )
        dt = real_number(settings["dt"], "dt", 0.0, above=True)
        policy._fitted = _Fitted.of(policy.config, points, times, places, bones, dt)
        return policy

    def _known(self) -> _Fitted:
        if self._fitted is None:
            raise InvalidInputError("the policy has not learned yet; valid is fit() first")
        return self._fitted


@dataclass(frozen=True, eq=False)
class _Fitted:
    """What was learned: demonstrations in phase, and the arms they were of."""

    carried: CarriedDemonstrations
    places: NDArray[np.float64]
    """Shoulder, elbow and wrist of each arm, (M, 3, 3) [m]."""
    bones: NDArray[np.float64]
    """Mean lengths of upper arm and forearm (2,) [m]."""
    clearances: Clearances
    dt: float

    @classmethod
    def of(
        cls,
        config: TransportConfig,
        points: NDArray[np.float64],
        times: NDArray[np.float64],
        places: NDArray[np.float64],
        bones: NDArray[np.float64],
        dt: float,
    ) -> _Fitted:
        real_array(places, (len(points), 3, 3), "the demonstrated arms have")
        real_array(bones, (2,), "the demonstrated bones have")
        scale = float(bones.sum())
        skeletons = [Skeleton(*place) for place in places]
        pairs = list(zip(skeletons, points, strict=True))
        carried = CarriedDemonstrations(
            points,
            times,
            np.stack([_landmarks(s, path[0], config, scale) for s, path in pairs]),
            np.array([getattr(s, config.feature) for s in skeletons]),
            config.length * scale,
            config.landmark_noise,
            config.slope_to_noise,
            config.curvature,
        )
        clearances = Clearances.of(skeletons, points, config.hand * scale * UP)
        return cls(carried, places, bones, clearances, dt)


def _by_phase(
    demonstration: DemonstrationLike, skeleton: Skeleton, phases: int, name: str
) -> Phased:
    """A demonstration before and after it passes the elbow."""
    positions = np.asarray(demonstration.positions)[moving(demonstration.positions, _STILL)]
    cut = skeleton.passed(positions)
    if cut is None:
        begun = "beyond" if (positions[0] - skeleton.elbow) @ skeleton.forearm > 0.0 else "before"
        raise InvalidInputError(
            f"{name} does not pass the elbow: it begins {begun} it and ends there; valid is a "
            "whole dressing, from the wrist to the shoulder"
        )
    return by_length(positions, demonstration.dt, [cut], phases)


def _at_the_elbow(
    skeleton: Skeleton, config: TransportConfig, scale: float, phases: int
) -> NDArray[np.float64]:
    """What practice adds to a path, (N, 3) [m]: most at the elbow, nothing at the ends.

    It grows with the bend, so that a straight arm, which has no side, is dressed as before.
    """
    upper_arm = skeleton.upper_arm
    up = up_across(upper_arm)
    across = np.cross(up, upper_arm)
    offset = (
        config.elbow_out * float(skeleton.forearm @ across) * across
        + config.elbow_along * skeleton.bend * upper_arm
        + config.elbow_up * skeleton.bend * up
    )
    phase = np.linspace(-1.0, 1.0, phases)
    return np.asarray(scale * (1.0 - phase**2)[:, None] ** 3 * offset)


def _landmarks(
    skeleton: Skeleton, start: NDArray[np.float64], config: TransportConfig, scale: float
) -> NDArray[np.float64]:
    """Landmarks of the arm and where the path begins, (K, 3) [m]."""
    ahead = config.ahead * scale * np.arange(1, _AHEAD + 1) / _AHEAD
    arm = skeleton.landmarks(config.height * scale, ahead, config.dip, config.stations)
    return np.concatenate([arm, start[None]])


POLICIES: Mapping[str, TransportConfig] = {"transport": TransportConfig()}
