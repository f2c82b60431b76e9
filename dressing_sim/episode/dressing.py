"""One dressing, stepped: where commands, physics, measuring and the protective stop meet."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import lru_cache
from types import NoneType
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.checks import listed, of_kind, real_vector
from dressing_sim.config import to_plain
from dressing_sim.control import RobotKinematics, Tracker, TrackingConfig, configuration_at
from dressing_sim.episode.capture import MotionCapture
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.judge import ProtectiveStop, judge, margins
from dressing_sim.episode.meter import Meter, Row
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.rule import Evidence, Rule
from dressing_sim.episode.rules import RULES
from dressing_sim.episode.snapshot import pack, unpack
from dressing_sim.episode.trace import Trace
from dressing_sim.errors import InvalidInputError
from dressing_sim.motion import UNITS
from dressing_sim.world.scene import WorldConfig, grip_start
from dressing_sim.world.simulation import World

#: A cloth whose vertices are all slower than this hangs still [m/s].
_SETTLED_SPEED = 0.05


@dataclass(frozen=True, slots=True)
class _Settled:
    """The world before the robot moves, to be copied, and how far it is from the right start."""

    world: World
    kinematics: RobotKinematics
    error: float


# Many policies dress the same arm in turn; the world that they all begin with is made once.
@lru_cache(maxsize=1)
def _settled(posture: Posture, config: WorldConfig, tracking: TrackingConfig) -> _Settled:
    """The cloth falls until it hangs still, for at most three times the settling time."""
    kinematics = RobotKinematics(config.robot)
    q, error = configuration_at(grip_start(posture, config.sleeve), kinematics, tracking)
    world = World(posture, config, q)
    while world.time < 3.0 * config.settle_time and world.invalid_reason is None:
        world.step()
        if world.time >= config.settle_time and world.cloth_speed < _SETTLED_SPEED:
            break
    return _Settled(world, kinematics, error)


class Dressing:
    """One dressing of one arm, advanced a control step at a time.

    ``reset`` begins it, ``step`` leads the gripper, ``done`` says that it is over and ``outcome``
    what came of it. Everything else that dresses (recording, replay, films, studies, environments)
    is a loop over these. The same calls give the same bits.

    Args:
        posture: The arm to dress.
        config: World, robot and thresholds.
        rules: What is judged.

    Attributes:
        posture: As given.
        config: As given, or the default.
        rules: As given.
        kinematics: The robot's kinematics.
        start_configuration: The robot's joint positions at the start, (n,) [rad].
        start: Where the gripper is at the start, (3,), in the robot's base frame [m].
        start_error: How far that is from where the sleeve should be held [m].
    """

    def __init__(
        self,
        posture: Posture,
        config: EpisodeConfig | None = None,
        rules: Sequence[Rule] = RULES,
    ) -> None:
        of_kind(posture, Posture, "posture", "a Posture")
        of_kind(config, (EpisodeConfig, NoneType), "config", "an EpisodeConfig or None")
        for rule in listed(rules, "rules", "a sequence of rules"):
            of_kind(rule, Rule, "a rule", "a Rule")
        self.posture = posture
        self.config = config or EpisodeConfig()
        self.rules = tuple(rules)
        tracking, world = self.config.tracking, self.config.world
        self._settled = _settled(posture, world, tracking)
        self.kinematics = self._settled.kinematics
        self.start_error = self._settled.error
        self.start = self._settled.world.tcp_position
        self.start_configuration = self._settled.world.arm_configuration
        self._tracker = Tracker(self.kinematics, tracking)
        self._substeps = round(tracking.dt / world.solver.timestep)
        self._capture = MotionCapture(posture, self.config.capture)
        self._measured = -1, posture
        self._steps_left = round(self.config.time_limit / tracking.dt)
        self._identity = json.dumps(
            [posture.to_dict(), to_plain(self.config), mujoco.__version__], sort_keys=True
        )
        self._begun = False

    def reset(
        self,
        command: NDArray[np.float64] | None = None,
        target: NDArray[np.float64] | None = None,
    ) -> Row:
        """Begin anew: the sleeve hangs still from the gripper, which is at `start`.

        Args:
            command: Joint positions (n,) [rad] that the servos are asked for at the start; those
                of the settled robot if not given.
            target: Where the gripper should be at the start, (3,) [m]; `start` if not given.

        Returns:
            What the instruments read before anything moves; it is no row of the trace.
        """
        config = self.config
        self._world = self._settled.world.copy()
        self._world.begin_motion()
        self._meter = Meter(self._world, config.tracking.dt, config.thresholds.strain_percentile)
        self._watch = ProtectiveStop(config.thresholds, config.tracking.dt, self.rules)
        self._measured = -1, self.posture
        self._stopped = False
        self._invalid = self._world.invalid_reason
        q = self._world.arm_configuration
        first = q if command is None else real_vector(command, len(q), "joint command has", "rad")
        velocity = (first - q) / config.tracking.dt
        self._target = self.start if target is None else real_vector(target, 3, "target has", "m")
        self._tracker.reset(first, velocity if command is not None else None, self._target)
        self._command, self._velocity = first, np.zeros_like(first)
        self._begun = True
        self._row = self._meter.look(self.start)
        return self._row

    def step(self, target: NDArray[np.float64], rotation: NDArray[np.float64] | None = None) -> Row:
        """Lead the gripper towards a target for one control step of ``config.tracking.dt``.

        Args:
            target: Gripper (3,), in the robot's base frame [m]. It is approached within the limits
                of `Tracker`, so a target far away is a direction.
            rotation: Orientation of the hand, see `Tracker.step`; without it the hand points down.

        Returns:
            What was measured. If the simulation broke down in this step, the row before; `done`
            and `outcome` then say so.

        Raises:
            InvalidInputError: The target is not finite, or the dressing is over.
        """
        self._check_goes_on()
        command = self._tracker.step(target, rotation)
        return self._advance(command, self._tracker.target)

    def step_joints(
        self, command: NDArray[np.float64], target: NDArray[np.float64] | None = None
    ) -> Row:
        """Play one joint command, such as a recorded one; like `step`, but nothing is tracked.

        Args:
            command: Joint positions (n,) [rad], as they come: their limits are not checked.
            target: Where the gripper should be, (3,) [m], for the tracking error; by the robot's
                kinematics if not given.
        """
        self._check_goes_on()
        q = real_vector(command, len(self._command), "joint command has", "rad")
        self._tracker.reset(q, (q - self._command) / self.config.tracking.dt)
        place = (
            self._tracker.target if target is None else real_vector(target, 3, "target has", "m")
        )
        return self._advance(q, place)

    def hold(self) -> Row:
        """Stay for one control step: the joints brake as hard as they may, then keep their command.

        A path that is played ends so; from rest not a bit of the command changes.
        """
        self._check_goes_on()
        dt, most = self.config.tracking.dt, np.array(self.config.world.robot.acceleration)
        slower = np.maximum(np.abs(self._velocity) - most * dt, 0.0)
        rest = self._command + dt * np.copysign(slower, self._velocity)
        return self.step_joints(rest, self._target)

    def _check_goes_on(self) -> None:
        if not self._begun:
            raise InvalidInputError("the dressing has not begun; valid is reset() before step()")
        if self.done:
            raise InvalidInputError("the dressing is over; valid is reset() before another step()")

    def _advance(self, command: NDArray[np.float64], target: NDArray[np.float64]) -> Row:
        dt = self.config.tracking.dt
        velocity = (command - self._command) / dt
        move, faster = command - self._command, velocity - self._velocity
        for number in range(1, self._substeps + 1):
            share = number / self._substeps
            self._world.command(self._command + share * move, self._velocity + share * faster)
            self._world.step()
            self._meter.observe_physics()
        self._invalid = self._world.invalid_reason
        # The world tells where the gripper was one physics step ago.
        now = target - (target - self._target) / self._substeps
        self._command, self._velocity, self._target = command, velocity, target
        if self._invalid is None:
            self._row = self._meter.read(now)
            self._stopped = bool(self._watch.observe(self._row.limited())) or self._stopped
        return self._row

    @property
    def world(self) -> World:
        """The simulation, to be looked at; it is another one after each `reset`."""
        self._check_begun()
        return self._world

    @property
    def invalid(self) -> str | None:
        """Why the simulation can no longer be trusted, or None."""
        return self._invalid if self._begun else self._settled.world.invalid_reason

    @property
    def done(self) -> bool:
        """Whether it is over: the robot stopped, its time is up, or the simulation broke down."""
        if not self._begun:
            return False
        over = self._stopped and self.config.protective_stop
        return over or self.invalid is not None or len(self._meter) >= self._steps_left

    @property
    def stopped(self) -> bool:
        """Whether a rule that ends the episode has been broken."""
        return self._begun and self._stopped

    @property
    def shoulder(self) -> NDArray[np.float64]:
        """Where the shoulder joint is, (3,), in the robot's base frame [m]."""
        return self._world.arm_joints[2] if self._begun else self._settled.world.arm_joints[2]

    @property
    def seen(self) -> Posture:
        """The arm as far as a policy may know it now: as it is, or as measured, see `capture`."""
        still = self.posture.motion is None
        if still and not self.config.capture.still:
            return self.posture
        number = self._capture.newest(self._row.time) if self._begun and not still else 0
        if number != self._measured[0]:
            step = int(self._capture.taken(number) / self.config.tracking.dt + 1e-9)
            person = self._meter.person(step) if self._begun else self._settled.world.person
            if person is None:
                person = self.posture.coordinates * UNITS
            self._measured = number, self._capture.measured(number, person)
        return self._measured[1]

    @property
    def command(self) -> NDArray[np.float64]:
        """The last joint command (n,) [rad]."""
        self._check_begun()
        return self._command.copy()

    @property
    def target(self) -> NDArray[np.float64]:
        """The target (3,) that the gripper last approached [m]."""
        self._check_begun()
        return self._target.copy()

    @property
    def target_error(self) -> float:
        """How far the last command's gripper is from its target [m], by the kinematics."""
        return self._tracker.error

    @property
    def row(self) -> Row:
        """What was measured last."""
        self._check_begun()
        return self._row

    def trace(self) -> Trace:
        """What was measured so far, one row a step.

        Raises:
            InvalidInputError: Nothing was.
        """
        self._check_begun()
        if not len(self._meter):
            raise InvalidInputError("nothing was measured; valid is a trace after one step or more")
        return self._meter.trace()

    def outcome(self, finished: bool | None = None) -> Outcome:
        """The verdict on what happened so far.

        Args:
            finished: Whether the robot did all that it wanted to; unless given, whether there was
                time left.
        """
        if self.invalid is not None and not self.stopped:
            return Outcome(False, invalid=self.invalid)
        return judge(
            self.trace(),
            self.posture.shoulder,
            len(self._meter) < self._steps_left if finished is None else finished,
            self.config.thresholds,
            self.rules,
        )

    def margins(
        self, time_left: float | None = None, reach_left: float | None = None
    ) -> dict[str, float]:
        """Signed margin of each rule by its name, see `dressing_sim.episode.judge.margins`.

        Args:
            time_left: What was left of the time when the robot had done all that it wanted to [s];
                unless given, what is left now.
            reach_left: How much farther from its targets the commanded gripper might have been
                [m]; unless given, with the target of the last step.
        """
        trace, config = self.trace(), self.config
        left = (self._steps_left - len(self._meter)) * config.tracking.dt
        off = max(self.start_error, self.target_error)
        evidence = Evidence(
            trace,
            self.posture.shoulder,
            (left if left > 0.0 else -config.tracking.dt) if time_left is None else time_left,
            config.thresholds,
            config.world.robot.grip_strength,
            config.tracking.max_error - off if reach_left is None else reach_left,
            self._world.robot_clearance(trace.joint_position, self._meter.persons),
        )
        return margins(evidence, self.rules)

    def _check_begun(self) -> None:
        if not self._begun:
            raise InvalidInputError("the dressing has not begun; valid is reset() first")

    def snapshot(self) -> bytes:
        """This moment, to go on from: `restore` does, in this process or in another."""
        self._check_begun()
        row = {one.name: getattr(self._row, one.name) for one in fields(Row)}
        arrays = {
            **{f"world.{name}": array for name, array in self._world.state().items()},
            **{f"trace.{name}": array for name, array in self._meter.columns().items()},
            **{f"row.{name}": np.asarray(value) for name, value in row.items()},
            "command": self._command,
            "velocity": self._velocity,
            "target": self._target,
            "tracker.command": self._tracker.command,
            "tracker.velocity": self._tracker.velocity,
            "tracker.target": self._tracker.target,
            "tracker.speed": np.asarray(self._tracker.speed),
        }
        values = {"stopped": self._stopped, "invalid": self._invalid, "runs": self._watch.runs}
        return pack(self._identity, values, arrays)

    def restore(self, snapshot: bytes) -> Row:
        """Go back, or forward, to a moment of a dressing of the same posture and configuration.

        Returns:
            What was measured last before that moment.

        Raises:
            InvalidInputError: It is damaged, or of another version, posture or configuration.
        """
        values, arrays = unpack(snapshot, self._identity)
        if not self._begun:
            self.reset()
        self._world.restore(_part("world.", arrays))
        self._meter.restore(_part("trace.", arrays))
        self._measured = -1, self.posture
        self._watch.runs = {name: list(runs) for name, runs in values["runs"].items()}
        self._stopped, self._invalid = values["stopped"], values["invalid"]
        self._command, self._velocity = arrays["command"].copy(), arrays["velocity"].copy()
        self._target = arrays["target"].copy()
        tracked = _part("tracker.", arrays)
        self._tracker.reset(
            tracked["command"], tracked["velocity"], tracked["target"], float(tracked["speed"])
        )
        found = _part("row.", arrays)
        row: dict[str, Any] = {
            name: a.item() if a.ndim == 0 else a.copy() for name, a in found.items()
        }
        self._row = Row(**row)
        return self._row


def _part(prefix: str, arrays: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {n.removeprefix(prefix): a for n, a in arrays.items() if n.startswith(prefix)}
