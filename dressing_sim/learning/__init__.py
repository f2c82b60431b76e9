"""Learning task-parameterized skills from few demonstrations: arrays in, arrays out.

An implementation of J. Zhu, M. Gienger and J. Kober, "Learning Task-Parameterized Skills from Few
Demonstrations", IEEE Robotics and Automation Letters (2022). It needs numpy, scipy and numba only;
the compiled loops are loaded on first use, so that the import is quick.
"""

from dressing_sim.learning.demonstrations import DemonstrationLike, SyntheticDemonstration
from dressing_sim.learning.em import EMOptions, EMRecord, Mixture
from dressing_sim.learning.frame import Frame, Situation
from dressing_sim.learning.gmr import FUSION_ORDERS, FusionOrder
from dressing_sim.learning.policy import Policy
from dressing_sim.learning.tpgmm import TPGMM
from dressing_sim.learning.trajectory import TrajectoryTPGMM

__all__ = [
    "FUSION_ORDERS",
    "TPGMM",
    "DemonstrationLike",
    "EMOptions",
    "EMRecord",
    "Frame",
    "FusionOrder",
    "Mixture",
    "Policy",
    "Situation",
    "SyntheticDemonstration",
    "TrajectoryTPGMM",
]
