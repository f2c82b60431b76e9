"""The room that pictures are taken in: floor, chair, robot's stand, light and cameras."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter
from scipy.spatial.transform import Rotation

from dressing_sim.arm import FORWARD, LEFT, UP, Posture
from dressing_sim.pictures.person import FLOOR, SEAT
from dressing_sim.world.mannequin import SHOULDER_TO_MIDLINE

#: Eye and target of each named camera, in the robot's base frame [m].
VIEWS = {
    "front": ((-0.30, 0.95, 0.78), (0.37, -0.04, 0.23)),
    "close": ((0.05, 0.55, 0.55), (0.42, -0.08, 0.24)),
    "above": ((0.40, 0.10, 1.30), (0.42, -0.05, 0.2)),
    "side": ((-0.85, -0.02, 0.62), (0.45, -0.02, 0.18)),
    "person": ((1.25, 0.85, 0.85), (0.42, -0.06, 0.18)),
    "room": ((-0.75, 1.75, 0.95), (0.36, -0.06, 0.02)),
}

#: Vertical opening of every camera [deg].
FIELD_OF_VIEW_DEG = 42.0

_FLOOR = (0.80, 0.79, 0.77, 1.0)

#: How far the middle of a shadow is from what casts it, for each metre of height: the light comes
#: from the person's front.
_SLANT = np.array([0.12, -0.22])

_WOOD, _CLOTH, _STEEL = (0.80, 0.68, 0.52, 1.0), (0.42, 0.50, 0.52, 1.0), (0.34, 0.35, 0.37, 1.0)


def add_studio(spec: mujoco.MjSpec, posture: Posture, base: Sequence[float]) -> None:
    """Add all of it to a model that is made for drawing.

    Args:
        spec: Model to edit.
        posture: Of the person, who sits on the chair.
        base: Where the robot stands, (3,) [m].
    """
    floor = posture.shoulder_position[2] - FLOOR
    _add_floor(spec, floor)
    _add_chair(spec, posture, floor)
    _add_stand(spec, floor, base)
    _add_light(spec)
    for name, (eye, target) in VIEWS.items():
        quat = Rotation.from_matrix(looking(np.array(eye), np.array(target)))
        spec.worldbody.add_camera(
            name=name, pos=eye, quat=quat.as_quat(scalar_first=True), fovy=FIELD_OF_VIEW_DEG
        )


def looking(eye: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Orientation (3, 3) of a camera: columns right, up and backwards."""
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross(UP if abs(back[2]) < 0.95 else FORWARD, back)
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(back, right), back])


def _add_floor(spec: mujoco.MjSpec, floor: float) -> None:
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.97, 0.98, 0.99],
        rgb2=[0.83, 0.86, 0.89],
        width=32,
        height=192,
    )
    _solid(spec, "plane", (20.0, 20.0, 5.0), (0.3, 0.0, floor), _FLOOR, name="floor")


def add_soft_shadow(spec: mujoco.MjSpec, points: NDArray[np.float64], floor: float) -> None:
    """A rug that is darker where the room's light is kept from the floor by what stands there.

    Args:
        spec: To which it is added.
        points: Of what stands there, shape (n, 3) [m].
        floor: Height of the floor [m].
    """
    half, pixels = 1.1, 128
    middle = np.array([0.40, 0.05])
    height = points[:, 2] - floor
    places = points[:, :2] + height[:, None] * _SLANT - middle
    # What is higher up has less to say.
    grid, _, _ = np.histogram2d(
        places[:, 1], places[:, 0], pixels, [[-half, half]] * 2, weights=1.0 / (0.3 + height)
    )
    edge = np.sin(np.pi * (np.arange(pixels) + 0.5) / pixels)
    dark = 0.45 * (1.0 - np.exp(-0.35 * gaussian_filter(grid, 3.5)))
    dark *= np.minimum(1.0, 8.0 * np.outer(edge, edge))
    rgb = np.round(255.0 * (1.0 - dark))[..., None] * np.ones(3)
    texture = spec.add_texture(
        name="shadow",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        width=pixels,
        height=pixels,
        nchannel=3,
    )
    texture.data = rgb[::-1].astype(np.uint8).tobytes()
    material = spec.add_material(name="shadow", rgba=_FLOOR, specular=0.5, shininess=0.5)
    textures = material.textures
    textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "shadow"
    material.textures = textures
    place = (*middle, floor + 0.002)
    _solid(spec, "plane", (half, half, 1.0), place, _FLOOR, name="shadow", material="shadow")


