"""Pictures of the world without a screen: EGL, OSMesa, or the operating system's own OpenGL.

Rendering has a model of its own, with the robot's skin, and copies only positions into it, so an
episode's physics are the same whether anybody looks or not.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cache
from types import TracebackType
from typing import Self

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.errors import DressingSimError
from dressing_sim.pictures.cameras import View
from dressing_sim.pictures.canvas import Canvas
from dressing_sim.pictures.cloth import SLEEVE_GROUP
from dressing_sim.pictures.look import check_size
from dressing_sim.pictures.moving import MovingPerson
from dressing_sim.pictures.overlays import Mark
from dressing_sim.pictures.person import person
from dressing_sim.pictures.visuals import (
    COLLISION_GROUP,
    VISUAL_GROUP,
    drawing_spec,
    dressed_skin,
)
from dressing_sim.world.scene import WorldConfig, compiled, resting_sleeve

#: Drawn with through PyOpenGL, without a window system; what there is on Linux.
_THROUGH_PYOPENGL = ("egl", "osmesa")


def backends(platform: str) -> tuple[str, ...]:
    """Backends to try, by `sys.platform`: macOS and Windows have OpenGL of their own."""
    return {"darwin": ("cgl", "glfw"), "win32": ("glfw",)}.get(platform, _THROUGH_PYOPENGL)


#: Tried in this order unless the environment variable MUJOCO_GL names one of them.
BACKENDS = backends(sys.platform)

#: Samples of each pixel of a fine picture; software OpenGL has no more.
_SAMPLES = 4

INSTALL_HINT = (
    "no offscreen OpenGL works here: on Linux install EGL (Debian and Ubuntu: apt install libegl1 "
    "libegl-mesa0 libgl1-mesa-dri) or OSMesa (apt install libosmesa6)"
)


def probe(backend: str) -> str | None:
    """Try a backend in a process of its own, where a crash does no harm.

    Returns:
        None if a context can be made and used with it, else the reason why not.
    """
    code = (
        f"from mujoco.{backend} import GLContext; context = GLContext(16, 16); "
        "context.make_current(); context.free()"
    )
    environment = {k: v for k, v in os.environ.items() if k != "PYOPENGL_PLATFORM"}
    environment["MUJOCO_GL"] = backend
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=False
    )
    if result.returncode == 0:
        return None
    lines = result.stderr.strip().splitlines()
    return lines[-1] if lines else f"exit code {result.returncode}"


@cache
def gl_backend() -> str:
    """The backend that this process uses for all its pictures.

    Raises:
        DressingSimError: None works, or not the one that ``MUJOCO_GL`` names; the message says
            what to install.
    """
    wanted = os.environ.get("MUJOCO_GL", "").lower()
    for backend in (wanted,) if wanted in BACKENDS else BACKENDS:
        reason = probe(backend)
        if reason is None:
            if backend in _THROUGH_PYOPENGL:
                # PyOpenGL binds to one platform at its first import, for the life of the process.
                os.environ["PYOPENGL_PLATFORM"] = backend
            return backend
        if backend == wanted:
            raise DressingSimError(
                f"MUJOCO_GL={wanted} does not work here ({reason}); unset it or see: {INSTALL_HINT}"
            )
    raise DressingSimError(INSTALL_HINT)


@dataclass(frozen=True, slots=True, eq=False)
class _Layer:
    """A part of what a camera sees: its picture (height, width, 3), and how near it is.

    Nearness (height, width) falls with the distance, to 0 where there is nothing.
    """

    picture: NDArray[np.uint8]
    nearness: NDArray[np.float32] | None

    def before(self, other: _Layer) -> NDArray[np.uint8]:
        """The picture of both, in which the nearer hides the other."""
        assert self.nearness is not None
        assert other.nearness is not None
        mine = self.nearness > other.nearness
        rows, columns = (np.flatnonzero(mine.any(axis=axis)) for axis in (1, 0))
        picture = other.picture.copy()
        if len(rows):
            box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
            np.copyto(picture[box], self.picture[box], where=mine[box][..., None])
        return picture


class OffscreenRenderer:
    """Draws states of one scene; use it as a context manager, or close it.

    Args:
        posture: The mannequin's posture.
        config: The world's configuration, for the sleeve's mesh.
        width: Of a picture [pixels].
        height: Of a picture [pixels].
        fine: Smooth edges and cast shadows, which takes six times as long.
        strain_top: Colour the cloth by its strain, this strain in the last colour; None for cloth
            of one colour.

    Raises:
        DressingSimError: No OpenGL backend works.
        InvalidInputError: A side of the picture is below 1 or above `LARGEST_SIDE`.
    """

    def __init__(
        self,
        posture: Posture,
        config: WorldConfig,
        width: int = 640,
        height: int = 480,
        strain_top: float | None = None,
        fine: bool = True,
    ) -> None:
        check_size(width, height)
        backend = gl_backend()
        spec, self._sleeve = drawing_spec(posture, config, strain_top)
        self._resting = resting_sleeve(posture, config.sleeve).vertices
        spec.visual.quality.offsamples = _SAMPLES if fine else 0
        spec.visual.global_.offwidth, spec.visual.global_.offheight = width, height
        self._posture = posture
        self._person = None if posture.motion is None else MovingPerson(posture, person(posture))
        self._model = compiled(spec)
        self._data = mujoco.MjData(self._model)
        self._rectangle = mujoco.MjrRect(0, 0, width, height)
        self._canvas = Canvas(backend, width, height)
        self._context = self._canvas.run(self._upload)
        self._scene = mujoco.MjvScene(self._model, maxgeom=5000)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = fine
        self._option = mujoco.MjvOption()
        self._option.geomgroup[VISUAL_GROUP] = 1
        self._option.geomgroup[COLLISION_GROUP] = 0
        self._option.geomgroup[SLEEVE_GROUP] = 1
        self._sleeve_alone, self._without_sleeve = mujoco.MjvOption(), copy(self._option)
        self._sleeve_alone.geomgroup[:] = 0
        self._sleeve_alone.geomgroup[SLEEVE_GROUP] = 1
        self._without_sleeve.geomgroup[SLEEVE_GROUP] = 0
        self._whole = fine or self._person is not None
        self._still: dict[str, _Layer] = {}

    def _upload(self) -> mujoco.MjrContext:
        """Hand meshes and textures to OpenGL."""
        context = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_150)
        self._canvas.keep(context)
        context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, context)
        return context

    def draw(
        self,
        qpos: NDArray[np.float64],
        camera: str | View = "front",
        marks: Sequence[Mark] = (),
    ) -> NDArray[np.uint8]:
        """Draw the scene.

        Args:
            qpos: Generalised positions of the simulated world, ``World.data.qpos``.
            camera: One of `dressing_sim.pictures.CAMERAS`, or a view of one's own.
            marks: What is drawn besides.

        Returns:
            Picture, shape (height, width, 3).

        Raises:
            InvalidInputError: The renderer is closed.
            DressingSimError: This process was forked from one that had drawn.
        """
        return self._canvas.run(self._draw, qpos, camera, marks)

    def _draw(
        self, qpos: NDArray[np.float64], camera: str | View, marks: Sequence[Mark]
    ) -> NDArray[np.uint8]:
        self._place(qpos)
        # Smooth edges are of both layers at once, shadows fall from one on the other, and letters
        # are in front of all.
        if self._whole or isinstance(camera, View) or any(mark.label for mark in marks):
            self._update(camera, mujoco.mjtCatBit.mjCAT_ALL, self._option)
            return self._rendered(marks).picture
        if camera not in self._still:
            self._update(camera, mujoco.mjtCatBit.mjCAT_STATIC, self._without_sleeve)
            self._still[camera] = self._rendered(depth=True)
        self._update(camera, mujoco.mjtCatBit.mjCAT_DYNAMIC, self._option)
        mujoco.mjv_addGeoms(
            self._model,
            self._data,
            self._sleeve_alone,
            mujoco.MjvPerturb(),
            mujoco.mjtCatBit.mjCAT_STATIC,
            self._scene,
        )
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = False
        moving = self._rendered(marks, depth=True)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SKYBOX] = True
        return moving.before(self._still[camera])

    def _update(self, camera: str | View, kinds: int, option: mujoco.MjvOption) -> None:
        """Fill the scene with geoms of these categories, as a camera sees them."""
        if isinstance(camera, View):
            view = camera.camera()
        else:
            view = mujoco.MjvCamera()
            view.type = mujoco.mjtCamera.mjCAMERA_FIXED
            view.fixedcamid = self._model.camera(camera).id
        mujoco.mjv_updateScene(self._model, self._data, option, None, view, kinds, self._scene)

    def _rendered(self, marks: Sequence[Mark] = (), depth: bool = False) -> _Layer:
        """The scene as it is drawn."""
        for mark in marks:
            mark.add(self._scene)
        mujoco.mjr_render(self._rectangle, self._scene, self._context)
        shape = self._rectangle.height, self._rectangle.width
        picture = np.empty((*shape, 3), dtype=np.uint8)
        nearness = np.empty(shape, dtype=np.float32) if depth else None
        mujoco.mjr_readPixels(picture, nearness, self._rectangle, self._context)
        # OpenGL's rows go up.
        upright = None if nearness is None else nearness[::-1]
        return _Layer(np.ascontiguousarray(picture[::-1]), upright)

    def _place(self, qpos: NDArray[np.float64]) -> None:
        """Put robot, sleeve and a person who moves where they are."""
        n_cloth, n_robot = self._resting.size, self._model.nq
        self._data.qpos[:] = qpos[:n_robot]
        if self._person is not None:
            now = self._posture.moved(qpos[n_robot : len(qpos) - n_cloth])
            for mesh in self._person.place(self._model, now):
                mujoco.mjr_uploadMesh(self._model, self._context, mesh)
            self._sleeve.skin = dressed_skin(now)
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)
        # Each vertex slides from where it rests.
        cloth = self._resting + qpos[len(qpos) - n_cloth :].reshape(-1, 3)
        moved = self._sleeve.place(self._model, cloth)
        mujoco.mjr_uploadMesh(self._model, self._context, moved)

    def hidden(
        self,
        qpos: NDArray[np.float64],
        eye: NDArray[np.float64],
        points: NDArray[np.float64],
    ) -> NDArray[np.bool_]:
        """Which points the robot is in front of.

        Args:
            qpos: Generalised positions of the simulated world.
            eye: Where they are seen from, (3,) [m].
            points: Shape (n, 3) [m].

        Returns:
            Shape (n,).
        """
        self._data.qpos[:] = qpos[: self._model.nq]
        mujoco.mj_kinematics(self._model, self._data)
        robot = np.zeros(mujoco.mjNGROUP, dtype=np.uint8)
        robot[COLLISION_GROUP] = 1
        hit, none = np.full(1, -1, dtype=np.int32), np.zeros(3)
        found = []
        for point in points:
            away = mujoco.mj_ray(self._model, self._data, eye, point - eye, robot, 0, -1, hit, none)
            # In lengths of the ray; the fingers hold the cloth, and are not in front of it.
            found.append(0.0 <= away < 0.9)
        return np.array(found)

    def close(self) -> None:
        """Free the OpenGL context."""
        self._canvas.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
