from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.planar.claims import CLAIMS, NEAR, Claim, judged, verdict
from dressing_sim.planar.generator import PlanarData
from dressing_sim.planar.sets import Ratio, generated, run_sets
from dressing_sim.planar.study import OPTIONS, StudyConfig

SHORT = StudyConfig(runs=1, components=4, options=replace(OPTIONS, max_iterations=3))
SETS = generated(5, 2)


@pytest.fixture(scope="module")
def studies():
    return run_sets(SETS, SHORT)


@pytest.mark.parametrize(
    ("low", "high", "below", "above", "near"),
    [
        (0.5, 0.8, "confirmed", "refuted", "refuted"),
        (0.92, 0.99, "confirmed", "refuted", "confirmed"),
        (0.5, 1.5, "undecided", "undecided", "undecided"),
        (0.95, 1.05, "undecided", "undecided", "confirmed"),
        (1.2, 1.5, "refuted", "confirmed", "refuted"),
    ],
)
def test_a_verdict_needs_the_whole_interval(low, high, below, above, near):
    ratio = Ratio(np.sqrt(low * high), low, high, 5)
    assert [verdict(ratio, side) for side in ("below", "above", "near")] == [below, above, near]


def test_one_set_decides_nothing():
    assert verdict(Ratio.of([np.log(0.5)]), "below") == "undecided"
    assert verdict(Ratio.of([0.0]), "near") == "undecided"
    assert NEAR > 1.0


def test_every_claim_can_be_judged_of_studies_with_everything(studies):
    for claim in CLAIMS:
        ratio, _ = judged(claim, studies)
        assert ratio.n == 2
        assert np.isfinite(ratio.estimate)


def test_claims_are_left_out_where_there_is_nothing_to_judge_them_by(studies):
    alone = run_sets(
        [PlanarData(one.training, ()) for one in SETS], replace(SHORT, methods=("rf",))
    )
    left = [claim.text for claim in CLAIMS if judged(claim, alone) is not None]
    assert left == [
        "*rf* reduces the cost on the training set",
        "twice the components lower the training cost",
    ]


def test_the_value_is_what_is_judged(studies):
    values = iter([np.log(0.8), np.log(0.8)])
    ratio, told = judged(Claim("it is lower", "below", lambda study: next(values)), studies)
    assert ratio.estimate == pytest.approx(0.8)
    assert told == "confirmed"
