"""What can be pressed and read to dress: the arm, the garment, the policy, time, and plots.

Each panel tells the session what was asked for, and shows what the session has.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import ANGLE_LIMITS_DEG, ARM_SIZES
from dressing_sim.suites.suites import load_suite
from dressing_sim.viewer.choices import (
    AUGMENTATIONS,
    FRICTION,
    PLAIN,
    SUITES,
    TAKES,
    policies,
)
from dressing_sim.viewer.live import Live, Moment
from dressing_sim.viewer.session import Session
from dressing_sim.world.garment import GARMENTS

if TYPE_CHECKING:
    import viser

#: Arms to begin with.
_KNOWN = ("paper5", "case_a", "case_b", "baseline7")

#: How fast time may go, by what the page calls it.
SPEEDS = {"half": 0.5, "real time": 1.0, "double": 2.0, "as fast as it goes": 0.0}

#: What is plotted: its title, its colour, and the top of its axis.
_PLOTTED = (
    ("Pull on the cloth [N]", "#c81e1e", 14.0),
    ("Strain (95 % of the area is below)", "#7a3fb0", 0.45),
    ("Arm coordinate s: 0 wrist, 1 elbow, 2 shoulder", "#1c6fb5", 2.3),
)

#: Points of a plot; more are not seen.
_POINTS = 250


def when_asked(handle: Any, asked: Callable[[], None]) -> None:
    """Call when somebody changes a control, but not when the page itself does."""

    def changed(event: viser.GuiEvent[Any]) -> None:
        if event.client_id is not None:
            asked()

    handle.on_update(changed)


def when_pressed(button: viser.GuiButtonHandle, pressed: Callable[[], None]) -> None:
    """Call when a button is pressed."""
    button.on_click(lambda event: pressed())


class Shown:
    """What controls show. What somebody is just changing is left alone."""

    def __init__(self) -> None:
        self._values: dict[int, object] = {}

    def put(self, control: Any, value: object) -> None:
        """Show a value, unless it is what was shown or read last."""
        if self._values.get(id(control)) != value:
            self._values[id(control)] = control.value = value

    def read(self, control: Any) -> Any:
        """The value that somebody has chosen."""
        self._values[id(control)] = value = control.value
        return value


class ArmPanel:
    """Which arm is dressed, with what, and by whom."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session, self._shown = session, Shown()
        chosen = session.choices
        self._known = {p.name: p for suite in _KNOWN for p in load_suite(suite)}
        with gui.add_folder("Arm"):
            names = ("as below", *self._known)
            first = chosen.posture.name if chosen.posture.name in self._known else names[0]
            self._name = gui.add_dropdown("Posture", names, initial_value=first)
            self._angles = {
                name: gui.add_slider(
                    f"{name.removesuffix('_deg').capitalize()} [°]",
                    low,
                    high,
                    0.5,
                    float(getattr(chosen.posture, name)),
                )
                for name, (low, high) in ANGLE_LIMITS_DEG.items()
            }
            self._size = gui.add_dropdown("Size", (*ARM_SIZES, "own"), initial_value="male")
        with gui.add_folder("Garment"):
            self._garment = gui.add_dropdown("Garment", (*GARMENTS,), initial_value=chosen.garment)
            self._friction = gui.add_slider("Friction", *FRICTION, 0.01, chosen.own_friction)
        with gui.add_folder("Policy"):
            self._policy = gui.add_dropdown("Policy", policies(), initial_value=chosen.policy)
            self._augmentation = gui.add_dropdown(
                "Augmentation",
                (*AUGMENTATIONS,),
                initial_value=chosen.augmentation,
                hint="How Algorithm 1 makes synthetic demonstrations; of tp-gmm alone",
                visible=chosen.policy == PLAIN,
            )
            self._learned = gui.add_dropdown(
                "Learns from", (*SUITES, TAKES), initial_value=chosen.demonstrations
            )
            self._seed = gui.add_number("Seed", chosen.seed, min=0, max=2**31, step=1)
        when_asked(self._name, self._named)
        for slider in self._angles.values():
            when_asked(slider, self._bent)
        when_asked(self._size, self._sized)
        when_asked(self._garment, self._dressed)
        when_asked(self._friction, self._rubbed)
        for control in (self._policy, self._augmentation, self._learned, self._seed):
            when_asked(control, self._taught)

    def _named(self) -> None:
        posture = self._known.get(self._shown.read(self._name))
        if posture is not None:
            self._session.choose_by(lambda choices: replace(choices, posture=posture))

    def _bent(self) -> None:
        angles = {name: float(self._shown.read(one)) for name, one in self._angles.items()}
        self._session.choose_by(lambda choices: choices.bent(**angles))

    def _sized(self) -> None:
        size = self._shown.read(self._size)
        self._session.choose_by(lambda choices: choices.sized(size))

    def _dressed(self) -> None:
        garment = self._shown.read(self._garment)
        self._session.choose_by(lambda choices: replace(choices, garment=garment, friction=None))

    def _rubbed(self) -> None:
        friction = float(self._shown.read(self._friction))
        self._session.choose_by(lambda choices: replace(choices, friction=friction))

    def _taught(self) -> None:
        read = self._shown.read
        policy, augmentation = read(self._policy), read(self._augmentation)
        learned, seed = read(self._learned), int(read(self._seed))
        self._session.choose_by(
            lambda choices: replace(
                choices,
                policy=policy,
                augmentation=augmentation,
                demonstrations=learned,
                seed=seed,
            )
        )

    def show(self) -> None:
        """What is chosen, whoever chose it."""
        chosen, put = self._session.choices, self._shown.put
        posture = chosen.posture
        put(self._name, posture.name if posture.name in self._known else "as below")
        for name, slider in self._angles.items():
            put(slider, float(getattr(posture, name)))
        put(self._size, posture.size if isinstance(posture.size, str) else "own")
        put(self._garment, chosen.garment)
        put(self._friction, chosen.own_friction)
        put(self._policy, chosen.policy)
        put(self._augmentation, chosen.augmentation)
        put(self._learned, chosen.demonstrations)
        put(self._seed, chosen.seed)
        self._augmentation.visible = chosen.policy == PLAIN


