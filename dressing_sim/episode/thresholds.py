"""The numbers that decide a verdict, each with its unit and source."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np

from dressing_sim.config import check_numbers
from dressing_sim.errors import InvalidInputError


def _threshold(value: float, unit: str, source: str) -> float:
    """A field whose unit and source can be asked for, see `threshold_units`."""
    number: float = field(default=value, metadata={"unit": unit, "source": source})
    return number


@dataclass(frozen=True, slots=True)
class Thresholds:
    """When a dressing counts as done and what it may not do on the way.

    `threshold_units` and `threshold_sources` say what each is measured in and where it comes from.
    """

    armscye_s: float = _threshold(
        1.85,
        "-",
        "The armscye's centre must end at or past this arm coordinate: within about one arm's "
        "radius of the shoulder joint. Own choice.",
    )
    gripper_distance: float = _threshold(
        0.16,
        "m",
        "The gripper must end this close to the shoulder joint [m]: own choice, the armscye's "
        "radius and the shoulder's.",
    )
    hold_time: float = _threshold(
        0.5, "s", "For how long at the end the sleeve must be on [s]. Own choice."
    )
    strain: float = _threshold(
        0.30,
        "-",
        "Principal strain that 95 % of the cloth's area may not exceed. Own choice: what knitted "
        "jersey gives way to in wear; a sleeve that is caught at the elbow goes past it.",
    )
    strain_percentile: float = _threshold(
        95.0, "%", "Which part of the cloth's area is judged [%]."
    )
    grip_force: float = _threshold(
        10.0,
        "N",
        "Largest pull on the cloth [N]: Assistive Gym's preferred limit (Erickson et al. 2020).",
    )
    link_force: float = _threshold(
        50.0,
        "N",
        "Largest net force of cloth on one link of the mannequin [N]: a third of the 140 to 160 N "
        "that ISO/TS 15066 allows on hand and arm, quasi-static.",
    )
    moment: float = _threshold(
        0.2,
        "s",
        "Strain and force may exceed their thresholds for no longer than this in one go [s].",
    )

    def __post_init__(self) -> None:
        check_numbers(self, "thresholds", (), ("hold_time", "moment"))
        for name in ("gripper_distance", "strain", "strain_percentile", "grip_force", "link_force"):
            if not getattr(self, name) > 0.0:  # a limit may be infinite, which switches it off
                raise InvalidInputError(
                    f"thresholds: {name} is {getattr(self, name)}, valid is > 0"
                )
        if not np.isfinite(self.armscye_s):
            raise InvalidInputError(
                f"thresholds: armscye_s is {self.armscye_s}, valid is a finite number"
            )
        if self.strain_percentile > 100.0:
            raise InvalidInputError(
                f"thresholds: strain_percentile is {self.strain_percentile}, valid is 0 to 100"
            )


def threshold_units() -> dict[str, str]:
    """The unit of each threshold, a dash where it has none."""
    return {one.name: str(one.metadata["unit"]) for one in fields(Thresholds)}


def threshold_sources() -> dict[str, str]:
    """What each threshold means and where its value comes from."""
    return {one.name: str(one.metadata["source"]) for one in fields(Thresholds)}
