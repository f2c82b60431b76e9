"""The robot's visual meshes, which MuJoCo cannot read as they ship, converted and kept.

They are converted from COLLADA on first use, one OBJ a link and colour. The cache in the user's
folder never stands in the way: a file of it has a checksum, and what is damaged, or cannot be read
or written, costs converting anew and one warning.
"""

from __future__ import annotations

import hashlib
import json
import logging
import threading
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from dressing_sim.errors import InvalidInputError
from dressing_sim.files import write_file
from dressing_sim.pictures.simplify import simplified
from dressing_sim.world.panda import mesh_path, urdf_path

_LOG = logging.getLogger("dressing_sim")

#: How far the drawn robot may be from its meshes, see `simplified` [m]: a fifth of the triangles
#: are left, 25,075 of 134,924.
_ERROR = 0.0022

_SHA = hashlib.sha256().digest_size


def cache_folder() -> Path:
    """Where converted meshes are kept; one folder a version of the robot's data and precision."""
    root = Path(platformdirs.user_cache_dir("dressing_sim", appauthor=False))
    return root / f"panda-{version('example-robot-data')}-{1e6 * _ERROR:.0f}um"


def converted_meshes(collada: Path) -> dict[str, str]:
    """The meshes of a COLLADA file as OBJ, from the cache if it has them.

    Args:
        collada: A .dae file.

    Returns:
        OBJ by colour, six hexadecimal digits of red, green and blue.
    """
    kept = cache_folder() / f"{collada.stem}.meshes"
    found = _read(kept)
    if found is None:
        found = _convert(collada)
        content = json.dumps(found).encode()
        try:
            write_file(kept, hashlib.sha256(content).digest() + content)
        except InvalidInputError as error:
            _warn(str(error))
    return found


@dataclass(frozen=True, slots=True)
class SkinPart:
    """What one link of the robot looks like in one colour.

    Attributes:
        link: Name of the link.
        name: Of the mesh; two links may have the same.
        rpy: Roll, pitch and yaw of the mesh in the link's frame [rad].
        colour: Six hexadecimal digits of red, green and blue.
        obj: The mesh.
    """

    link: str
    name: str
    rpy: tuple[float, ...]
    colour: str
    obj: str


def robot_skin() -> Iterator[SkinPart]:
    """The robot's visual meshes, link by link."""
    for link in ET.parse(urdf_path()).getroot().findall("link"):
        for visual in link.findall("visual"):
            mesh = visual.find("geometry/mesh")
            if mesh is None:
                continue
            origin = visual.find("origin")
            turned = "0 0 0" if origin is None else origin.get("rpy", "0 0 0")
            rpy = tuple(float(value) for value in turned.split())
            collada = mesh_path(mesh.get("filename", ""))
            for colour, obj in converted_meshes(collada).items():
                name = f"{collada.stem}_{colour}"
                yield SkinPart(link.get("name", ""), name, rpy, colour, obj)


def _read(kept: Path) -> dict[str, str] | None:
    """What is kept; None if that is nothing, or damaged."""
    try:
        content = kept.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        _warn(f"{kept}: cannot be read ({error.strerror})")
        return None
    if hashlib.sha256(content[_SHA:]).digest() != content[:_SHA]:
        _warn(f"{kept}: damaged, made anew")
        return None
    meshes: dict[str, str] = json.loads(content[_SHA:])
    return meshes


def _convert(collada: Path) -> dict[str, str]:
    # Imported here: only the first picture on a machine needs a mesh library.
    import trimesh

    parts: list[Any] = trimesh.load_scene(collada).dump()
    by_colour = defaultdict(list)
    for mesh in parts:
        by_colour[bytes(mesh.visual.material.main_color[:3]).hex()].append(mesh)
    meshes = {}
    for colour in sorted(by_colour):
        merged: Any = trimesh.util.concatenate(
            [trimesh.Trimesh(m.vertices, m.faces, process=False) for m in by_colour[colour]]
        )
        vertices, faces = simplified(np.array(merged.vertices), np.array(merged.faces), _ERROR)
        if len(vertices) < 4:  # a lamp that is smaller than the error; MuJoCo wants four
            vertices, faces = merged.vertices, merged.faces
        fewer: Any = trimesh.Trimesh(vertices, faces, process=False)
        meshes[colour] = str(fewer.export(file_type="obj", include_normals=False))
    return meshes


def _warn(message: str) -> None:
    """Tell of the first fault in a process; the others are the same for other links."""
    if not _told.is_set():
        _told.set()
        _LOG.warning("the robot's meshes are not kept, which costs some seconds: %s", message)


_told = threading.Event()
