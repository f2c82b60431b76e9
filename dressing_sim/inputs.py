"""What a policy is asked with, by its class of inputs; it never gets more than it declared."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

from dressing_sim.arm import SITUATION, Posture
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import DemonstrationLike, Policy, Situation, SyntheticDemonstration
from dressing_sim.learning.policy import INPUTS, Inputs

P = TypeVar("P", bound=Policy)

#: The frames that each class is asked with; ``posture`` gets the posture itself.
FRAMES_OF: Mapping[Inputs, tuple[str, ...]] = {
    "frames": SITUATION,
    "frames+force": SITUATION,
    "elbow": (*SITUATION, "elbow"),
}


def inputs_of(policy: object) -> Inputs:
    """A policy's class of inputs: its attribute ``inputs``, ``"frames"`` unless it has one.

    Raises:
        InvalidInputError: There is no such class.
    """
    declared = getattr(policy, "inputs", "frames")
    for inputs in INPUTS:
        if declared == inputs:
            return inputs
    raise InvalidInputError(
        f"policy {type(policy).__name__}: its attribute inputs is {declared!r:.40}, valid is one "
        f"of {', '.join(INPUTS)}"
    )


def asked_with(policy: object, posture: Posture) -> Situation | Posture:
    """What a policy is asked with for a posture: the frames of its class, or the posture."""
    names = FRAMES_OF.get(inputs_of(policy))
    return posture if names is None else posture.frames(*names)


def fit(policy: P, demonstrations: Sequence[DemonstrationLike]) -> P:
    """Let a policy learn from as much of the demonstrations as its class of inputs allows.

    Raises:
        InvalidInputError: It asks for frames that the demonstrations have not.
    """
    names = FRAMES_OF.get(inputs_of(policy))
    if names is None:
        return policy.fit(demonstrations)
    return policy.fit([_with_frames(one, names) for one in demonstrations])


def _with_frames(
    demonstration: DemonstrationLike, names: tuple[str, ...]
) -> SyntheticDemonstration:
    """A demonstration with these frames, and without the posture."""
    posture = getattr(demonstration, "posture", None)
    given = Situation.of(demonstration.frames)
    if isinstance(posture, Posture):
        frames = posture.frames(*names)
    elif set(names) <= set(given.names):
        frames = Situation.of([given[name] for name in names], names)
    elif names == SITUATION and len(given) == len(names):
        frames = given  # frames without names stand in the paper's order
    else:
        raise InvalidInputError(
            f"a demonstration has the frames {', '.join(given.names) or len(given)}, the policy "
            f"asks for {', '.join(names)}"
        )
    return SyntheticDemonstration(demonstration.positions, demonstration.dt, frames)
