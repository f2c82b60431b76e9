"""The interface that every policy meets, built in or from a third party."""

from collections.abc import Sequence
from typing import Literal, Protocol, Self, TypeVar, get_args, runtime_checkable

from numpy.typing import ArrayLike

from dressing_sim.learning.demonstrations import DemonstrationLike
from dressing_sim.learning.frame import FloatArray

#: What a policy is asked with, its class of inputs: the frames of shoulder and wrist; these and,
#: at each step, the measured force; these and the frame of the elbow; or the posture itself.
Inputs = Literal["frames", "frames+force", "elbow", "posture"]
INPUTS: tuple[Inputs, ...] = get_args(Inputs)

#: A `Situation`, or of class ``posture`` a `dressing_sim.Posture`.
Asked = TypeVar("Asked", contravariant=True)


class TimedPath(Protocol):
    """A path that says how fast it is; `dressing_sim.Path` is one."""

    @property
    def positions(self) -> FloatArray:
        """(T, p) positions in world coordinates."""

    @property
    def dt(self) -> float | None:
        """Time between two positions in [s], or None if whoever plays the path chooses."""


@runtime_checkable
class Policy(Protocol[Asked]):
    """A motion policy learned from demonstrations, asked for a path in a new situation.

    Besides the two methods a policy may have:

    * ``inputs``, its class of `Inputs`; without it ``"frames"``. It is asked with, and learns from
      demonstrations of, what this class stands for, and never gets more.
    * ``dt``, the time between two samples of its path in [s]; without it, whoever plays the path
      chooses the speed.
    * an argument ``seed`` of ``generate``, a whole number, for randomness of its own. It is derived
      from the episode's seed and the policy's name (its class's, unless an attribute ``stream``
      says another), so that episodes are independent samples and each repeats to the bit.
    * ``act(observation) -> target``, for control in closed loop: where the gripper should go next,
      (p,), or None to end there. Of class ``frames+force`` an observation holds the measured force.
    * ``reset()``, called before the first ``act`` of an episode, with a ``seed`` if it takes one.
    """

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Learn from demonstrations and return the policy itself."""

    def generate(self, frames: Asked, start: ArrayLike, /) -> FloatArray | TimedPath:
        """A path (T, p) in world coordinates for a situation, from the position ``start`` (p,)."""
