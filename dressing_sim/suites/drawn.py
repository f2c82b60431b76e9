"""Suites that were drawn once, each from where it says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from dressing_sim.arm import Posture
from dressing_sim.motion import Compliance, Motion
from dressing_sim.suites.distribution import PostureDistribution, sample_postures
from dressing_sim.suites.motions import MotionDistribution, sample_moving_postures


@dataclass(frozen=True, slots=True)
class DrawnSuite:
    """A suite that was drawn once and is frozen in a file of ``assets/suites/``.

    Attributes:
        description: What it is for.
        prefix: Postures are called this and their number.
        n_postures: How many.
        seed: Of its stream of random numbers, which no ``random:N:SEED`` uses.
        distribution: Where it was drawn from.
        motions: Where motions of its arms were drawn from; None for arms that do not move.
        compliance: How its arms give way; None if they do not.
    """

    description: str
    prefix: str
    n_postures: int
    seed: int
    distribution: PostureDistribution = field(default_factory=PostureDistribution)
    motions: MotionDistribution | None = None
    compliance: Compliance | None = None

    def postures(self, n: int | None = None) -> list[Posture]:
        """Draw the postures, or only the first n, again."""
        # A seed alone is a stream of random:N:SEED; a spawn key branches off from all of these.
        rng = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(0,)))
        count = self.n_postures if n is None else n
        if self.motions is None:
            drawn = sample_postures(count, rng, self.distribution)
        else:
            drawn = sample_moving_postures(count, rng, self.distribution, self.motions)
        if self.compliance is not None:
            moved = [one.motion or Motion() for one in drawn]
            giving = [replace(motion, compliance=self.compliance) for motion in moved]
            drawn = [replace(p, motion=m) for p, m in zip(drawn, giving, strict=True)]
        digits = len(str(self.n_postures - 1))
        return [
            replace(posture, name=f"{self.prefix}{number:0{digits}}")
            for number, posture in enumerate(drawn)
        ]

    def header(self) -> dict[str, Any]:
        """What the file says besides the postures."""
        return {
            "description": self.description,
            "distribution": asdict(self.distribution),
            **({} if self.motions is None else {"motions": asdict(self.motions)}),
            "seed": self.seed,
        }


#: Angles that leave room to move on either side.
_AMID = PostureDistribution(rotation_deg=(10.0, 52.0), elbow_deg=(18.0, 70.0))

DRAWN_SUITES: Mapping[str, DrawnSuite] = {
    "val50": DrawnSuite(
        "Fifty random postures to choose settings on; results on them are not test results.",
        "val",
        50,
        seed=1,
    ),
    "test200": DrawnSuite(
        "Two hundred random postures to test on; nothing is chosen on them.", "test", 200, seed=2
    ),
    "hard_elbow": DrawnSuite(
        "Fifty random postures with the elbow bent by 60 to 90 degrees, where sleeves get caught.",
        "elbow",
        50,
        seed=3,
        distribution=PostureDistribution(elbow_deg=(60.0, 90.0)),
    ),
    "train200": DrawnSuite(
        "Two hundred random postures to train a judge on, with elbows bent by up to 90 degrees.",
        "train",
        200,
        seed=6,
        distribution=PostureDistribution(elbow_deg=(5.0, 90.0)),
    ),
    "moving": DrawnSuite(
        "Fifty random postures of people who drift and sway.",
        "moving",
        50,
        seed=4,
        distribution=_AMID,
        motions=MotionDistribution(),
    ),
    "compliant": DrawnSuite(
        "Fifty random postures of arms that give way to the cloth.",
        "compliant",
        50,
        seed=5,
        compliance=Compliance(),
    ),
}
