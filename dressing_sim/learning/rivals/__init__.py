"""Other methods of learning from few demonstrations, each faithful to its source, arrays alone.

A method is a frozen dataclass of hyper-parameters with `learn`; ``docs/rivals.md`` has a section on
each. They are compared, so that they share what is not theirs: demonstrations in phase, and the
same mixtures.
"""

from collections.abc import Mapping

from dressing_sim.learning.rivals.method import Equivariance, Method, Shown, Skill
from dressing_sim.learning.rivals.references import Nearest, Straight, ViaOracle
from dressing_sim.learning.rivals.regression import FrameRegression, WorldRegression

#: By the name of the policy.
METHODS: Mapping[str, Method] = {
    "nearest": Nearest(),
    "straight": Straight(),
    "via-oracle": ViaOracle(),
    "gmr-world": WorldRegression(),
    "gmr-frame": FrameRegression(),
}

__all__ = ["METHODS", "Equivariance", "Method", "Shown", "Skill"]
