"""The scene in the browser: person, robot, cloth, paths and forces, drawn from what a session has.

Only what has changed is sent.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from dressing_sim.arm import Posture
from dressing_sim.path import Path
from dressing_sim.viewer.live import ByHand, Live, Moment
from dressing_sim.viewer.preview import Preview
from dressing_sim.viewer.shapes import (
    Cloth,
    Robot,
    link_centres,
    person,
    strain_colours,
)
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.sleeve import SleeveMesh

if TYPE_CHECKING:
    import viser

Points = NDArray[np.float64] | NDArray[np.float32]

#: Colours of lines: the policy's path, the gripper's way, the guide, the other dressing.
_PATH, _WAY, _GUIDE, _OTHER = (230, 120, 20), (40, 40, 40), (0, 150, 110), (90, 60, 200)

#: Length of an arrow for each newton [m].
_PER_NEWTON = 0.03

#: Forces below this have no arrow [N].
_LEAST = 0.05

_NO_FACES = np.zeros((0, 3), dtype=np.uint32)


class Stage:
    """Draws into the scene that all tabs share.

    Args:
        server: Of viser.

    Attributes:
        elbow: Drag it to bend the arm.
        wrist: Likewise.
        gripper: Drag it to lead the gripper.
        held: Name of the joint that is being dragged, or None.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = scene = server.scene
        scene.set_up_direction("+z")
        self._furnish()
        camera = server.initial_camera
        camera.position, camera.look_at = (-0.05, 1.05, 0.80), (0.40, -0.12, 0.22)
        camera.fov = np.deg2rad(46.0)
        first = person(Posture("first", 0.0, 0.0, 0.0, 0.0))
        self._person = {
            name: scene.add_mesh_simple(f"/person/{name}", m.vertices, m.faces, color=m.colour)
            for name, m in first.items()
        }
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
        self._arrows: viser.SceneNodeHandle | None = None
        self._labels = {
            name: scene.add_label(f"/labels/{name}", "", visible=False) for name in (*LINKS, "grip")
        }
        self.elbow = self._handle("elbow", 0.13)
        self.wrist = self._handle("wrist", 0.13)
        self.gripper = self._handle("gripper", 0.22)
        self.gripper.visible = False
        self.held: str | None = None
        self._robot: Robot | None = None
        self._links: dict[str, viser.FrameHandle] = {}
        self._drawn: dict[str, object] = {}
        self._sewn: tuple[SleeveMesh, Cloth] | None = None

    def _furnish(self) -> None:
        """Light, a floor, and what robot and person are on."""
        scene = self._scene
        scene.configure_default_lights(enabled=False)
        scene.configure_environment_map(None)
        scene.add_light_hemisphere(
            "/light/sky", sky_color=(255, 255, 255), ground_color=(150, 150, 160), intensity=1.6
        )
        # A directional light shines from its place towards the origin.
        scene.add_light_directional("/light/sun", intensity=1.5, position=(-0.6, 1.4, 2.2))
        scene.set_background_image(_backdrop())
        scene.add_grid(
            "/floor",
            width=4.0,
            height=4.0,
            position=(0.3, 0.0, -0.45),
            cell_size=0.25,
            cell_color=(190, 196, 203),
            section_color=(165, 172, 180),
        )
        scene.add_box("/table", (92, 98, 108), (0.32, 0.32, 0.45), position=(-0.03, 0.0, -0.226))
        scene.add_box("/stool", (92, 98, 108), (0.42, 0.36, 0.06), position=(0.7, -0.26, -0.29))

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
        if not self._news("posture", posture):
            return
        for name, mesh in person(posture).items():
            self._person[name].vertices = mesh.vertices
        for name, frame in zip(self._frames, posture.frames(), strict=True):
            self._frames[name].position = frame.b
            self._frames[name].wxyz = Rotation.from_matrix(frame.A).as_quat(scalar_first=True)
        for name, handle in (("elbow", self.elbow), ("wrist", self.wrist)):
            if name != self.held:  # it is where the mouse is
                handle.position = getattr(posture, name)

    def hold(self, joint: str | None) -> None:
        """Somebody begins to drag a joint, or lets it go: it then snaps back onto the arm."""
        self.held = joint
        self._drawn.pop("posture", None)

    def draw_handles(self, bend: bool, leader: ByHand | None) -> None:
        """Which handles are there: to bend the arm, or for somebody to lead the gripper."""
        if self._news("bend", bend):
            self.elbow.visible = self.wrist.visible = bend
        if self._news("leader", leader):
            if leader is not None:
                self.gripper.position = leader.target
            self.gripper.visible = leader is not None

    def draw_preview(self, shown: Preview) -> None:
        """The sleeve before it falls, and the path that the policy would take."""
        if not self._news("preview", shown):
            return
        self._drawn.pop("moment", None)
        self._draw_cloth(shown.sleeve, shown.sleeve.vertices.astype(np.float32), 0.3)
        self._line("path", None if shown.path is None else shown.path.positions, _PATH, 3.0)
        self._line("way", None, _WAY, 4.0)
        self.draw_forces(shown.posture, None)

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
        self.draw_forces(live.dressing.posture, moment)

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
            self._line("guide", None if path is None else path.positions, _GUIDE, 3.0)

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

    def draw_forces(self, posture: Posture, moment: Moment | None) -> None:
        """Arrows of the cloth's force on each link of the arm, with newtons; and the pull."""
        arrows = []
        for name, label in self._labels.items():
            centre = link_centres(posture).get(name)
            if moment is None or (centre is None and name != "grip"):
                label.visible = False
                continue
            if name == "grip":
                place, newtons = moment.row.tcp, moment.row.grip_force
                place, text = place + [0.0, 0.0, 0.06], f"pull {newtons:.1f} N"
            else:
                force = moment.row.link_force[LINKS.index(name)]
                newtons, text = float(np.linalg.norm(force)), ""
                assert centre is not None
                begin = centre + 0.05 * force / max(newtons, _LEAST)  # out of the arm
                place = begin + _PER_NEWTON * force
                if newtons >= _LEAST:
                    arrows.append([begin, place])
                    text = f"{name.replace('_', ' ')} {newtons:.1f} N"
            label.visible = newtons >= _LEAST
            if newtons >= _LEAST:
                label.text, label.position = text, place
        if self._arrows is not None:
            self._arrows.remove()
            self._arrows = None
        if arrows:
            self._arrows = self._scene.add_arrows(
                "/forces",
                np.array(arrows, dtype=np.float32),
                colors=(200, 30, 30),
                shaft_radius=0.004,
                head_radius=0.010,
                head_length=0.02,
            )


def _backdrop() -> NDArray[np.uint8]:
    """A picture of a wall that is lighter above than below, (n, 2, 3)."""
    shade = np.linspace(238.0, 205.0, 256)[:, None]
    rgb = np.round(shade + np.array([-4.0, 0.0, 5.0])).astype(np.uint8)
    return np.repeat(rgb[:, None], 2, axis=1)


def _thinned(moments: Sequence[Moment]) -> NDArray[np.float64]:
    """The gripper's way (n, 3) [m], not finer than is seen."""
    step = max(1, len(moments) // 150)
    return np.array([moment.row.tcp for moment in [*moments[::step], moments[-1]]])
