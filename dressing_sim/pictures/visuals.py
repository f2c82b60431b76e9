"""The model that is drawn: robot, person, room and the sleeve's finer mesh, without physics."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from dressing_sim.arm import Posture
from dressing_sim.pictures.cloth import DrawnSleeve
from dressing_sim.pictures.implicit import Field
from dressing_sim.pictures.meshes import robot_skin
from dressing_sim.pictures.person import FLOOR, Surface, left_arm, person, trunk
from dressing_sim.pictures.strain_colours import StrainScale
from dressing_sim.pictures.studio import add_soft_shadow, add_studio
from dressing_sim.world.robot import Robot
from dressing_sim.world.robot_spec import robot_spec
from dressing_sim.world.scene import WorldConfig, resting_sleeve

#: Geom groups of pictures: visual meshes are shown, collision shapes of the robot are not.
VISUAL_GROUP, COLLISION_GROUP = 2, 3

#: Columns of the texture that darkens what the sky does not see.
_SHADES = 64


def drawing_spec(
    posture: Posture, config: WorldConfig, strain_top: float | None = None
) -> tuple[mujoco.MjSpec, DrawnSleeve]:
    """All that is drawn, as an editable spec, and what moves its sleeve.

    Its joints are the robot's, which come first in the simulated world too.

    Args:
        posture: The person's.
        config: Of the simulated world.
        strain_top: Strain of the last colour of a sleeve in colours of strain; None for cloth in
            its own.
    """
    spec = robot_spec(config.robot, contype=0, conaffinity=0)
    _add_robot_skin(spec, config.robot)
    for part in person(posture):
        _add_surface(spec, part)
    add_studio(spec, posture, config.robot.base_position)
    standing = np.concatenate([part.vertices for part in person(posture)])
    add_soft_shadow(spec, standing, posture.shoulder_position[2] - FLOOR)
    mesh = resting_sleeve(posture, config.sleeve)
    scale = None if strain_top is None else StrainScale(mesh, strain_top)
    return spec, DrawnSleeve(spec, mesh, dressed_skin(posture), scale)


def dressed_skin(posture: Posture) -> Field:
    """What the drawn sleeve is kept outside of."""
    arm, chest = left_arm(posture), trunk(posture)
    return lambda points: np.minimum(arm(points), chest(points) - 0.009)


def _add_surface(spec: mujoco.MjSpec, part: Surface) -> None:
    shades = np.linspace(0.42, 1.0, _SHADES)[:, None] * np.array(part.colour)
    # What little light reaches into a fold comes from the same stuff.
    shades = np.clip(shades ** np.linspace(1.12, 1.0, _SHADES)[:, None], 0.0, 1.0)
    texture = spec.add_texture(
        name=part.name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=_SHADES, height=2, nchannel=3
    )
    row = np.round(255.0 * shades).astype(np.uint8)
    texture.data = np.repeat(row[None], 2, axis=0).tobytes()
    material = spec.add_material(name=part.name, specular=0.15, shininess=0.25)
    textures = material.textures
    textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = part.name
    material.textures = textures
    column = (0.5 + part.light * (_SHADES - 1)) / _SHADES
    corners = part.faces.ravel()
    spec.add_mesh(
        name=part.name,
        uservert=part.vertices.ravel(),
        userface=corners,
        usernormal=part.normals.ravel(),
        userfacenormal=corners,
        usertexcoord=np.stack([column, np.full_like(column, 0.5)], axis=1).ravel(),
        userfacetexcoord=corners,
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )
    spec.worldbody.add_geom(
        name=part.name,
        type=mujoco.mjtGeom.mjGEOM_MESH,
        meshname=part.name,
        material=part.name,
        contype=0,
        conaffinity=0,
        mass=0.0,
        group=VISUAL_GROUP,
    )


def _add_robot_skin(spec: mujoco.MjSpec, robot: Robot) -> None:
    for part in robot_skin(robot):
        if spec.mesh(part.name) is None:
            spec.assets[f"{part.name}.obj"] = part.obj.encode()
            spec.add_mesh(
                name=part.name,
                file=f"{part.name}.obj",
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            )
        spec.body(part.link).add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=part.name,
            pos=part.xyz,
            quat=Rotation.from_euler("xyz", part.rpy).as_quat(scalar_first=True),
            rgba=[*(byte / 255.0 for byte in bytes.fromhex(part.colour)), 1.0],
            contype=0,
            conaffinity=0,
            mass=0.0,
            group=VISUAL_GROUP,
        )
