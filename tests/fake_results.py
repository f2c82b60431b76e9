"""Made-up episodes of whole protocols, harder the more the elbow is bent."""

from types import SimpleNamespace

import numpy as np

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.episode.outcome import Failure, Outcome

METRICS = {"armscye_s": 1.93, "strain": 0.081, "grip_force": 1.25}
SUCCESS = Outcome(True, metrics=METRICS)
STUCK = Outcome(
    False,
    (Failure("stuck", "at the elbow", 7.0, 1.0), Failure("over_strain", "too far", 3.0, 1.0)),
    METRICS,
)
HIT = Outcome(False, (Failure("hit", "the robot touched head", 2.0, 0.5),), METRICS)
UNREACHABLE = Outcome(False, (Failure("ik_unreachable", "far"),), {"tracking_error": 0.5})
VOID = Outcome(False, invalid="solver warning BADQACC at 1.20 s")

EXPERT = Entry("expert")
SMALL = Protocol("small", "five", (EXPERT, Entry("tp-gmm", "case_a"), Entry("mine", "case_b")))
FULL = Protocol(
    "full",
    "test200",
    (
        EXPERT,
        *(
            Entry(policy, case)
            for case in ("case_a", "case_b")
            for policy in ("tp-gmm", "tp-gmm-noise", "tp-gmm-rf", "tp-gmm-rf-noise")
        ),
        Entry("tp-gmm", "baseline7"),
    ),
    demonstration_sets=5,
)
BUDGET = Protocol(
    "budget",
    "val50",
    tuple(Entry(p, f"baseline7:{n}") for p in ("tp-gmm", "tp-gmm-rf") for n in (7, 2, 4)),
)
ROBUST = Protocol(
    "robust",
    "val50",
    tuple(Entry("tp-gmm", "case_a", factors) for factors in ((), ("friction",), ("arm", "grasp"))),
)


def arm(name, elbow_deg=40.0):
    return Posture(name, 70.0, 20.0, 30.0, elbow_deg)


def outcome_of(success):
    """The outcome of an episode that succeeded, did not, or is void (None)."""
    return Outcome(False, invalid="burst") if success is None else Outcome(bool(success))


def row_of_episodes(entry, outcomes, sets):
    """Episodes of one row, posture i with demonstration set ``i mod sets``."""
    return [
        SimpleNamespace(
            index=i,
            entry=entry,
            posture=SimpleNamespace(name=f"arm{i}", elbow_deg=0.0),
            demonstration_set=i % sets,
            outcome=outcome,
        )
        for i, outcome in enumerate(outcomes)
    ]


def results_of(protocol, outcomes):
    """Results of a protocol from a list of outcomes for each of its rows, posture by posture."""
    n = max(map(len, outcomes))
    return [
        EpisodeResult(
            row * n + column,
            entry,
            arm(f"arm{column}", 10.0 * column),
            column % protocol.demonstration_sets,
            4,
            {},
            outcome,
        )
        for row, (entry, line) in enumerate(zip(protocol.entries, outcomes, strict=True))
        for column, outcome in enumerate(line)
    ]


def random_results(protocol, n_postures, seed=0):
    """Episodes of a protocol with successes, failures of several kinds, and void ones."""
    rng = np.random.default_rng(seed)
    bends = rng.uniform(5.0, 70.0, n_postures)
    results = []
    for row, entry in enumerate(protocol.entries):
        skill = 4.0 if entry.demonstrations is None else rng.uniform(-0.5, 2.0)
        for column, bend in enumerate(bends):
            margin = skill - 0.05 * (bend - 35.0) + rng.logistic()
            outcome = SUCCESS if margin > 0.0 else [STUCK, HIT, UNREACHABLE][rng.integers(3)]
            results.append(
                EpisodeResult(
                    row * n_postures + column,
                    entry,
                    arm(f"val{column}", float(bend)),
                    column % protocol.demonstration_sets,
                    int(rng.integers(2**31)),
                    {},
                    VOID if rng.random() < 0.02 else outcome,
                )
            )
    return results