class TimePanel:
    """Time: dress, pause, step, look back, go on from there."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session, self._shown = session, Shown()
        self.dress = gui.add_button("Dress", color="teal", hint="Simulate the chosen dressing")
        self._go = gui.add_button("Pause", hint="Or go on from the moment that is looked at")
        self._step = gui.add_button("Single step", hint="20 ms")
        self._time = gui.add_slider("Time [s]", 0.0, 30.0, 0.02, 0.0)
        speeds = (*SPEEDS,)
        self._speed = gui.add_dropdown("Speed", speeds, initial_value="real time")
        self._hand = gui.add_button(
            "Lead by hand from here", hint="Takes the gripper at the moment that is looked at"
        )
        when_pressed(self.dress, session.dress)
        when_pressed(self._go, lambda: session.pause() if session.running else session.go_on())
        when_pressed(self._step, session.step_once)
        when_pressed(self._hand, session.take_over)
        when_asked(self._time, self._looked)
        when_asked(self._speed, lambda: session.set_speed(SPEEDS.get(self._speed.value, 1.0)))

    def _looked(self) -> None:
        live = self._session.live
        if live is not None:
            dt = live.dressing.config.tracking.dt
            self._session.look_at(max(0, round(float(self._shown.read(self._time)) / dt)))

    def show(self) -> None:
        """Where in time the page is."""
        session, live = self._session, self._session.live
        there = live is not None and session.showing
        back = live is not None and session.at is not None and session.at < live.n_steps
        self._go.label = "Pause" if session.running else "Go on from here" if back else "Go on"
        self._go.disabled = not there or (live is not None and live.over and not back)
        self._step.disabled = self._go.disabled or session.running
        self._hand.disabled = self._go.disabled
        self._time.disabled = not there
        if live is not None and there:
            dt = live.dressing.config.tracking.dt
            at = live.n_steps if session.at is None else min(session.at, live.n_steps)
            self._time.max = max(round(live.n_steps * dt, 3), 0.02)
            self._shown.put(self._time, round(min(at * dt, self._time.max), 3))


class Plots:
    """Force, strain and arm coordinate over time, with what a verdict allows."""

    def __init__(self, gui: viser.GuiApi, series: Callable[..., Any], height: int = 150) -> None:
        self._plots = []
        nothing = np.array([0.0, 1.0])
        for title, colour, top in _PLOTTED:
            plot = gui.add_uplot(
                (nothing, *[np.zeros(2)] * 3),
                (
                    series(label="t [s]"),
                    series(label="other", stroke="#5a3cc8", width=1),
                    series(label="limit", stroke="#888888", dash=(6, 4)),
                    series(label="now", stroke=colour, width=2),
                ),
                title=title,
                height=height,
                legend={"show": False},
                scales={"x": {"time": False}, "y": {"range": (0.0, top)}},
            )
            self._plots.append(plot)

    def show(self, live: Live, moments: Sequence[Moment], beside: Live | None) -> None:
        """What was measured until now, and in another dressing."""
        limits = live.dressing.config.thresholds
        longest = max(moments, beside.moments if beside else [], key=len)
        chosen = np.unique(np.linspace(0, len(longest) - 1, min(len(longest), _POINTS)).astype(int))
        if len(chosen) < 2:
            return
        time = np.array([longest[at].row.time for at in chosen])
        mine = _columns(moments, chosen)
        other = mine if beside is None else _columns(beside.moments, chosen)
        allowed = (limits.grip_force, limits.strain, limits.armscye_s)
        for number, plot in enumerate(self._plots):
            limit = np.full(len(chosen), allowed[number])
            plot.data = (time, other[number], limit, mine[number])


def _columns(moments: Sequence[Moment], chosen: NDArray[np.intp]) -> NDArray[np.float64]:
    """Pull, strain and arm coordinate (3, n) of chosen moments; the last one's after it."""
    names = ("grip_force", "strain", "armscye_s")
    rows = [moments[min(at, len(moments) - 1)].row for at in chosen]
    return np.array([[getattr(row, name) for row in rows] for name in names])
