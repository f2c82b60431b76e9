"""What is odd about demonstrations, by name: standing still for long, and being cut short.

Neither is an error: the library learns from them. But ten seconds of standing still before a motion
give a policy that never starts, and a demonstration that stops half way one that does too, so
policies tell of them as they learn.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from dressing_sim.checks import real_number
from dressing_sim.learning.demonstrations import (
    DemonstrationLike,
    check_demonstrations,
    duration,
)
from dressing_sim.learning.frame import FloatArray
from dressing_sim.learning.registration import (
    ALIKE,
    MISSED,
    by_phase,
    landmarks_of,
    moving_part,
    path_length,
)
from dressing_sim.learning.transport import Transport

_LOG = logging.getLogger("dressing_sim")

#: A demonstration is compared with so many others: what is cut short, most will tell.
_MOST_OTHERS = 8

#: Into which paths are cut to tell how far along one something is.
_ROWS = 100

#: An end that is this near to another demonstration's, as a fraction of its length, is its end.
_SAME_END = 0.1

#: A point is nearer than the end if it is at less than this part of its distance.
_NEARER = 0.8

Kind = Literal["rest at start", "rest at end", "begins late", "cut short"]


@dataclass(frozen=True, slots=True)
class Remark:
    """What is odd about a demonstration.

    Attributes:
        demonstration: which, from 0.
        kind: ``"rest at start"``, ``"rest at end"``, ``"begins late"`` or ``"cut short"``.
        amount: how long it stands still [s]; or where on the way of the others it begins or ends,
            from 0 to 1.
    """

    demonstration: int
    kind: Kind
    amount: float

    def __str__(self) -> str:
        """The remark in one line."""
        told = {
            "rest at start": f"stands still for {self.amount:.3g} s at its start",
            "rest at end": f"stands still for {self.amount:.3g} s at its end",
            "begins late": f"begins {self.amount:.0%} on the way of the others",
            "cut short": f"was cut short: it ends {self.amount:.0%} on the way of the others",
        }
        return f"demonstration {self.demonstration} {told[self.kind]}"


def remarks(
    demonstrations: Sequence[DemonstrationLike],
    *,
    still: float = 2e-3,
    rest_share: float = 0.2,
    least_share: float = 0.8,
) -> tuple[Remark, ...]:
    """What is odd about demonstrations.

    Args:
        demonstrations: at least one; alone, none can be told to be cut short.
        still: one stands still while it is within this fraction of its length of its start, and of
            its end.
        rest_share: for how much of its duration it may.
        least_share: one that ends before this share of the way of the others is cut short; one that
            begins after the rest of it begins late.

    Raises:
        InvalidInputError: demonstrations that cannot be learned from, or a share out of range.
    """
    checked = check_demonstrations(demonstrations)
    for name, value in (("still", still), ("rest_share", rest_share), ("least_share", least_share)):
        real_number(value, name, 0.0, 1.0)
    found: list[Remark] = []
    for index, one in enumerate(checked):
        _, times = moving_part(np.asarray(one.positions), one.dt, still)
        rests: tuple[tuple[Kind, float], ...] = (
            ("rest at start", float(times[0])),
            ("rest at end", duration(one) - float(times[-1])),
        )
        found += [
            Remark(index, kind, rest) for kind, rest in rests if rest > rest_share * duration(one)
        ]
    return (*found, *incomplete(checked, still, least_share))


def incomplete(
    demonstrations: Sequence[DemonstrationLike], still: float, least_share: float
) -> list[Remark]:
    """Demonstrations that begin late or end early, next to the others carried to their situation.

    One does if, carried to another's situation, its end is far from that one's end and nearer to a
    point before; of several others the median tells.
    """
    if len(demonstrations) < 2 or least_share == 0.0:
        return []
    paths = [by_phase(one, still, _ROWS).points for one in demonstrations]
    lengths = [path_length(path) for path in paths]
    scale = float(np.mean(lengths))
    landmarks = [landmarks_of(one.frames, scale) for one in demonstrations]
    found: list[Remark] = []
    for index, path in enumerate(paths):
        others = [j for j in range(len(paths)) if j != index][:_MOST_OTHERS]
        shares = []
        for j in others:
            carry = Transport.between(landmarks[index], landmarks[j], ALIKE * scale, MISSED)
            ends = carry(path[[0, -1]])
            backwards = 1.0 - _share(paths[j][::-1], ends[0], lengths[j])
            shares.append((backwards, _share(paths[j], ends[1], lengths[j])))
        begins, ends_at = np.median(shares, axis=0)
        if begins > 1.0 - least_share:
            found.append(Remark(index, "begins late", float(begins)))
        if ends_at < least_share:
            found.append(Remark(index, "cut short", float(ends_at)))
    return found


def _share(path: FloatArray, point: FloatArray, length: float) -> float:
    """How far along a path (N, p), even in length, a point is that should be its end: 0 to 1."""
    distances = np.linalg.norm(path - point, axis=1)
    nearest = int(np.argmin(distances))
    if distances[-1] < _SAME_END * length or distances[nearest] > _NEARER * distances[-1]:
        return 1.0
    return nearest / (len(path) - 1)


def tell(demonstrations: Sequence[DemonstrationLike]) -> None:
    """Log the remarks on demonstrations that a policy is about to learn from as they are."""
    for remark in remarks(demonstrations):
        _LOG.warning("%s; an alignment of the policy trims and checks demonstrations", remark)
