"""The page: a server on this machine, and a loop that draws what a session has."""

from __future__ import annotations

import io
import logging
import socket
import threading
import time
from collections.abc import Mapping
from contextlib import redirect_stdout
from typing import TYPE_CHECKING, Any

import numpy as np

from dressing_sim.arm import Posture
from dressing_sim.checks import whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.extras import needed
from dressing_sim.viewer.panels import ArmPanel, Plots, TimePanel, when_pressed
from dressing_sim.viewer.run_panel import RunPanel
from dressing_sim.viewer.session import Session
from dressing_sim.viewer.shapes import Mesh, Robot, likeness
from dressing_sim.viewer.stage import Stage
from dressing_sim.viewer.teach_panel import TeachPanel
from dressing_sim.viewer.words import state, strain_legend

if TYPE_CHECKING:
    import viser

_LOG = logging.getLogger("dressing_sim")

#: Pictures a second that are sent, and plots.
_FPS, _PLOTS = 25.0, 3.0

#: An arm that stands still for so long, or twice, is drawn as in films [s].
_STILL = 0.3


def check_port(host: str, port: int) -> None:
    """Raise InvalidInputError unless a server can listen there."""
    whole_number(port, "port", 0, 65535)
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        family, kind, protocol, _, address = addresses[0]
        with socket.socket(family, kind, protocol) as tried:
            tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            tried.bind(address)
            tried.listen(1)
    except OSError as error:
        why = error.strerror or str(error)
        raise InvalidInputError(
            f"port {port} on {host} cannot be used ({why}); valid is a free one: choose another "
            "--port, or --port 0 for any"
        ) from error


def _server(library: Any, host: str, port: int) -> viser.ViserServer:
    """A server that listens at this port and no other, and that says nothing."""
    check_port(host, port)

    class Local(library.ViserServer):
        """Nobody makes the page public: a client may otherwise ask for a tunnel to it."""

        def request_share_url(self, verbose: bool = True) -> None:
            """None is made."""

    with redirect_stdout(io.StringIO()):
        server: viser.ViserServer = Local(host=host, port=port, label="dressing-sim", verbose=False)
    if port not in (0, server.get_port()):  # somebody was quicker, and viser took the next one
        server.stop()
        raise InvalidInputError(f"port {port} on {host} was just taken; valid is a free one")
    return server


