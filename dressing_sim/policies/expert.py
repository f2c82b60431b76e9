"""The scripted operator as a policy; it sees the whole posture and learns nothing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from dressing_sim.episode.operator import Operator, OperatorConfig
from dressing_sim.policies.hyperparameters import changed

EXPERT = "expert"

#: The same operator, who looks again while the arm moves; see `dressing_sim.policies.replanned`.
EXPERT_REPLAN = "expert-replan"


@dataclass(frozen=True, slots=True)
class ExpertConfig:
    """Hyper-parameters of the operator."""

    operator: OperatorConfig = field(default_factory=OperatorConfig)

    def make(self, seed: int = 0) -> Operator:
        """A new operator; its seed is that of each episode."""
        return Operator(self.operator)


POLICIES: Mapping[str, ExpertConfig] = {EXPERT: ExpertConfig()}


def operator_of(style: str) -> Operator:
    """The operator; of another style with what stands after ``expert?``.

    Args:
        style: ``name=value&...``, fields of `OperatorConfig`; empty for the usual one.

    Raises:
        InvalidInputError: An unknown name, or a value that cannot be.
    """
    config = POLICIES[EXPERT]
    return (changed(config, style) if style else config).make()
