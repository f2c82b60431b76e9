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
from collections import defaultdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs

from dressing_sim.errors import InvalidInputError
from dressing_sim.files import write_file
from dressing_sim.pictures.simplify import simplified

_LOG = logging.getLogger("dressing_sim")

#: How far the drawn robot may be from its meshes, see `simplified` [m]: a sixth of the triangles
#: are left, which no picture shows, and films are drawn in a third of the time.
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
