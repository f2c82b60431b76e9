"""A robot as data: its description, its joints and servos, its hand, and where it stands.

The defaults are the Franka Panda's, with which everything published was computed.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from dressing_sim.checks import clean_name, real_array, real_number, shown
from dressing_sim.config import LATER, check_kinds, check_numbers
from dressing_sim.errors import InvalidInputError

#: A base stands at most this far from the origin, in each coordinate [m].
MAX_BASE_DISTANCE = 2.0


@dataclass(frozen=True, slots=True)
class ServoConfig:
    """Joint position servos: torque = stiffness (command - q) - damping qd, clipped at the limit.

    The gains are our own choice, as stiff as the physics step allows: the discrete integrator takes
    servos implicitly, but clips them by what they would do at the step's start, so a servo at its
    limit loses its damping. So each is critically damped for the inertia that its joint feels at
    most (Pinocchio), and at half its speed and acceleration limits stays below its torque limit.
    """

    stiffness: tuple[float, ...] = (4500.0, 4500.0, 3500.0, 3500.0, 600.0, 600.0, 400.0)
    """Of each arm joint [N m/rad]; any sequence, kept as a tuple, as is the damping."""
    damping: tuple[float, ...] = (250.0, 250.0, 150.0, 120.0, 20.0, 20.0, 14.0)
    """Of each arm joint [N m s/rad]."""
    finger_stiffness: float = 2000.0
    """Of each finger [N/m]."""
    finger_damping: float = 50.0
    """Of each finger [N s/m]."""
    finger_force: float = 70.0
    """Largest grip force [N], the Panda hand's continuous rating."""
    armature: float = 0.1
    """Reflected rotor inertia added to each arm joint [kg m^2]."""

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping"):
            object.__setattr__(self, name, _positive(getattr(self, name), f"servo: {name}"))
        if len(self.stiffness) != len(self.damping):
            raise InvalidInputError(
                f"servo: stiffness is {self.stiffness} and damping is {self.damping}, valid is one "
                "number of each for every joint"
            )
        check_numbers(
            self, "servo", ("finger_stiffness", "finger_damping", "finger_force"), ("armature",)
        )


@dataclass(frozen=True, slots=True)
class Gripper:
    """A plain hand of boxes at a robot's flange, its two fingers closed; or none.

    Its z axis is the flange's and points away from the robot, along the fingers, which open along
    y. The tool centre point is between the fingers, `GRASP_DEPTH` from their tips. The sizes are
    those of the usual two-finger grippers for light arms (own choice, no maker's data).
    """

    flange: str = ""
    """Link that the hand is fixed to; nothing if the robot's description has a hand of its own."""
    mass: float = 0.9
    """All of it, as in a box of the palm's size [kg]."""
    palm_length: float = 0.09
    """Along the fingers [m]."""
    palm_width: float = 0.12
    """Along the direction in which the fingers open [m]."""
    palm_thickness: float = 0.07
    """Across both [m]."""
    finger_length: float = 0.07
    """From the palm to the tip [m]."""
    finger_width: float = 0.02
    """As the palm's thickness is measured [m]."""
    finger_thickness: float = 0.012
    """Of each finger, as the palm's width is measured [m]."""

    def __post_init__(self) -> None:
        check_numbers(
            self,
            "gripper",
            (
                *("mass", "palm_length", "palm_width", "palm_thickness"),
                *("finger_length", "finger_width", "finger_thickness"),
            ),
        )

    @property
    def reach(self) -> float:
        """From the flange to the tool centre point [m]."""
        return self.palm_length + self.finger_length - GRASP_DEPTH


#: How far the tool centre point of a `Gripper` is from the tips of its fingers [m].
GRASP_DEPTH = 0.01


