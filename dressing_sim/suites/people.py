"""People by file: the size of an arm from what a tape measure says, a height, or a percentile.

The arm that is simulated is not what a tape measures: its segments go from joint to joint, and its
radii are means over a segment. So a person's measure m becomes that of the median arm of
`dressing_sim.arm.ARM_SIZES`, scaled by how m compares with its mean among adults of that sex:

    simulated = median * m / mean

Somebody who has every mean measure has the median arm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, astuple, replace

from scipy.stats import norm

from dressing_sim.arm import ARM_SIZES, SIZE_LIMITS, ArmSize, Posture, own_size
from dressing_sim.errors import InvalidInputError
from dressing_sim.suites.measures import Choice, Measure, Schema, Values, load_named

#: What is measured with a tape, in the order of `ArmSize`.
TAPE: Mapping[str, str] = {
    "upper_arm_length_m": "upper_arm_length",
    "upper_arm_circumference_m": "upper_arm_radius",
    "forearm_length_m": "forearm_length",
    "forearm_circumference_m": "forearm_radius",
    "hand_circumference_m": "hand_radius",
}

#: Mean of each measure in `TAPE` [m]: acromion-radiale length, flexed biceps circumference,
#: radiale-stylion length, flexed forearm circumference, hand circumference. Computed from the
#: public data of ANSUR II (Gordon et al. 2014, Natick/TR-15/007; 4082 men, 1986 women).
MEAN: Mapping[str, tuple[float, ...]] = {
    "male": (0.3352, 0.3581, 0.2679, 0.3101, 0.2123),
    "female": (0.3112, 0.3056, 0.2413, 0.2641, 0.1866),
}

#: Its standard deviation [m], same data.
DEVIATION: Mapping[str, tuple[float, ...]] = {
    "male": (0.01748, 0.03462, 0.01542, 0.02199, 0.01024),
    "female": (0.01716, 0.03076, 0.01524, 0.01852, 0.00882),
}

#: Its mean share of a person's stature, same data. Among adults lengths deviate from it by 3 to 5 %
#: (one standard deviation), circumferences by 5 to 10 %. Own choice: children have the same shares.
SHARE: Mapping[str, tuple[float, ...]] = {
    "male": (0.1909, 0.2041, 0.1525, 0.1767, 0.1210),
    "female": (0.1911, 0.1878, 0.1482, 0.1623, 0.1146),
}

#: What the file of a person may say.
PERSON: Schema = {
    "name": Choice("what the person is called"),
    "sex": Choice("whose table of means is used; must be there", tuple(MEAN)),
    "height_m": Measure("m", 0.8, 2.3, "stature; what is not measured has its usual share of it"),
    "percentile": Measure("%", 0.1, 99.9, "instead of a height: of every measure among adults"),
    "upper_arm_length_m": Measure("m", 0.10, 0.50, "acromion to the elbow's outer dimple"),
    "upper_arm_circumference_m": Measure("m", 0.10, 0.70, "round the biceps, flexed"),
    "forearm_length_m": Measure("m", 0.08, 0.45, "elbow's outer dimple to the wrist's thumb side"),
    "forearm_circumference_m": Measure("m", 0.08, 0.60, "at its thickest, fist clenched"),
    "hand_circumference_m": Measure("m", 0.08, 0.40, "round the knuckles, without the thumb"),
    "joints": {
        f"{name}_m": Measure("m", *SIZE_LIMITS[name], f"{told}, as it is simulated")
        for name, told in (
            ("upper_arm_length", "shoulder joint to elbow joint"),
            ("forearm_length", "elbow joint to wrist joint"),
            ("upper_arm_radius", "mean radius of the upper arm"),
            ("forearm_radius", "mean radius of the forearm"),
            ("hand_radius", "of the hand's sphere"),
        )
    },
}


def load_person(name_or_file: str) -> str | ArmSize:
    """The size of a person's arm.

    Args:
        name_or_file: An arm of `ARM_SIZES`, which stays a name; one of ``assets/people``; or a TOML
            file, see `PERSON`.

    Raises:
        InvalidInputError: There is none, or the file is not valid.
    """
    # A name says the same, and reads better in files.
    named: dict[str, str | ArmSize] = {name: name for name in ARM_SIZES}
    return load_named(name_or_file, "person", named, "people", PERSON, arm_size)


def arm_size(values: Values) -> ArmSize:
    """The arm of a person whose file says this, see `PERSON`.

    Raises:
        InvalidInputError: No sex, a height as well as a percentile, or no arm is like that.
    """
    if "sex" not in values:
        raise InvalidInputError(f"no sex; valid is sex = one of {', '.join(MEAN)}")
    if "height_m" in values and "percentile" in values:
        raise InvalidInputError("both height_m and percentile; valid is one of them")
    sex, mean = values["sex"], MEAN[values["sex"]]
    if "height_m" in values:
        usual = [share * values["height_m"] for share in SHARE[sex]]
    else:
        z = float(norm.ppf(values.get("percentile", 50.0) / 100.0))
        usual = [m + z * d for m, d in zip(mean, DEVIATION[sex], strict=True)]
    tape = [values.get(key, one) for key, one in zip(TAPE, usual, strict=True)]
    ratios = [one / m for one, m in zip(tape, mean, strict=True)]
    scaled = [a * b for a, b in zip(astuple(ARM_SIZES[sex]), ratios, strict=True)]
    joints = {key.removesuffix("_m"): one for key, one in values.get("joints", {}).items()}
    return own_size({**asdict(ArmSize(*scaled)), **joints}, "arm")


def as_person(postures: Sequence[Posture], person: str | ArmSize) -> list[Posture]:
    """The same postures, of the same names, with another arm."""
    return [replace(posture, size=person) for posture in postures]
