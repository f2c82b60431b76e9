"""Time-based TP-GMM whose number of components the demonstrations choose.

Zhu, Gienger and Kober (2022) say that K should grow with the data and name two ways to choose it:
the Bayesian information criterion, and a Dirichlet-process mixture (`components`). The regression
is that of `fusion`, so that it differs from the plain one by K alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from dressing_sim.learning.components import choose_by_bic, choose_by_dirichlet_process
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.rivals.fusion import over_time, time_mixture
from dressing_sim.learning.rivals.method import Method, Shown, Skill
from dressing_sim.learning.tpgmm import TPGMM


@dataclass(frozen=True, slots=True)
class ChosenComponents(Method):
    """K by a criterion, then the plain TP-GMM over time.

    Source: Schwarz (1978), "Estimating the dimension of a model"; Blei and Jordan (2006),
    doi:10.1214/06-BA104.
    """

    criterion: Literal["bic", "dirichlet-process"] = "bic"
    """What chooses K."""
    most: int = 15
    """K at most."""
    floor: float = 1e-3
    """Added to variances, as a fraction of the data's."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The number of components, and the mixture."""
        mixture = time_mixture(shown, self.components(shown), self.floor)
        bands = over_time(mixture, shown.phase)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            return bands.in_world(frames).fused().means

        return skill

    def components(self, shown: Shown) -> int:
        """K."""
        model = TPGMM(1, encoding="time", floor=self.floor, relative_floor=True)
        told = shown.demonstrations()
        if self.criterion == "bic":
            return choose_by_bic(model, told, range(1, self.most + 1)).n_components
        return choose_by_dirichlet_process(model, told, max_components=self.most).n_components