class Page:
    """The page of a session.

    Args:
        session: What it shows.
        host: Address to listen at.
        port: Port to listen at; 0 for any.

    Raises:
        InvalidInputError: The port cannot be used, or viser is not installed.
    """

    def __init__(self, session: Session, host: str = "127.0.0.1", port: int = 8080) -> None:
        library = needed("viser", "view")
        self.session = session
        self._server: viser.ViserServer = _server(library, host, port)
        gui = self._server.gui
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")
        gui.main_panel.dock_right()
        self._stage = Stage(self._server)
        self._said = gui.add_markdown("")
        self._wrong = gui.add_button("See where it went wrong", color="orange", visible=False)
        when_pressed(self._wrong, session.look_at_failure)
        self._tabs = gui.add_tab_group()
        with self._tabs.add_tab("Dress"):
            self._time = TimePanel(gui, session)
        with self._tabs.add_tab("Teach"):
            self._teach = TeachPanel(gui, session)
        self._run: RunPanel | None = None
        if session.past is not None:
            with self._tabs.add_tab("Run"):
                self._run = RunPanel(self._server, session, session.past)
        self._arm = ArmPanel(gui, session)
        beside = gui.add_panel()
        with beside.add_tab("Measured"):
            self._plots = Plots(gui, library.uplot.Series)
            gui.add_html(strain_legend(0.3))
        beside.dock_left()
        beside.set_width(300)
        for joint in ("elbow", "wrist"):
            self._follow_joint(joint)
        self._follow_gripper()
        self._closed, self._robot_there = threading.Event(), threading.Event()
        self._painted, self._seen = threading.Condition(), -1
        self._plotted = 0.0
        self._portrait: tuple[Posture, Mapping[str, Mesh]] | None = None
        self._threads = [
            threading.Thread(target=work, name=f"page-{work.__name__}", daemon=True)
            for work in (self._paint, self._load_robot, self._portray)
        ]
        for thread in self._threads:
            thread.start()
        session.choose(session.choices)

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._server.get_port())

    @property
    def n_messages(self) -> int:
        """Messages that are kept for tabs that will be opened."""
        return len(self._server._websock_server._broadcast_buffer.message_from_id)

    def wait_until_drawn(self, timeout: float) -> bool:
        """Wait until all tabs have been told what the session has now; whether they have."""
        with self._painted:
            return self._painted.wait_for(lambda: self._seen >= self.session.version, timeout)

    def close(self) -> None:
        """Stop serving."""
        self._closed.set()
        self.session.close()
        self._server.stop()

    def _follow_joint(self, joint: str) -> None:
        handle = getattr(self._stage, joint)

        def moved(event: viser.TransformControlsEvent) -> None:
            place = np.array(handle.position)
            self.session.choose_by(lambda choices: choices.dragged(joint, place))

        self._hold(handle, joint)
        handle.on_update(moved)

    def _hold(self, handle: viser.TransformControlsHandle, name: str) -> None:
        """Remember which handle somebody has in the hand."""

        # What is awaited comes in order; what follows the handle has a thread of its own.
        async def held(event: viser.TransformControlsEvent) -> None:
            if event.phase != "update":
                self._stage.hold(name if event.phase == "start" else None)
                self.session.tell()

        handle.on_update(held)

    def _follow_gripper(self) -> None:
        """Somebody leads the gripper by its arrows, or by the ball round it."""
        session, arrows, ball = self.session, self._stage.gripper, self._stage.ball
        grip = np.zeros(3)  # where the ball is gripped, from its centre

        async def moved(event: viser.TransformControlsEvent) -> None:
            if event.phase == "update":
                session.lead(np.array(arrows.position))

        async def dragged(event: viser.SceneNodeDragEvent[Any]) -> None:
            if event.phase == "start":
                grip[:] = np.array(event.start_position) - np.array(ball.position)
            eye = np.array(event.client.camera.position)
            session.point(eye, np.array(event.end_position) - grip)
            session.tell()

        self._hold(arrows, "gripper")
        arrows.on_update(moved)
        ball.on_drag(dragged)

    def wait_for_robot(self, timeout: float) -> bool:
        """Wait until the robot's skin is there, which takes some seconds; whether it is."""
        return self._robot_there.wait(timeout)

    def _load_robot(self) -> None:
        robot = Robot()
        with self._server.atomic():
            self._stage.add_robot(robot)
        self._robot_there.set()
        self.session.tell()

    def wait_for_likeness(self, timeout: float) -> bool:
        """Wait until the person is drawn as in films, if its arm stays as it is; whether it is."""
        with self._painted:
            return self._painted.wait_for(lambda: self._stage.portrayed, timeout)

    def _portray(self) -> None:
        """Prepare the person as films draw it, whenever its arm has been still for a moment."""
        seen: Posture | None = None
        while not self._closed.wait(_STILL):
            before, seen = seen, self._posture()
            drawn = None if self._portrait is None else self._portrait[0]
            if seen is not None and seen == before != drawn:
                self._portrait = seen, likeness(seen)
                self.session.tell()

    def _posture(self) -> Posture | None:
        """The arm that is looked at."""
        live, preview = self.session.live, self.session.preview
        if self.session.showing and live is not None:
            return live.dressing.posture
        return None if preview is None else preview.posture

    def _paint(self) -> None:
        while not self._closed.is_set():
            now = self.session.news(self._seen, 0.2)
            if now == self._seen:
                continue
            begun = time.perf_counter()
            try:
                with self._server.atomic():
                    self._draw()
                    self._tell()
            except Exception:  # the next picture may be fine, and the session goes on anyway
                _LOG.exception("the page: a picture was left out")
            with self._painted:
                self._seen = now
                self._painted.notify_all()
            self._closed.wait(max(0.0, 1.0 / _FPS - (time.perf_counter() - begun)))

    def _draw(self) -> None:
        session, stage = self.session, self._stage
        live, moments = session.live, session.moments()
        moment = session.moment()
        if session.showing and live is not None and moment is not None:
            at = len(moments) - 1 if session.at is None else min(session.at, len(moments) - 1)
            stage.draw_arm(moment.arm)
            stage.draw_moment(live, moment, moments[: at + 1])
            stage.draw_other(session.beside, at)
            hand = session.hand if session.at is None else None
            guide = None if hand is None else session.guide
            stage.draw_handles(bend=False, leader=hand, fresh=live.n_steps == 0)
            stage.draw_guide(None if guide is None else guide.path)
            stage.draw_failure(live)
        elif session.preview is not None:
            stage.draw_arm(session.preview.posture)
            stage.draw_preview(session.preview)
            stage.draw_other(None, 0)
            stage.draw_guide(None)
            stage.draw_failure(None)
            stage.draw_handles(bend=True, leader=None)
            if session.rest is not None:
                stage.draw_robot(session.rest)
        if self._portrait is not None:
            stage.draw_likeness(*self._portrait)

    def _tell(self) -> None:
        session = self.session
        self._said.content = state(session)
        self._wrong.visible = session.failed_at is not None and session.at is None
        self._arm.show()
        self._time.show()
        self._teach.show()
        if self._run is not None:
            self._run.show()
        live, now = session.live, time.perf_counter()
        due = now - self._plotted > 1.0 / _PLOTS or not session.running
        if live is not None and session.showing and due:
            self._plotted = now
            self._plots.show(live, session.moments(), session.beside)
