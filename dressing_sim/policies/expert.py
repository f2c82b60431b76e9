"""The scripted operator as a policy; it sees the whole posture and learns nothing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from dressing_sim.episode.operator import Operator, OperatorConfig

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
