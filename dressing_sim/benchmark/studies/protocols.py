"""Protocols: which policies learn from which demonstrations, and where they are tested."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.expert import EXPERT_REPLAN
from dressing_sim.policies.registry import DEFAULT, EXPERT
from dressing_sim.policies.rivals import POLICIES as RIVALS

_CASES = ("case_a", "case_b")
_AUGMENTED = ("tp-gmm-noise", "tp-gmm-rf", "tp-gmm-rf-noise")

#: The paper's rows, and the operator.
_PAPER = (
    Entry(EXPERT),
    *(Entry(policy, case) for case in _CASES for policy in ("tp-gmm", *_AUGMENTED)),
    Entry("tp-gmm", "baseline7"),
)

#: What the package itself recommends, from two demonstrations.
_OURS = tuple(Entry(DEFAULT, case) for case in _CASES)

#: The paper's seven, and what noise alone does for the case that gains more.
_FULL = tuple(entry for entry in _PAPER[1:] if entry != Entry("tp-gmm-noise", "case_b"))

#: The same with the hyper-parameters that one budget found for each; the operator and ours beside.
_FAIR = (
    Entry(EXPERT),
    *_OURS,
    Entry(DEFAULT, "baseline7"),
    *(entry.tuned for entry in _FULL),
    *_FULL,
)

#: With and without augmentation, from two to seven demonstrations; ours from one.
_BUDGET = tuple(
    Entry(policy, f"baseline7:{n}")
    for policy, fewest in (("tp-gmm", 2), ("tp-gmm-rf", 2), (DEFAULT, 1))
    for n in range(fewest, 8)
)

#: Without and with augmentation, and the baseline: what choices are compared on.
_COMPARED = (
    *(Entry(policy, case) for case in _CASES for policy in ("tp-gmm", "tp-gmm-rf-noise")),
    Entry("tp-gmm", "baseline7"),
)

#: What worlds are compared on: the operator, ours, and the paper's at their best.
_TRIED = (Entry(EXPERT), *_OURS, *(entry.tuned for entry in _COMPARED))

#: In the nominal world, and with one factor after the other drawn anew.
_ROBUST = tuple(
    replace(entry, variation=variation)
    for entry in _TRIED
    for variation in ((), ("friction",), ("fabric",), ("arm",))
)

#: On slippery, grippy and sweaty skin: a dry forearm's sliding friction less a standard deviation,
#: its friction at rest and one more, and twice that at rest, see `variation.FRICTION`.
_FRICTION = tuple(
    replace(entry, variation=variation)
    for entry in _TRIED
    for variation in ((), ("friction=0.2",), ("friction=0.38",), ("friction=0.62",))
)

#: Where frames are told wrongly, see `variation.FRAMES`: by 5 mm and 2.5 deg to 30 mm and 15 deg.
_NOISE = tuple(
    replace(entry, variation=variation)
    for entry in _TRIED
    for variation in ((), *((f"frames={noise}",) for noise in (0.005, 0.01, 0.02, 0.03)))
)

#: How operators differ whose demonstrations are learned from: speed, height over the arm, how far
#: out the elbow is passed; and one who differs in all, slow and close to the arm.
_STYLES = (
    "speed=0.16",
    "forearm_height=0.1&elbow_height=0.115&upper_height=0.105&shoulder_height=0.11",
    "outer_distance=0.18&upper_distance=0.14",
    "speed=0.06&forearm_height=0.07&elbow_height=0.085&outer_distance=0.13",
)

#: The usual operator's demonstrations, and those of others; nothing was chosen on theirs.
_STYLED = tuple(
    replace(entry, demonstrations=f"{entry.demonstrations}{style}")
    for entry in (*_OURS, *(Entry("tp-gmm-rf-noise", case).tuned for case in _CASES))
    for style in ("", *(f"?{text}" for text in _STYLES))
)

#: What the paper leaves open, one change at a time, as hyper-parameters after a policy's name.
_CHANGES = (
    "relative_floor=true&position_floor=0.1&displacement_floor=0.1",
    "position_floor=1e-3",
    "displacement_floor=1e-6",
    "fusion=product-then-regression",
    "free_axes=arm-plane",
    "end_radius=0",
)

#: Of random situations; initial policies know none.
_AUGMENTED_CHANGES = ("situations=frames", "angle_margin_deg=0&translation_margin=0")

_CHANGED = (
    *_COMPARED,
    *(
        replace(entry, policy=f"{entry.policy}?{change}")
        for change in (*_CHANGES, *_AUGMENTED_CHANGES)
        for entry in _COMPARED
        if change in _CHANGES or entry.policy in _AUGMENTED
    ),
    # Whether noise and random frames, each alone, do more than a wider floor.
    *(
        Entry(f"{policy}{change}", "case_a")
        for policy in ("tp-gmm-noise", "tp-gmm-rf")
        for change in ("", f"?{_CHANGES[0]}")
    ),
)

#: What `transport` is made of, left out one after the other: what demonstrations agree on alone;
#: the bend as it is or sideways; a rigid motion without a Gaussian process; landmarks on the bones
#: alone; neither beyond the elbow; nor lower there; no clearance; that of the fingertips alone.
_LEFT_OUT = (
    "slope_to_noise=0",
    "feature=sideways",
    "landmark_noise=100",
    "height=0",
    "ahead=0",
    "dip=0",
    "clearance=false",
    "hand=0",
)

_ABLATED = tuple(
    replace(entry, policy=f"{entry.policy}{change}")
    for change in ("", *(f"?{text}" for text in _LEFT_OUT))
    for entry in _OURS
)

#: Other ways to learn from the same two demonstrations, the paper's and ours; the operator.
_RIVALS = (
    Entry(EXPERT),
    *_OURS,
    *(Entry(policy, case) for policy in ("tp-gmm", "tp-gmm-rf-noise") for case in _CASES),
    *(Entry(policy, case) for policy in RIVALS for case in _CASES),
)

#: Arms that move: who decides once where to go, and who looks again.
_MOVED = (
    Entry(EXPERT),
    Entry(EXPERT_REPLAN),
    *_OURS,
    *(Entry(f"{DEFAULT}-replan", case) for case in _CASES),
)

PROTOCOLS: Mapping[str, Protocol] = {
    protocol.name: protocol
    for protocol in (
        Protocol("paper", "paper5", (*_PAPER, *_OURS)),
        Protocol(
            "paper-cost",
            "paper5",
            tuple(Entry(policy, case) for case in _CASES for policy in _AUGMENTED),
            study="cost",
        ),
        Protocol("full", "test200", _FULL, demonstration_sets=5),
        Protocol("fair", "test200", _FAIR, demonstration_sets=5),
        Protocol("budget", "val50", _BUDGET, demonstration_sets=5),
        Protocol("friction", "val50", _FRICTION, demonstration_sets=5),
        Protocol("noise", "val50", _NOISE, demonstration_sets=5),
        Protocol("robust", "val50", _ROBUST, demonstration_sets=5),
        Protocol("styles", "val50", _STYLED, demonstration_sets=5),
        Protocol("settings", "val50", _CHANGED, demonstration_sets=5),
        Protocol("ablation", "train200:50", _ABLATED, demonstration_sets=5),
        Protocol("rivals", "test200", _RIVALS, demonstration_sets=5),
        Protocol("moving", "moving", _MOVED, demonstration_sets=5),
        Protocol("compliant", "compliant", _MOVED, demonstration_sets=5),
    )
}


def find_protocol(name: str) -> Protocol:
    """A protocol by its name.

    Raises:
        InvalidInputError: There is none of this name.
    """
    if name not in PROTOCOLS:
        raise InvalidInputError(
            f"unknown protocol {name!r}; valid is one of {', '.join(PROTOCOLS)}"
        )
    return PROTOCOLS[name]
