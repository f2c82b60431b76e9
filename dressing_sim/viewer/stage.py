"""The scene in the browser: person, robot, cloth, paths and forces, drawn from what a session has.

Only what has changed is sent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from dressing_sim.arm import LEFT, UP, Posture
from dressing_sim.path import Path
from dressing_sim.pictures.person import SEAT
from dressing_sim.viewer.leaders import ByHand
from dressing_sim.viewer.live import Live, Moment
from dressing_sim.viewer.preview import Preview
from dressing_sim.viewer.scenery import furnish
from dressing_sim.viewer.shapes import (
    Cloth,
    Mesh,
    Robot,
    person,
    strain_colours,
)
from dressing_sim.viewer.signs import Signs
from dressing_sim.world.mannequin import SHOULDER_TO_MIDLINE
from dressing_sim.world.sleeve import SleeveMesh

if TYPE_CHECKING:
    import viser

#: Size of what the person sits on [m].
_STOOL = (0.36, 0.40, 0.06)

Points = NDArray[np.float64] | NDArray[np.float32]

#: Colours of lines: the policy's path, the gripper's way, the guide, the other dressing.
_PATH, _WAY, _GUIDE, _OTHER = (230, 120, 20), (40, 40, 40), (0, 150, 110), (90, 60, 200)

#: Colour of the ball that leads the gripper.
_BALL = (255, 140, 0)

_NO_FACES = np.zeros((0, 3), dtype=np.uint32)


class Stage:
    """Draws into the scene that all tabs share.

    Args:
        server: Of viser.

    Attributes:
        elbow: Drag it to bend the arm.
        wrist: Likewise.
        gripper: Arrows to drag the gripper along one axis.
        ball: Drag it to lead the gripper anywhere.
        held: Name of the handle that is being dragged, or None.
        portrayed: Whether the person is drawn as in films, not as capsules.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = scene = server.scene
        scene.set_up_direction("+z")
        furnish(scene)
        camera = server.initial_camera
        camera.position, camera.look_at = (-0.05, 1.05, 0.80), (0.40, -0.12, 0.22)
        camera.fov = np.deg2rad(46.0)
        first = person(Posture("first", 0.0, 0.0, 0.0, 0.0))
        self._person = {
            name: scene.add_mesh_simple(f"/person/{name}", m.vertices, m.faces, color=m.colour)
            for name, m in first.items()
        }
        self._likeness: dict[str, viser.MeshHandle] = {}
        self._stool = scene.add_box("/person/stool", (70, 76, 86), _STOOL)
        none = np.zeros((3, 3), dtype=np.float32)
        self._cloth = [
            scene.add_mesh_simple(
                f"/cloth/{number}", none, _NO_FACES, color=colour, side="double", visible=False
            )
            for number, colour in enumerate(strain_colours())
        ]
        self._other = scene.add_mesh_simple(
            "/other", none, _NO_FACES, color=_OTHER, side="double", opacity=0.35, visible=False
        )
        self._frames = {
            name: scene.add_frame(f"/frames/{name}", axes_length=0.10, axes_radius=0.004)
            for name in ("shoulder", "wrist")
        }
        self._lines: dict[str, tuple[object, viser.SceneNodeHandle]] = {}
        self._signs = Signs(scene)
        self.elbow = self._handle("elbow", 0.13)
        self.wrist = self._handle("wrist", 0.13)
        self.gripper = self._handle("gripper", 0.16)
        self.gripper.disable_sliders = True
        self.ball = scene.add_icosphere(
            "/handles/ball", 0.04, _BALL, opacity=0.75, cast_shadow=False, visible=False
        )
        self.gripper.visible = False
        self.held: str | None = None
        self.portrayed = False
        self._robot: Robot | None = None
        self._links: dict[str, viser.FrameHandle] = {}
        self._drawn: dict[str, object] = {}
        self._sewn: tuple[SleeveMesh, Cloth] | None = None

    def _handle(self, name: str, scale: float) -> viser.TransformControlsHandle:
        return self._scene.add_transform_controls(
            f"/handles/{name}", scale=scale, disable_rotations=True, depth_test=False, opacity=0.8
        )

    def add_robot(self, robot: Robot) -> None:
        """Add the robot, once its skin is known."""
        for link, meshes in robot.skin.items():
            self._links[link] = self._scene.add_frame(f"/robot/{link}", show_axes=False)
            for number, mesh in enumerate(meshes):
                name = f"/robot/{link}/{number}"
                self._scene.add_mesh_simple(name, mesh.vertices, mesh.faces, color=mesh.colour)
        self._robot = robot

    def _news(self, name: str, value: object) -> bool:
        """Whether something is not what was drawn last; it is from now on."""
        if self._drawn.get(name, self) is value:
            return False
        self._drawn[name] = value
        return True

    def draw_arm(self, posture: Posture) -> None:
        """The person, its frames, and the handles to bend the arm with."""
        if self._drawn.get("posture") == posture:
            return
        self._drawn["posture"] = posture
        for name, mesh in person(posture).items():
            self._person[name].vertices = mesh.vertices
            self._person[name].visible = True
        for mesh_handle in self._likeness.values():
            mesh_handle.visible = False
        self.portrayed = False
        self._stool.position = posture.shoulder - SHOULDER_TO_MIDLINE * LEFT - SEAT * UP
        for name, frame in zip(self._frames, posture.frames(), strict=True):
            self._frames[name].position = frame.b
            self._frames[name].wxyz = Rotation.from_matrix(frame.A).as_quat(scalar_first=True)
        for name, handle in (("elbow", self.elbow), ("wrist", self.wrist)):
            if name != self.held:  # it is where the mouse is
                handle.position = getattr(posture, name)

    def draw_likeness(self, posture: Posture, meshes: Mapping[str, Mesh]) -> None:
        """The person as films draw it, in place of its capsules, while this is its posture."""
        if self.portrayed or self._drawn.get("posture") != posture:
            return
        for name, mesh in meshes.items():
            handle = self._likeness.get(name)
            if handle is None:
                self._likeness[name] = self._scene.add_mesh_simple(
                    f"/person/drawn/{name}", mesh.vertices, mesh.faces, color=mesh.colour
                )
            else:
                handle.vertices, handle.faces, handle.visible = mesh.vertices, mesh.faces, True
        for capsules in self._person.values():
            capsules.visible = False
        self.portrayed = True

    def hold(self, name: str | None) -> None:
        """Somebody begins to drag a handle, or lets it go: it then snaps back to its place."""
        self.held = name
        for what in ("posture", "target"):
            self._drawn.pop(what, None)

    def draw_handles(self, bend: bool, leader: ByHand | None, fresh: bool = False) -> None:
        """Which handles are there: to bend the arm, or for somebody to lead the gripper.

        Args:
            bend: Whether the arm can be bent.
            leader: Who leads by hand, or None.
            fresh: Whether the gripper has not been led yet.
        """
        if self._news("bend", bend):
            self.elbow.visible = self.wrist.visible = bend
        if self._news("leader", leader):
            self.ball.visible = self.gripper.visible = leader is not None
        place = None if leader is None else leader.target
        if self._news("target", place) and place is not None:
            self.ball.position = place
            if self.held != "gripper":  # it is where the mouse is
                self.gripper.position = place
        if self._news("fresh", place if fresh else None):
            self._signs.put("ball", "drag me" if fresh else "", place)

    def draw_failure(self, live: Live | None) -> None:
        """A label where the first thing went wrong in a dressing that is over, or none."""
        if self._news("failure", None if live is None else live.outcome):
            self._signs.failure(live)

    def draw_preview(self, shown: Preview) -> None:
        """The sleeve before it falls, and the path that the policy would take."""
        if not self._news("preview", shown):
            return
        self._drawn.pop("moment", None)
        self._draw_cloth(shown.sleeve, shown.sleeve.vertices.astype(np.float32), 0.3)
        self._line("path", None if shown.path is None else shown.path.positions, _PATH, 3.0)
        self._line("way", None, _WAY, 4.0)
        self._signs.forces(shown.posture, None)

    def draw_robot(self, q: NDArray[np.float64]) -> None:
        """The robot with joint positions (7,) [rad]."""
        if self._robot is None:
            return
        for link, (position, quaternion) in self._robot.poses(q).items():
            self._links[link].position, self._links[link].wxyz = position, quaternion

    def draw_moment(self, live: Live, moment: Moment, way: Sequence[Moment]) -> None:
        """A moment of a dressing, and the way (the moments until then) of the gripper."""
        if not self._news("moment", moment):
            return
        self._drawn.pop("preview", None)
        top = live.dressing.config.thresholds.strain
        self._draw_cloth(live.dressing.world.mesh, moment.cloth, top)
        self.draw_robot(moment.row.joint_position)
        self._line("path", None if live.path is None else live.path.positions, _PATH, 3.0)
        self._line("way", _thinned(way), _WAY, 4.0)
        self._signs.forces(moment.arm, moment)

    def draw_other(self, live: Live | None, at: int) -> None:
        """Another dressing at the same step: its cloth, and the way of its gripper."""
        moment = None if live is None else live.moments[min(at, live.n_steps)]
        if not self._news("other", moment):
            return
        self._other.visible = moment is not None
        if live is not None and moment is not None:
            mesh, top = live.dressing.world.mesh, live.dressing.config.thresholds.strain
            self._other.vertices, self._other.faces = Cloth(mesh, top).plain(moment.cloth)
        self._line("other", None if live is None else _thinned(live.moments), _OTHER, 3.0)

    def draw_guide(self, path: Path | None) -> None:
        """A path to teach along, or none."""
        if self._news("guide", path):
            points = None if path is None else path.positions
            self._line("guide", points, _GUIDE, 5.0)
            self._signs.put("end", "to here", None if points is None else points[-1])

    def _cloth_of(self, mesh: SleeveMesh, top: float) -> Cloth:
        if self._sewn is None or self._sewn[0] is not mesh:
            self._sewn = mesh, Cloth(mesh, top)
        return self._sewn[1]

    def _draw_cloth(self, mesh: SleeveMesh, cloth: NDArray[np.float32], top: float) -> None:
        vertices, parts = self._cloth_of(mesh, top).drawn(cloth)
        for handle, faces in zip(self._cloth, parts, strict=True):
            if len(faces):
                handle.vertices, handle.faces = vertices, faces
            handle.visible = len(faces) > 0

    def _line(
        self, name: str, points: Points | None, colour: tuple[int, int, int], width: float
    ) -> None:
        """A line of a name through points (n, 3); none for fewer than two."""
        before = self._lines.get(name)
        if before is not None and before[0] is points:
            return
        if points is None or len(points) < 2:
            if before is not None:
                before[1].remove()
                del self._lines[name]
            return
        ends = np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
        handle = self._scene.add_line_segments(
            f"/lines/{name}", ends, colors=colour, thickness=width, thickness_units="screen"
        )
        self._lines[name] = points, handle


def _thinned(moments: Sequence[Moment]) -> NDArray[np.float64]:
    """The gripper's way (n, 3) [m], not finer than is seen."""
    step = max(1, len(moments) // 150)
    return np.array([moment.row.tcp for moment in [*moments[::step], moments[-1]]])
