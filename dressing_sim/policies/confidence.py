"""How likely a path is to dress the arm, of what a policy may see: frames, path, demonstrations.

A judge is a logistic regression on `FEATURES`, calibrated on episodes of training postures by
``dressing-sim confidence``. Nothing in it is of the simulator, nor of how the path was made.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as File
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.archives import read_strict_json
from dressing_sim.arm import UP, Vector
from dressing_sim.checks import of_kind, real_number, real_vector, shown, whole_number
from dressing_sim.errors import Abstained, InvalidInputError
from dressing_sim.files import write_file
from dressing_sim.inputs import fit, inputs_of
from dressing_sim.learning import DemonstrationLike, Frame, Policy
from dressing_sim.learning.calibration import Logistic
from dressing_sim.learning.policy import Inputs
from dressing_sim.learning.registration import by_length
from dressing_sim.path import REACH, Path, checked_path, seed_argument
from dressing_sim.policies.skeleton import Skeleton
from dressing_sim.policies.transported import TransportPolicy

#: Where the arm of the robot begins: the second joint of the Panda, over its base [m].
_ROBOT_SHOULDER = np.array([0.0, 0.0, 0.333])

#: What a judge looks at, and what each is. Lengths are fractions of the demonstrated arm's.
FEATURES: Mapping[str, str] = {
    "bend": "sine of the elbow angle",
    "sideways": "how far the elbow is bent sideways",
    "novelty": "distance of the arm's pose from the nearest demonstrated one",
    "deviation": "largest standard deviation of the demonstrations carried to this arm",
    "disagreement": "mean distance of the path from what carried demonstrations agree on",
    "shortfall": "by how much the path is nearer to the arm than any demonstration was, at most",
    "hand_shortfall": "the same of the hand above the fingertips",
    "passes": "whether the path passes the elbow at all",
    "end_distance": "distance of the path's end from the shoulder",
    "end_height": "height of the path's end over the shoulder",
    "reach": "least distance of the path from where the robot cannot reach",
}


def pose_of(skeleton: Skeleton) -> NDArray[np.float64]:
    """Directions of an arm's bones, (6,), that are the same wherever it is and faces.

    Unit vectors from the shoulder to the elbow and on to the wrist, turned about the vertical until
    the first is in the plane of x and z; of an upright upper arm, the second.
    """
    upper, fore = -skeleton.upper_arm, -skeleton.forearm
    level = next((v for v in (upper, fore) if np.hypot(v[0], v[1]) > 1e-6), np.array([1.0, 0, 0]))
    x = np.array([level[0], level[1], 0.0]) / np.hypot(level[0], level[1])
    axes = np.stack([x, np.cross(UP, x), UP])
    return np.concatenate([axes @ upper, axes @ fore])


class PathFeatures:
    """Tells what a judge looks at, of any path for any arm.

    Args:
        demonstrations: What the policy learned from.

    Raises:
        InvalidInputError: One does not pass the elbow, or is of no arm.
    """

    def __init__(self, demonstrations: Sequence[DemonstrationLike]) -> None:
        self._measure = TransportPolicy().fit(demonstrations)
        self._poses = np.stack([pose_of(Skeleton.of(d.frames)) for d in demonstrations])

    def of(self, frames: Sequence[Frame], path: NDArray[np.float64]) -> NDArray[np.float64]:
        """The `FEATURES`, (D,), of a path (T, 3) in the robot's base frame [m].

        Args:
            frames: Of the shoulder and of the wrist.
            path: Where the gripper would go.
        """
        bones = self._measure.bones
        scale = float(bones.sum())
        skeleton = Skeleton.of(frames, bones)
        answer = self._measure.answer(frames, path[0])
        cut = skeleton.passed(path)
        gap = shortfall = hand = 0.0
        if cut is not None:
            points = by_length(path, 1.0, [cut], self._measure.config.phases).points
            gap = float(np.linalg.norm(points - answer.points, axis=1).mean())
            shortfall, hand = self._measure.clearances.shortfall(points, skeleton)
        end = path[-1] - skeleton.shoulder
        farthest = float(np.linalg.norm(path - _ROBOT_SHOULDER, axis=1).max())
        return np.array(
            [
                skeleton.bend,
                skeleton.sideways,
                np.linalg.norm(self._poses - pose_of(skeleton), axis=1).min(),
                answer.deviation.max() / scale,
                gap / scale,
                shortfall / scale,
                hand / scale,
                float(cut is not None),
                np.linalg.norm(end) / scale,
                end[2] / scale,
                (REACH - farthest) / scale,
            ]
        )


#: What a file says of a judge's model.
_MODEL = ("intercept", "features")


@dataclass(frozen=True, eq=False)
class Judge:
    """Estimates the probability that a policy's path dresses the arm.

    Attributes:
        policy: Name of the policy whose episodes it was calibrated on.
        demonstrations: What that had learned from.
        model: Of the `FEATURES`.
        n_episodes: How many episodes it was calibrated on.
        source: Where they are from, in words.
    """

    policy: str
    demonstrations: str
    model: Logistic
    n_episodes: int
    source: str

    def probability(self, features: NDArray[np.float64]) -> float:
        """Of success, at `FEATURES` (D,)."""
        return float(self.model.probability(features[None])[0])

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a file."""
        model = self.model
        return {
            "policy": self.policy,
            "demonstrations": self.demonstrations,
            "n_episodes": self.n_episodes,
            "source": self.source,
            "intercept": model.intercept,
            "features": {
                name: {"mean": mean, "scale": scale, "weight": weight}
                for name, mean, scale, weight in zip(
                    FEATURES,
                    model.mean.tolist(),
                    model.scale.tolist(),
                    model.weights.tolist(),
                    strict=True,
                )
            },
        }

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Judge:
        """The inverse of `to_dict`.

        Raises:
            InvalidInputError: Something is missing, or of other features.
        """
        of_kind(values, Mapping, "a judge", "an object as 'confidence' writes")
        unknown = set(values) - {"policy", "demonstrations", "n_episodes", "source", *_MODEL}
        if unknown:
            raise InvalidInputError(f"a judge: unknown key {shown(sorted(map(str, unknown))[0])}")
        try:
            told = values["features"]
            if list(told) != list(FEATURES):
                raise InvalidInputError(
                    f"a judge: features are {', '.join(told)}, valid are {', '.join(FEATURES)}"
                )
            mean, scale, weights = (
                np.array([real_number(one[key], f"{name}: {key}") for name, one in told.items()])
                for key in ("mean", "scale", "weight")
            )
            model = Logistic(mean, scale, weights, real_number(values["intercept"], "intercept"))
            policy, learned, source = (
                of_kind(values[key], str, key, "a text")
                for key in ("policy", "demonstrations", "source")
            )
            n_episodes = whole_number(values["n_episodes"], "n_episodes")
            return cls(policy, learned, model, n_episodes, source)
        except (KeyError, TypeError) as error:
            raise InvalidInputError(f"a judge: missing or damaged ({error})") from error

    def save(self, path: str | File) -> None:
        """Write it as JSON."""
        write_file(path, json.dumps(self.to_dict(), indent=2) + "\n")

    @classmethod
    def load(cls, path: str | File) -> Judge:
        """The judge that `save` wrote.

        Raises:
            InvalidInputError: No such file, or no judge in it.
        """
        values = read_strict_json(File(of_kind(path, (str, File), "a judge", "a file")))
        if not isinstance(values, Mapping):
            raise InvalidInputError(f"{path}: not a judge; valid is what 'confidence' wrote")
        try:
            return cls.from_dict(values)
        except InvalidInputError as error:
            raise InvalidInputError(f"{path}: {error}") from error


