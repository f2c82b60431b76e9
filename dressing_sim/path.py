"""Paths that policies return, checked: a policy may be anybody's."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.checks import real_array, real_number, shown
from dressing_sim.errors import InvalidInputError, PolicyError
from dressing_sim.inputs import asked_with
from dressing_sim.seeds import derived_seed

#: The robot's reach [m]; a path that is nowhere nearer than so many times that is in another unit.
REACH, FAR = 0.855, 10.0


@dataclass(frozen=True, eq=False)
class Path:
    """Where the gripper should go.

    Attributes:
        positions: Positions (T, 3), T of 2 or more, in the robot's base frame [m].
        dt: Time between two of them [s]; None leaves the speed to whoever plays the path.
        probability: Of success, as its maker estimates it; None if it does not say.

    Raises:
        InvalidInputError: Another shape, values that are no finite real numbers or no metres, or a
            time that is not above zero.
    """

    positions: NDArray[np.float64]
    dt: float | None = None
    probability: float | None = None

    def __post_init__(self) -> None:
        if self.probability is not None:
            real_number(self.probability, "a path's probability", 0.0, 1.0)
        positions = np.array(_checked_positions(self.positions, "a path: got"))
        positions.flags.writeable = False
        object.__setattr__(self, "positions", positions)
        if self.dt is not None:
            object.__setattr__(self, "dt", _checked_dt(self.dt, np.inf, "a path: its"))

    def __len__(self) -> int:
        """Number of positions T."""
        return len(self.positions)


def _checked_positions(path: object, doing: str) -> NDArray[np.float64]:
    array = real_array(path, ("T", 3), f"{doing} an array of", "m", fewest=2)
    check_metres(array, doing)
    return array


def check_metres(positions: NDArray[np.float64], doing: str) -> None:
    """Raise InvalidInputError if no position (T, 3) is anywhere near the robot, see `FAR`."""
    nearest = float(np.linalg.norm(positions, axis=1).min())
    if nearest > FAR * REACH:
        raise InvalidInputError(
            f"{doing} positions all of which are {nearest:.4g} m or more from the robot's base, "
            f"whose reach is {REACH} m; valid are metres (are these millimetres?)"
        )


def _checked_dt(dt: object, longest: float, whose: str) -> float:
    try:
        return real_number(dt, whose, 0.0, longest, above=True)
    except InvalidInputError as error:
        most = "" if longest == np.inf else f", up to the episode's time limit of {longest:g} s"
        told = f"{whose} dt is {shown(dt)}, valid is seconds above zero{most}"
        raise InvalidInputError(told) from error


def checked_path(made: object, name: str) -> Path:
    """What a policy returned as a path, once it is one: a `Path`, or an array (T, 3) in [m].

    Raises:
        InvalidInputError: It is not of shape (T, 3), T of 2 or more, or not finite.
    """
    return made if isinstance(made, Path) else Path(_checked_positions(made, f"{name}: returned"))


def check_source(source: object) -> None:
    """Raise InvalidInputError unless it is a policy, or a path; if an array, a valid one."""
    if isinstance(source, np.ndarray):
        _checked_positions(source, "the path: got")
    elif isinstance(source, type) or not (
        isinstance(source, Path) or callable(getattr(source, "generate", None))
    ):
        raise InvalidInputError(
            f"cannot dress with {shown(source)}; valid is a policy, a Path or an array (T, 3) "
            "of numpy"
        )


def policy_path(
    source: object,
    posture: Posture,
    start: NDArray[np.float64],
    seed: int,
    default_dt: float,
    longest_dt: float,
) -> Path:
    """The path that dresses a posture.

    Args:
        source: A fitted policy, which is asked with what its class of inputs stands for; its
            attribute ``dt``, if it has one, is the time between its points unless its path says.
            Or the path itself, a `Path` or an array (T, 3) of numpy.
        posture: The arm.
        start: Where the gripper is, (3,), in the robot's base frame [m].
        seed: Of the episode.
        default_dt: Time between the points of a path without a ``dt`` [s].
        longest_dt: Largest time between two points [s].

    Raises:
        InvalidInputError: It is no policy.
        PolicyError: Its path or time step is not valid.
    """
    check_source(source)
    if isinstance(source, np.ndarray | Path):
        path = checked_path(source, "the path")
        own = default_dt if path.dt is None else _checked_dt(path.dt, longest_dt, "the path: its")
        return Path(path.positions, own, path.probability)
    policy: Any = source
    with policy_at_fault():
        name, dt = policy_name(policy), getattr(policy, "dt", None)
        if dt is not None:
            dt = _checked_dt(dt, longest_dt, f"{name}: its attribute")
        drawn = seed_argument(policy.generate, policy_seed(policy, seed))
        path = checked_path(policy.generate(asked_with(policy, posture), start, **drawn), name)
        if path.dt is not None:
            dt = _checked_dt(path.dt, longest_dt, f"{name}: its path's")
        return Path(path.positions, default_dt if dt is None else dt, path.probability)


@contextmanager
def policy_at_fault() -> Iterator[None]:
    """Within the block what is not valid is a policy's answer: a `PolicyError`."""
    try:
        yield
    except PolicyError:
        raise
    except InvalidInputError as error:
        raise PolicyError(str(error)) from error


def policy_name(policy: object) -> str:
    """What errors call a policy: its name, if it has one, or its class's."""
    name = getattr(policy, "name", None)
    return f"policy {name if isinstance(name, str) else type(policy).__name__}"


def takes_seed(function: Callable[..., object]) -> bool:
    """Whether a function, or a class, has an argument ``seed``."""
    try:
        return "seed" in inspect.signature(function).parameters
    except ValueError:  # what is written in C need not say what it takes
        return False


def seed_argument(function: Callable[..., object], seed: int) -> dict[str, int]:
    """The seed as a keyword argument for a function that takes one; else none."""
    return {"seed": seed} if takes_seed(function) else {}


def reset_policy(policy: object, seed: int) -> None:
    """Tell a policy in closed loop that an episode begins, if it wants to know."""
    reset = getattr(policy, "reset", None)
    if callable(reset):
        reset(**seed_argument(reset, seed))


def policy_seed(policy: object, seed: int) -> int:
    """Seed of a policy's own randomness in an episode, from the episode's seed and its name.

    The name is its attribute ``stream`` or its class's. Without a name, as the operator, it gets
    the seed of the episode as it is.
    """
    stream = getattr(policy, "stream", type(policy).__qualname__)
    return derived_seed(f"{seed}/generate {stream}") if stream else seed
