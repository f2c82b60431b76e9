"""Garments by file: what a tape measure, scales and a tensile test say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.suites.measures import Choice, Measure, Schema, Values, load_named
from dressing_sim.world.garment import FABRICS, GARMENTS, Garment

#: Sizes by the setting of `Garment` that each is.
_SIZES: Mapping[str, str] = {
    "sleeve_length_m": "length",
    "armhole_m": "armscye_circumference",
    "opening_m": "hem_circumference",
    "body_panel_length_m": "body",
}

#: Of cloth, by the setting of `Fabric` that each is.
_CLOTH: Mapping[str, str] = {
    "areal_density_kg_per_m2": "areal_density",
    "membrane_stiffness_n_per_m": "membrane_stiffness",
    "bending_stiffness_n_m": "bending_stiffness",
    "poisson_ratio": "poisson",
    "friction_coefficient": "friction",
    "damping_s": "damping",
}

#: What the file of a garment may say.
GARMENT: Schema = {
    "name": Choice("what the garment is called"),
    "sleeve_length_m": Measure("m", 0.05, 0.80, "along the sleeve's axis; must be there"),
    "armhole_m": Measure("m", 0.20, 1.20, "all round, laid flat twice the width; must be there"),
    "opening_m": Measure("m", 0.12, 1.20, "all round at the sleeve's end; must be there"),
    "body_panel_length_m": Measure("m", 0.0, 0.80, "of the body that hangs from the armhole"),
    "fabric": {
        "like": Choice("what is not said of the cloth is as this one's", tuple(FABRICS)),
        "areal_density_kg_per_m2": Measure("kg/m^2", 0.02, 1.0, "mass of the cloth an area"),
        "membrane_stiffness_n_per_m": Measure("N/m", 10.0, 5000.0, "Young's modulus x thickness"),
        "bending_stiffness_n_m": Measure("N m", 1e-7, 1e-2, "plate rigidity"),
        "poisson_ratio": Measure("1", 0.0, 0.49, "Poisson's ratio"),
        "friction_coefficient": Measure("1", 0.0, 2.0, "sliding on skin"),
        "damping_s": Measure("s", 0.0, 1.0, "viscous to elastic stress an inverse second"),
    },
}


def load_garment(name_or_file: str) -> Garment:
    """A garment.

    Args:
        name_or_file: One of `GARMENTS`, one of ``assets/garments``, or a TOML file, see `GARMENT`.

    Raises:
        InvalidInputError: There is none, or the file is not valid.
    """
    return load_named(name_or_file, "garment", GARMENTS, "garments", GARMENT, garment)


def garment(values: Values) -> Garment:
    """The garment whose file says this, see `GARMENT`.

    Raises:
        InvalidInputError: A size is missing, or no sleeve is like that.
    """
    missing = [key for key in ("sleeve_length_m", "armhole_m", "opening_m") if key not in values]
    if missing:
        raise InvalidInputError(f"no {missing[0]}; valid is a sleeve's length, armhole and opening")
    cloth = dict(values.get("fabric", {}))
    fabric = FABRICS[cloth.pop("like", "jersey")]
    fabric = replace(fabric, **{_CLOTH[key]: value for key, value in cloth.items()})
    sizes = {setting: values[key] for key, setting in _SIZES.items() if key in values}
    return Garment(**sizes, fabric=fabric)


def world_with(name_or_file: str | None, config: EpisodeConfig | None = None) -> EpisodeConfig:
    """A world with another garment, see `load_garment`, or as it is for None.

    Args:
        name_or_file: The garment.
        config: The world; the default one if None.

    Raises:
        InvalidInputError: There is none, or its sleeve cannot be held or meshed.
    """
    config = EpisodeConfig() if config is None else config
    if name_or_file is None:
        return config
    worn = load_garment(name_or_file)
    try:
        sleeve = replace(config.world.sleeve, garment=worn)
    except InvalidInputError as error:
        raise InvalidInputError(f"garment {name_or_file}: {error}") from error
    return replace(config, world=replace(config.world, sleeve=sleeve))
