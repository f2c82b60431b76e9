"""What makes pictures look right and physics does not see: robot skin, floor, light, camera."""

from __future__ import annotations

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from dressing_sim.pictures.meshes import robot_skin
from dressing_sim.world.mannequin import ARM_LINKS

#: Geom groups of pictures: visual meshes are shown, collision shapes of the robot are not.
VISUAL_GROUP, COLLISION_GROUP = 2, 3

#: How far inside the surface that contacts see the arm's skin is drawn [m]: own choice, what cloth
#: sinks in under a usual load. Real skin would give way; ours, drawn in full, would poke through.
SKIN_INSET = 0.006


def add_visuals(spec: mujoco.MjSpec) -> None:
    """Add the robot's skin, a floor, lights and a camera to a scene, and draw the arm thinner.

    For pictures alone: nothing that is added has contacts, and the arm is no longer the simulated.
    """
    _add_robot_skin(spec)
    for link in ARM_LINKS:
        for geom in spec.body(link).geoms:
            geom.size[0] -= SKIN_INSET
    _add_studio(spec)


def _add_robot_skin(spec: mujoco.MjSpec) -> None:
    for part in robot_skin():
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
            quat=Rotation.from_euler("xyz", part.rpy).as_quat(scalar_first=True),
            rgba=[*(byte / 255.0 for byte in bytes.fromhex(part.colour)), 1.0],
            contype=0,
            conaffinity=0,
            mass=0.0,
            group=VISUAL_GROUP,
        )


def _add_studio(spec: mujoco.MjSpec) -> None:
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.95, 0.97],
        rgb2=[0.72, 0.78, 0.84],
        width=64,
        height=384,
    )
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[3.0, 3.0, 0.1],
        pos=[0.0, 0.0, -0.45],
        rgba=[0.80, 0.82, 0.84, 1.0],
        contype=0,
        conaffinity=0,
    )
    spec.worldbody.add_geom(
        name="table",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[0.16, 0.16, 0.225],
        pos=[-0.03, 0.0, -0.226],
        rgba=[0.45, 0.47, 0.50, 1.0],
        contype=0,
        conaffinity=0,
    )
    spec.worldbody.add_light(
        pos=[0.6, 1.2, 2.2], dir=[-0.1, -0.6, -1.0], diffuse=[0.5] * 3, specular=[0.1] * 3
    )
    spec.worldbody.add_light(
        pos=[-0.8, -0.4, 1.8], dir=[0.6, 0.3, -1.0], diffuse=[0.25] * 3, castshadow=False
    )
    spec.visual.headlight.ambient = [0.35] * 3
    spec.visual.headlight.diffuse = [0.25] * 3
    spec.visual.quality.shadowsize = 4096
    spec.visual.quality.offsamples = 8
    spec.visual.map.znear = 0.01
    for name, eye, target in (
        ("front", (-0.30, 0.95, 0.78), (0.37, -0.04, 0.28)),
        ("close", (0.05, 0.55, 0.55), (0.42, -0.08, 0.24)),
        ("above", (0.40, 0.10, 1.30), (0.42, -0.05, 0.2)),
    ):
        back = np.subtract(eye, target) / np.linalg.norm(np.subtract(eye, target))
        right = np.cross([0.0, 0.0, 1.0] if abs(back[2]) < 0.95 else [0.0, 1.0, 0.0], back)
        right /= np.linalg.norm(right)
        up = np.cross(back, right)
        matrix = np.column_stack([right, up, back])
        spec.worldbody.add_camera(
            name=name,
            pos=eye,
            quat=Rotation.from_matrix(matrix).as_quat(scalar_first=True),
            fovy=42.0,
        )