class JudgedPolicy:
    """A policy whose paths say how likely they are to dress the arm, and that may abstain.

    Args:
        policy: Makes the paths.
        judge: Judges them.
        abstain: It abstains below this probability; 0 never.
    """

    def __init__(self, policy: Policy, judge: Judge, abstain: float = 0.0) -> None:
        self.policy = policy
        self.judge = judge
        self.abstain = real_number(abstain, "abstain", 0.0, 1.0)
        self.inputs: Inputs = inputs_of(policy)
        self.stream = getattr(policy, "stream", type(policy).__qualname__)
        self._features: PathFeatures | None = None
        if self.inputs != "frames" or callable(getattr(policy, "act", None)):
            raise InvalidInputError(
                f"inputs are {self.inputs}: cannot be judged; valid is a policy that makes a path "
                "of the two frames"
            )

    @property
    def dt(self) -> float | None:
        """Time between the samples of a path in [s], if the policy has one."""
        return getattr(self.policy, "dt", None)

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Learn, and remember what from."""
        self._features = PathFeatures(demonstrations)
        self.policy = fit(self.policy, demonstrations)
        return self

    def generate(self, frames: Sequence[Frame], start: ArrayLike, seed: int = 0) -> Path:
        """The policy's path, with its probability of success.

        Raises:
            Abstained: The probability is too low.
        """
        if self._features is None:
            raise InvalidInputError("the policy has not learned yet; valid is fit() first")
        begin: Vector = real_vector(start, 3, "start has", "m")
        drawn = seed_argument(self.policy.generate, seed)
        path = checked_path(self.policy.generate(frames, begin, **drawn), "the policy")
        probability = self.judge.probability(self._features.of(frames, path.positions))
        if probability < self.abstain:
            raise Abstained(
                f"the estimated probability of success is {probability:.3f}, below {self.abstain:g}"
            )
        return Path(path.positions, path.dt, probability)


def judged(policy: Policy, name: str, file: str, abstain: float) -> JudgedPolicy:
    """A policy with the judge of a file, which must be of a policy of this name.

    Raises:
        InvalidInputError: It is not, or the policy cannot be judged.
    """
    judge = Judge.load(file)
    if judge.policy != name:
        raise InvalidInputError(
            f"{file}: judges {judge.policy!r}; valid is a judge of {name!r}, from "
            "'dressing-sim confidence'"
        )
    return JudgedPolicy(policy, judge, abstain)


def split_judged(name: str) -> tuple[str, tuple[str, float] | None]:
    """A policy's name without ``judge=FILE`` and ``abstain=P``, and these two if there are any.

    Raises:
        InvalidInputError: A probability without a judge, one of them twice, or no probability.
    """
    stem, mark, text = name.partition("?")
    parts = text.split("&") if mark else []
    own = [part for part in parts if part.partition("=")[0] in ("judge", "abstain")]
    if not own:
        return name, None
    chosen = dict(part.split("=", 1) for part in own if "=" in part)
    if len(chosen) != len(own) or not chosen.get("judge"):
        raise InvalidInputError(
            f"policy {name!r:.400}: {'&'.join(own)}; valid is judge=FILE, or "
            "judge=FILE&abstain=PROBABILITY"
        )
    try:
        least = float(chosen.get("abstain", "0"))
    except ValueError as error:
        raise InvalidInputError(
            f"policy {name!r:.400}: abstain is {chosen['abstain']!r}, valid is 0 to 1"
        ) from error
    rest = "&".join(part for part in parts if part not in own)
    return f"{stem}?{rest}" if rest else stem, (chosen["judge"], least)
