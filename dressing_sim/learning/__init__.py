"""Learning task-parameterized skills from few demonstrations: arrays in, arrays out.

An implementation of J. Zhu, M. Gienger and J. Kober, "Learning Task-Parameterized Skills from Few
Demonstrations", IEEE Robotics and Automation Letters (2022). It needs numpy, scipy and numba only;
the compiled loops are loaded on first use, so that the import is quick.
"""

from dressing_sim.learning.augment import (
    METHODS,
    Augmentation,
    AugmentOptions,
    Candidate,
    Method,
    augment,
)
from dressing_sim.learning.components import (
    bic,
    choose_by_bic,
    choose_by_dirichlet_process,
    n_parameters,
)
from dressing_sim.learning.costs import dtw_cost, rms_cost
from dressing_sim.learning.demonstrations import DemonstrationLike, SyntheticDemonstration
from dressing_sim.learning.density import GaussianMixture
from dressing_sim.learning.dtw import Warping, dtw, dtw_distance
from dressing_sim.learning.em import EMOptions, EMRecord, Mixture
from dressing_sim.learning.endpoint import Endpoint
from dressing_sim.learning.frame import Frame, Situation
from dressing_sim.learning.gmr import FUSION_ORDERS, FusionOrder
from dressing_sim.learning.motion import Motion
from dressing_sim.learning.noise import add_white_noise, noise_deviation
from dressing_sim.learning.phases import Alignment, Clock
from dressing_sim.learning.policy import Inputs, Policy, TimedPath
from dressing_sim.learning.remarks import Remark, remarks
from dressing_sim.learning.sampling import (
    BoundsSampler,
    FrameBounds,
    SituationSampler,
    euler_angles,
    rotation,
)
from dressing_sim.learning.storage import load_model, save_model
from dressing_sim.learning.timed import TimeTPGMM
from dressing_sim.learning.tpgmm import TPGMM
from dressing_sim.learning.trajectory import TrajectoryTPGMM

__all__ = [
    "FUSION_ORDERS",
    "METHODS",
    "TPGMM",
    "Alignment",
    "AugmentOptions",
    "Augmentation",
    "BoundsSampler",
    "Candidate",
    "Clock",
    "DemonstrationLike",
    "EMOptions",
    "EMRecord",
    "Endpoint",
    "Frame",
    "FrameBounds",
    "FusionOrder",
    "GaussianMixture",
    "Inputs",
    "Method",
    "Mixture",
    "Motion",
    "Policy",
    "Remark",
    "Situation",
    "SituationSampler",
    "SyntheticDemonstration",
    "TimeTPGMM",
    "TimedPath",
    "TrajectoryTPGMM",
    "Warping",
    "add_white_noise",
    "augment",
    "bic",
    "choose_by_bic",
    "choose_by_dirichlet_process",
    "dtw",
    "dtw_cost",
    "dtw_distance",
    "euler_angles",
    "load_model",
    "n_parameters",
    "noise_deviation",
    "remarks",
    "rms_cost",
    "rotation",
    "save_model",
]
