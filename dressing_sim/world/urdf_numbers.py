"""The numbers of a URDF: all of them finite, and none larger than anything that is meant."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

from dressing_sim.checks import shown
from dressing_sim.errors import InvalidInputError

#: How many numbers an attribute has, and the largest that is meant [m, rad, kg, kg m^2 or 1], by
#: the element that it is of. Limits of joints are checked where they are read.
_NUMBERS: Mapping[str, Mapping[str, tuple[int, float]]] = {
    "origin": {"xyz": (3, 100.0), "rpy": (3, 100.0)},
    "axis": {"xyz": (3, 100.0)},
    "mass": {"value": (1, 1e4)},
    "inertia": dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), (1, 1e6)),
    "box": {"size": (3, 100.0)},
    "cylinder": {"radius": (1, 100.0), "length": (1, 100.0)},
    "sphere": {"radius": (1, 100.0)},
    "mesh": {"scale": (3, 1e4)},
}

#: Elements that are nothing without their numbers; others have defaults.
_SHAPES = frozenset({"box", "cylinder", "sphere"})


def check_numbers(root: ET.Element) -> None:
    """Refuse a URDF with a number that is missing, none, not finite, or too large.

    Raises:
        InvalidInputError: It has one; the message says where and what is valid.
    """
    for element in root.iter():
        for key, (n, most) in _NUMBERS.get(str(element.tag), {}).items():
            text = element.get(key)
            if text is None and element.tag not in _SHAPES:
                continue
            if text is None or not _are_numbers(text, n, most):
                got = f"no {key}" if text is None else f"{key} {shown(text)}"
                what = "a number" if n == 1 else f"{n} numbers"
                raise InvalidInputError(
                    f"its URDF has an element {element.tag} with {got}, valid is "
                    f"{what} from {-most:g} to {most:g}"
                )


def _are_numbers(text: str, n: int, most: float) -> bool:
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        return False
    return len(numbers) == n and all(abs(number) <= most for number in numbers)  # no NaN is
