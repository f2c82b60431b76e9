"""Garments and fabrics: what a tape measure, scales and a tensile test would say, in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from dressing_sim.config import check_numbers
from dressing_sim.errors import InvalidInputError


@dataclass(frozen=True, slots=True)
class Fabric:
    """A knitted fabric; the defaults are a cotton jersey in the middle of the measured ranges."""

    areal_density: float = 0.18
    """Mass of the fabric an area [kg/m^2]; jersey: 0.150 to 0.207."""
    membrane_stiffness: float = 180.0
    """Young's modulus times thickness [N/m]; jersey: 17 to 410 (as measured for ARCSim)."""
    bending_stiffness: float = 2e-5
    """Plate rigidity [N m]."""
    poisson: float = 0.3
    """Poisson's ratio."""
    thickness: float = 0.001
    """Of the fabric [m]; what gives way between it and the skin is the contact's,
    see `SleeveConfig.contact_depth`."""
    friction: float = 0.3
    """Friction coefficient on skin; on dry forearms 0.25 +- 0.05 sliding, 0.31 +- 0.07 at rest
    (Temel et al. 2022)."""
    damping: float = 0.01
    """Rayleigh damping: ratio of viscous to elastic stress an inverse second [s]."""

    def __post_init__(self) -> None:
        check_numbers(
            self,
            "fabric",
            ("areal_density", "membrane_stiffness", "bending_stiffness", "thickness"),
            ("friction", "damping"),
        )
        if not 0.0 <= self.poisson < 0.5:
            raise InvalidInputError(f"fabric: poisson is {self.poisson}, valid is 0 to below 0.5")

    @property
    def elastic_thickness(self) -> float:
        """Thickness [m] of the solid sheet that has both measured stiffnesses.

        A fabric bends more easily than a solid sheet of its thickness. MuJoCo derives both
        stiffnesses from one sheet, membrane ``E t`` and bending ``E t^3 / 12 (1 - nu^2)``, so t
        follows from their ratio.
        """
        ratio = self.bending_stiffness / self.membrane_stiffness
        return float(np.sqrt(12.0 * (1.0 - self.poisson**2) * ratio))

    @property
    def young(self) -> float:
        """Young's modulus [Pa] of the sheet of `elastic_thickness`."""
        return self.membrane_stiffness / self.elastic_thickness


@dataclass(frozen=True, slots=True)
class Garment:
    """The part of a garment that is simulated: a sleeve, and what hangs from its armscye.

    The defaults are the sleeve of a T-shirt of size M.
    """

    length: float = 0.20
    """Of the sleeve, from armscye to hem along the cone's axis [m]; T-shirt M: 0.191 to 0.216."""
    armscye_circumference: float = 0.48
    """Armhole all round [m]; T-shirt M: 0.440 to 0.480."""
    hem_circumference: float = 0.368
    """Sleeve opening all round [m]; T-shirt M: 0.356 to 0.368."""
    body: float = 0.0
    """Length of the shirt's body that hangs from the lower half of the armscye [m]; 0 for none."""
    fabric: Fabric = field(default_factory=Fabric)

    def __post_init__(self) -> None:
        sizes = ("length", "armscye_circumference", "hem_circumference")
        check_numbers(self, "garment", sizes, ("body",))

    @property
    def sleeve_area(self) -> float:
        """Of the sleeve's cloth, a truncated cone [m^2]."""
        wide, narrow = self.armscye_circumference, self.hem_circumference
        slant = np.hypot(self.length, (wide - narrow) / (2.0 * np.pi))
        return float(0.5 * (wide + narrow) * slant)

    @property
    def body_area(self) -> float:
        """Of the cloth of the shirt's body, half a cylinder [m^2]."""
        return 0.5 * self.armscye_circumference * self.body


#: Fabrics within the ranges measured for jersey: ordinary, light and stretchy, heavy and stiff.
FABRICS: Mapping[str, Fabric] = MappingProxyType(
    {
        "jersey": Fabric(),
        "light-jersey": Fabric(
            areal_density=0.15, membrane_stiffness=80.0, bending_stiffness=1e-5, friction=0.25
        ),
        "interlock": Fabric(
            areal_density=0.207, membrane_stiffness=300.0, bending_stiffness=4e-5, friction=0.35
        ),
    }
)

#: Garments by name. Sizes other than M are graded from it by the usual step of 10 mm in length and
#: 20 mm round (own choice); the long sleeve ends on the forearm.
GARMENTS: Mapping[str, Garment] = MappingProxyType(
    {
        "tshirt-m": Garment(),
        "tshirt-l": Garment(0.21, 0.50, 0.388, fabric=FABRICS["interlock"]),
        "tshirt-xl": Garment(0.22, 0.52, 0.408, fabric=FABRICS["light-jersey"]),
        "long-sleeve": Garment(0.40, 0.48, 0.320),
        "tshirt-m-body": Garment(body=0.25),
    }
)


def find_garment(name: str) -> Garment:
    """A garment by its name.

    Raises:
        InvalidInputError: There is none of this name.
    """
    if name not in GARMENTS:
        raise InvalidInputError(f"unknown garment {name!r}; valid is one of {', '.join(GARMENTS)}")
    return GARMENTS[name]
