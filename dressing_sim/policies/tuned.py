"""Policies with the hyper-parameters that the search found for them, the same budget for each.

The paper's rows are judged twice, as published and tuned. ``dressing-sim tune NAME`` with its
defaults found what stands here, on ``val50`` alone; ``docs/results/tune-NAME.json`` has all trials.
"""

from __future__ import annotations

from collections.abc import Mapping

from dressing_sim.policies import paper, transported
from dressing_sim.policies.hyperparameters import TUNED, changed

#: What was chosen, as after a policy's ``?``, by the policy's name.
CHOSEN: Mapping[str, str] = {}

_UNTUNED: Mapping[str, paper.TPGMMConfig | transported.TransportConfig] = {
    **paper.POLICIES,
    **transported.POLICIES,
}

POLICIES: Mapping[str, paper.TPGMMConfig | transported.TransportConfig] = {
    f"{name}{TUNED}": changed(_UNTUNED[name], text) for name, text in CHOSEN.items()
}
