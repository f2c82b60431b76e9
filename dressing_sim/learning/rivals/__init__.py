"""Other methods of learning from few demonstrations, each faithful to its source, arrays alone.

A method is a frozen dataclass of hyper-parameters with `learn`; ``docs/rivals.md`` has a section on
each. They are compared, so that they share what is not theirs: demonstrations in phase, and the
same mixtures.
"""

from collections.abc import Mapping

from dressing_sim.learning.rivals.attractor import VirtualAttractor
from dressing_sim.learning.rivals.frame_weighted import FrameWeighted
from dressing_sim.learning.rivals.incremental import Incremental
from dressing_sim.learning.rivals.kernelized import KernelizedPrimitives
from dressing_sim.learning.rivals.method import Equivariance, Method, Shown, Skill
from dressing_sim.learning.rivals.movement_primitives import (
    DynamicPrimitive,
    ProbabilisticPrimitive,
)
from dressing_sim.learning.rivals.neural import NeuralPrimitive
from dressing_sim.learning.rivals.references import Nearest, Straight, ViaOracle
from dressing_sim.learning.rivals.regression import FrameRegression, WorldRegression
from dressing_sim.learning.rivals.selected import ChosenComponents
from dressing_sim.learning.rivals.semi_markov import SemiMarkov
from dressing_sim.learning.rivals.task_dmp import TaskDMP
from dressing_sim.learning.rivals.transported import Transportation
from dressing_sim.learning.rivals.via_points import ViaPointPrimitive
from dressing_sim.learning.rivals.weighted import InferredWeights, LearnedWeights

#: By the name of the policy.
METHODS: Mapping[str, Method] = {
    "nearest": Nearest(),
    "straight": Straight(),
    "via-oracle": ViaOracle(),
    "gmr-world": WorldRegression(),
    "gmr-frame": FrameRegression(),
    "dmp": DynamicPrimitive(),
    "promp": ProbabilisticPrimitive(),
    "tp-gmr": LearnedWeights(updates=0),
    "tp-gmr-learned": LearnedWeights(),
    "tp-gmr-inferred": InferredWeights(),
    "tp-gmr-bic": ChosenComponents(),
    "ds-gmr": VirtualAttractor(),
    "frame-weighted": FrameWeighted(),
    "tp-dmp": TaskDMP(),
    "kmp": KernelizedPrimitives(),
    "tp-hsmm": SemiMarkov(),
    "tp-gmr-generative": Incremental(),
    "tp-gmr-addition": Incremental(update="addition"),
    "tp-gmr-direct": Incremental(update="direct"),
    "gp-transport": Transportation(),
    "vmp": ViaPointPrimitive(),
    "cnmp": NeuralPrimitive(),
}

__all__ = ["METHODS", "Equivariance", "Method", "Shown", "Skill"]
