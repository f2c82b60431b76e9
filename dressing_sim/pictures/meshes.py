"""A robot's visual meshes, which MuJoCo cannot read as they ship, converted and kept.

They are converted from COLLADA (or STL, or OBJ) on first use, one OBJ a link and colour. The cache
in the user's folder never stands in the way: a file of it has a checksum, and what is damaged, or
cannot be read or written, costs converting anew and one warning.
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
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from dressing_sim.archives import read_by_others, unreadable
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import write_file
from dressing_sim.pictures.simplify import simplified
from dressing_sim.world.description import addressed, urdf_path, urdf_text
from dressing_sim.world.robot import Robot

_LOG = logging.getLogger("dressing_sim")

#: How far the drawn robot may be from its meshes, see `simplified` [m]: of the Panda's a fifth of
#: the triangles are left, 25,075 of 134,924.
_ERROR = 0.0022

_SHA = hashlib.sha256().digest_size

#: Colour of shapes whose URDF says none.
_PLAIN = "4d4f53"


def cache_folder() -> Path:
    """Where converted meshes are kept; one folder a precision."""
    root = Path(platformdirs.user_cache_dir("dressing_sim", appauthor=False))
    return root / f"meshes-{1e6 * _ERROR:.0f}um"


def converted_meshes(file: Path, scale: tuple[float, ...] = (1.0, 1.0, 1.0)) -> dict[str, str]:
    """The meshes of a file as OBJ, from the cache if it has them.

    Args:
        file: Of meshes: .dae, .stl, .obj.
        scale: Of its three coordinates.

    Returns:
        OBJ by colour, six hexadecimal digits of red, green and blue.

    Raises:
        InvalidInputError: It cannot be read.
    """
    try:
        source = file.read_bytes()
    except OSError as error:
        raise unreadable(file, error) from error
    # Links of different robots have files of the same name.
    digest = hashlib.sha256(repr(scale).encode() + source).hexdigest()[:16]
    kept = cache_folder() / f"{file.stem}-{digest}.meshes"
    found = _read(kept)
    if found is None:
        with read_by_others(file, "mesh"):
            found = _convert(file, scale)
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
        xyz: Place of the mesh in the link's frame [m].
        rpy: Roll, pitch and yaw of the mesh in the link's frame [rad].
        colour: Six hexadecimal digits of red, green and blue.
        obj: The mesh.
    """

    link: str
    name: str
    xyz: tuple[float, ...]
    rpy: tuple[float, ...]
    colour: str
    obj: str


def robot_skin(robot: Robot) -> Iterator[SkinPart]:
    """A robot's visual meshes and shapes, link by link.

    Raises:
        InvalidInputError: A mesh cannot be read.
    """
    with read_by_others(urdf_path(robot), "robot that can be drawn"):
        yield from _skin(robot)


def _skin(robot: Robot) -> Iterator[SkinPart]:
    root, folder = ET.fromstring(urdf_text(robot)), urdf_path(robot).parent
    colours = {one.get("name", ""): _colour(one, {}) for one in root.findall("material")}
    for link in root.findall("link"):
        for number, visual in enumerate(link.findall("visual")):
            geometry, origin = visual.find("geometry"), visual.find("origin")
            if geometry is None or not len(geometry):
                continue
            shape = geometry[0]
            own = _colour(visual.find("material"), colours)
            if shape.tag == "mesh":
                file = addressed(shape.get("filename", ""), folder)
                stem, meshes = file.stem, converted_meshes(file, _numbers(shape, "scale", 1.0))
                # COLLADA has colours of its own.
                if own is not None and len(meshes) == 1 and file.suffix.lower() != ".dae":
                    meshes = {own: next(iter(meshes.values()))}
            else:
                stem = f"{link.get('name')}_{shape.tag}{number}"
                meshes = {own or _PLAIN: _drawn_shape(shape)}
            for colour, obj in meshes.items():
                xyz, rpy = _numbers(origin, "xyz", 0.0), _numbers(origin, "rpy", 0.0)
                yield SkinPart(link.get("name", ""), f"{stem}_{colour}", xyz, rpy, colour, obj)


def _numbers(element: ET.Element | None, key: str, otherwise: float) -> tuple[float, ...]:
    """Three numbers of an element that may lack them."""
    text = None if element is None else element.get(key)
    return (otherwise,) * 3 if text is None else tuple(map(float, text.split()))


def _colour(material: ET.Element | None, known: dict[str, str | None]) -> str | None:
    """A material's colour, six hexadecimal digits; None if it has none."""
    if material is None:
        return None
    colour = material.find("color")
    if colour is None:
        return known.get(material.get("name", ""))
    shares = list(map(float, colour.get("rgba", "").split()))[:3]
    return bytes(round(255.0 * min(max(share, 0.0), 1.0)) for share in shares).hex()


def _drawn_shape(shape: ET.Element) -> str:
    """A box, cylinder or sphere of a URDF as OBJ."""
    import trimesh

    def size(key: str) -> float:
        return float(shape.get(key, "0.01"))

    made: Any
    if shape.tag == "box":
        made = trimesh.creation.box(extents=_numbers(shape, "size", 0.01))
    elif shape.tag == "cylinder":
        made = trimesh.creation.cylinder(size("radius"), size("length"))
    else:
        made = trimesh.creation.icosphere(3, size("radius"))
    return str(made.export(file_type="obj", include_normals=False))


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


def _convert(file: Path, scale: tuple[float, ...]) -> dict[str, str]:
    # Imported here: only the first picture on a machine needs a mesh library.
    import trimesh

    dumped: list[Any] = trimesh.load_scene(file).dump()
    parts = [mesh for mesh in dumped if len(mesh.faces)]
    if not parts:
        raise InvalidInputError("no triangles, valid is a mesh with some")
    by_colour = defaultdict(list)
    for mesh in parts:
        # What is not COLLADA may have no material.
        look: Any = getattr(mesh.visual, "material", mesh.visual)
        by_colour[bytes(look.main_color[:3]).hex()].append(mesh)
    meshes = {}
    for colour in sorted(by_colour):
        merged: Any = trimesh.util.concatenate(
            [trimesh.Trimesh(m.vertices * scale, m.faces, process=False) for m in by_colour[colour]]
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