def _add_chair(spec: mujoco.MjSpec, posture: Posture, floor: float) -> None:
    middle = posture.shoulder - SHOULDER_TO_MIDLINE * LEFT
    seat = middle - SEAT * UP + 0.05 * FORWARD
    _solid(spec, "box", (0.21, 0.22, 0.03), seat, _CLOTH)
    back = middle - 0.36 * UP - 0.20 * FORWARD
    tilt = Rotation.from_rotvec([0.14, 0.0, 0.0]).as_quat(scalar_first=True)
    _solid(spec, "box", (0.19, 0.018, 0.19), back, _CLOTH, quat=tilt)
    for side in (-0.185, 0.185):
        for depth in (-0.16, 0.20):
            foot = middle + side * LEFT + (depth + 0.03) * FORWARD
            foot[2] = floor
            top = seat + side * LEFT + (depth - 0.05) * FORWARD
            _bar(spec, foot, top, 0.014)
        low = seat + side * LEFT - 0.21 * FORWARD
        _bar(spec, low, low + 0.47 * UP - 0.055 * FORWARD, 0.014)


def _add_stand(spec: mujoco.MjSpec, floor: float, base: Sequence[float]) -> None:
    x, y, top = base[0] - 0.045, base[1], base[2]
    half = 0.5 * (top - 0.025 - floor)
    if half <= 0.0:
        return  # the robot stands on the floor
    _solid(spec, "box", (0.15, 0.13, 0.012), (x, y, top - 0.013), _STEEL)
    _solid(spec, "box", (0.075, 0.075, half), (x, y, top - 0.025 - half), (0.50, 0.51, 0.53, 1.0))
    _solid(spec, "box", (0.24, 0.22, 0.015), (x, y, floor + 0.015), _STEEL)


def _add_light(spec: mujoco.MjSpec) -> None:
    world = spec.worldbody
    world.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=[-0.2, 1.5, 2.6],
        dir=[0.30, -0.55, -1.0],
        diffuse=[0.36] * 3,
        specular=[0.10] * 3,
    )
    spec.visual.headlight.ambient = [0.50] * 3
    spec.visual.headlight.diffuse = [0.20] * 3
    spec.visual.headlight.specular = [0.0] * 3
    spec.visual.map.znear = 0.01
    spec.visual.map.shadowclip = 1.0
    spec.stat.extent, spec.stat.center = 1.3, [0.4, 0.0, -0.1]


def _bar(
    spec: mujoco.MjSpec, start: NDArray[np.float64], end: NDArray[np.float64], radius: float
) -> None:
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        size=[radius, 0.0, 0.0],
        fromto=[*start, *end],
        rgba=_WOOD,
        contype=0,
        conaffinity=0,
    )


def _solid(
    spec: mujoco.MjSpec,
    kind: str,
    size: tuple[float, ...],
    place: NDArray[np.float64] | tuple[float, ...],
    rgba: tuple[float, ...],
    **more: object,
) -> None:
    spec.worldbody.add_geom(
        type=getattr(mujoco.mjtGeom, f"mjGEOM_{kind.upper()}"),
        size=list(size),
        pos=list(place),
        rgba=list(rgba),
        contype=0,
        conaffinity=0,
        **more,
    )