@dataclass(frozen=True, slots=True)
class Robot:
    """All that is particular to a robot."""

    name: str = "panda"
    """What it is called."""
    urdf: str = "package://example-robot-data/robots/panda_description/urdf/panda.urdf"
    """Its description: a file, or what a ROS package has, see `urdf_path`."""
    joints: tuple[str, ...] = tuple(f"panda_joint{number}" for number in range(1, 8))
    """The arm's joints, in their order from the base to the hand. Those that are neither here nor
    among the fingers stay at zero."""
    fingers: tuple[str, ...] = ("panda_finger_joint1", "panda_finger_joint2")
    """Sliding joints of the hand, which its servos keep closed."""
    tool: str = "panda_hand_tcp"
    """Link whose origin is the tool centre point, between the fingertips; its z axis points along
    the fingers. Of a robot with a `Gripper` it is made, and this is its name."""
    home: tuple[float, ...] = (0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398)
    """A resting posture with the hand pointing down in front of the base [rad]. Inverse kinematics
    starts here and is drawn here."""
    acceleration: tuple[float, ...] = (7.5, 3.75, 5.0, 6.25, 7.5, 10.0, 10.0)
    """Largest joint accelerations of a command [rad/s^2]: half of what the Panda's control
    interface accepts. A servo that is asked for more than its torque saturates, falls behind and
    overshoots."""
    servo: ServoConfig = field(default_factory=ServoConfig)
    gripper: Gripper = field(default_factory=Gripper)
    base_position: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Where the description's root stands, (3,) [m], in the frame that everything is said in, which
    is the base frame of a Panda that stands where it should."""
    base_yaw: float = 0.0
    """How far it is turned about the vertical there [rad]."""
    grip_strength: float = 42.0
    """Pull at which the cloth slips from its fingers [N]."""
    grip_source: str = field(
        default="the Panda hand's continuous clamping force of 70 N, friction of 0.3 on two sides",
        metadata=LATER,
    )
    """Where that is from."""
    urdf_checksum: str = field(default="", metadata=LATER)
    """Of the description and its meshes, see `dressing_sim.world.description.checksum`; empty for
    what comes with a package, whose version a run's config has."""

    def __post_init__(self) -> None:
        check_kinds(self, "robot")
        clean_name(self.name, "robot: name")
        for name in ("joints", "fingers"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        named = [*self.joints, *self.fingers]
        if not self.joints or not all(isinstance(name, str) for name in named):
            raise InvalidInputError(
                f"robot {self.name}: joints are {shown(named)}, valid are names of one or more"
            )
        if len(set(named)) < len(named):
            raise InvalidInputError(
                f"robot {self.name}: joints are {shown(named, 300)}, valid is each of them once"
            )
        position = tuple(
            real_number(x, f"robot {self.name}: base [m]", -MAX_BASE_DISTANCE, MAX_BASE_DISTANCE)
            for x in self.base_position
        )
        object.__setattr__(self, "base_position", position)
        real_number(self.grip_strength, f"robot {self.name}: grip_strength [N]", 0.0, above=True)
        clean_name(self.grip_source, f"robot {self.name}: grip_source")
        real_number(self.base_yaw, f"robot {self.name}: base_yaw [rad]", -2 * np.pi, 2 * np.pi)
        home = tuple(real_number(q, f"robot {self.name}: home [rad]") for q in self.home)
        object.__setattr__(self, "home", home)
        asked = _positive(self.acceleration, f"robot {self.name}: acceleration")
        object.__setattr__(self, "acceleration", asked)
        for name, values, n in (
            ("base_position", position, 3),
            ("home", home, self.n_joints),
            ("acceleration", asked, self.n_joints),
            ("servo", self.servo.stiffness, self.n_joints),
        ):
            if len(values) != n:
                raise InvalidInputError(
                    f"robot {self.name}: {name} has {len(values)} numbers, valid is {n}"
                )

    @property
    def n_joints(self) -> int:
        """Number of the arm's joints."""
        return len(self.joints)


def _positive(values: object, name: str) -> tuple[float, ...]:
    numbers = real_array(values, ("n",), f"{name} has", fewest=1)
    if not (numbers > 0.0).all():
        raise InvalidInputError(
            f"{name} is {shown(values, 200)}, valid is a number > 0 for each joint"
        )
    return tuple(numbers.tolist())


#: The robot of all that is published.
PANDA = Robot()
