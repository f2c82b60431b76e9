"""The verdict on one episode, and what went wrong in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class Failure:
    """One thing that went wrong.

    Attributes:
        reason: One of `REASONS`.
        detail: What exactly, in words.
        time: When it first occurred, since the robot began to move [s]; None if not in time.
        s: Arm coordinate of the armscye's centre at that moment; None if not known.
        where: The part of the arm or of the mannequin that it is about, or None.
    """

    reason: str
    detail: str
    time: float | None = None
    s: float | None = None
    where: str | None = None


@dataclass(frozen=True, slots=True)
class Outcome:
    """The verdict on one episode.

    Attributes:
        success: Whether the arm is dressed and nothing went wrong on the way.
        failures: Everything that went wrong, one entry a reason.
        metrics: The measurements behind the verdict, SI units; files call them ``figures``.
        invalid: Why the simulation cannot be trusted, or None; an invalid episode is neither a
            success nor a failure of the policy. Files call it ``void``.
        abstained: Why the policy chose not to try, or None; it is no success then, and nothing went
            wrong.
    """

    success: bool
    failures: tuple[Failure, ...] = ()
    metrics: Mapping[str, float] = field(default_factory=dict)
    invalid: str | None = None
    abstained: str | None = None

    @property
    def reasons(self) -> tuple[str, ...]:
        """Names of everything that went wrong."""
        return tuple(failure.reason for failure in self.failures)

    @property
    def verdict(self) -> str:
        """In words: success, all that went wrong, that the policy abstained, or why it is void."""
        if self.invalid is not None:
            return f"void: {self.invalid}"
        if self.abstained is not None:
            return "abstained"
        return "success" if self.success else ", ".join(self.reasons)

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a JSON file."""
        return {
            "success": self.success,
            "void": self.invalid,
            "failures": [
                {"reason": f.reason, "detail": f.detail, "time": f.time, "s": f.s, "where": f.where}
                for f in self.failures
            ],
            "figures": dict(self.metrics),
            **({} if self.abstained is None else {"abstained": self.abstained}),
        }
