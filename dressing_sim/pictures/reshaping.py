"""Meshes of a model for drawing whose vertices move."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray


def reshape(
    model: mujoco.MjModel, name: str, points: NDArray[np.float64], normals: NDArray[np.float64]
) -> int:
    """Move a mesh's vertices.

    Args:
        model: Compiled.
        name: Of the mesh, and of its geom, which is not turned or shifted.
        points: Its vertices, as many as it was made of, (n, 3) [m].
        normals: Of the vertices, (n, 3).

    Returns:
        The mesh to upload.
    """
    mesh = model.mesh(name).id
    # A compiled mesh is kept in the frame of its inertia, and drawn where its geom is.
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.mesh_quat[mesh])
    turn = rotation.reshape(3, 3)
    at, n = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    model.mesh_vert[at : at + n] = (points - model.mesh_pos[mesh]) @ turn
    at, n = model.mesh_normaladr[mesh], model.mesh_normalnum[mesh]
    model.mesh_normal[at : at + n] = normals @ turn
    return int(mesh)
