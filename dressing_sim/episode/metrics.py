"""The numbers of an episode: what each is called, its unit, and what it means."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from dressing_sim.world.mannequin import LINKS


@dataclass(frozen=True, slots=True)
class Metric:
    """A number that every dressed episode has.

    Attributes:
        name: Its key in ``Outcome.metrics`` and, in files, in ``figures``.
        unit: SI unit; a dash where it has none.
        meaning: What it is.
    """

    name: str
    unit: str
    meaning: str

    def text(self, value: float, digits: int = 3) -> str:
        """A value of it for people, with so many digits after the point and its unit."""
        return f"{value:.{digits}f}" if self.unit == "-" else f"{value:.{digits}f} {self.unit}"


def _of_links() -> list[Metric]:
    named = [(link, link.replace("_", " ")) for link in LINKS]
    return [
        *(Metric(f"{link}_force", "N", f"largest net force on the {n}") for link, n in named),
        *(
            Metric(f"{link}_normal_force", "N", f"largest sum of normal forces on the {n}")
            for link, n in named
        ),
    ]


_ALL = (
    Metric("duration", "s", "how long the robot moved"),
    Metric("armscye_s", "-", "arm coordinate of the armscye's centre at the end"),
    Metric("gripper_distance", "m", "from the gripper to the shoulder joint at the end"),
    Metric("upper_arm_dressed_ratio", "-", "share of the upper arm that the armscye has passed"),
    Metric("whole_arm_dressed_ratio", "-", "share of the whole arm that the armscye has passed"),
    Metric("line_triangle_on", "-", "1 if the line-triangle test says that the sleeve is on"),
    Metric("line_triangle_ratio", "-", "share of the upper arm dressed by that test"),
    Metric("strain", "-", "largest principal strain at the percentile of area that is judged"),
    Metric("strain_median", "-", "largest principal strain of half the area"),
    Metric("strain_max", "-", "largest principal strain of any triangle"),
    Metric("edge_strain", "-", "largest strain of the edges at the percentile of length"),
    Metric("grip_force", "N", "largest pull of the gripper on the cloth"),
    Metric("link_force", "N", "largest net force of the cloth on a link"),
    Metric("link_normal_force", "N", "largest sum of the cloth's normal forces on a link"),
    *_of_links(),
    Metric("penetration", "m", "how deep the cloth was in the mannequin where it was deepest"),
    Metric("hit_force", "N", "largest normal force of the robot on the mannequin"),
    Metric("tracking_error", "m", "largest distance between gripper and target"),
    Metric("speed_near_arm", "m/s", "largest speed of the gripper near the arm"),
    Metric("torque", "N m", "largest torque of a joint of the robot"),
    Metric("torque_ratio", "-", "the same as a share of the joint's limit"),
    Metric("joint_speed_ratio", "-", "largest speed of a joint as a share of its limit"),
    Metric("joint_position_ratio", "-", "nearest a joint came to its limit, 1 at the limit"),
)

#: Every metric by its name, in the order in which they are printed.
METRICS: Mapping[str, Metric] = {metric.name: metric for metric in _ALL}


def metric_text(name: str, value: float) -> str:
    """A value with the unit of its metric; of a metric that is not ours, the number alone."""
    return METRICS[name].text(value) if name in METRICS else f"{value:.3f}"
