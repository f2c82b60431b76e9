import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import mannwhitneyu

from dressing_sim.benchmark.analysis.statistics import (
    Paired,
    compare,
    contrast,
    holm,
    mcnemar_p,
    rate_interval_over_sets,
    wilson_interval,
)

counts = st.integers(1, 500).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))
cells = st.lists(
    st.tuples(st.booleans(), st.booleans(), st.integers(0, 4)), min_size=1, max_size=60
)


def row(outcomes, sets=1):
    """Outcomes of postures 0, 1, ..., posture i with demonstration set ``i mod sets``."""
    return {(i % sets, f"arm{i}"): None if y is None else bool(y) for i, y in enumerate(outcomes)}


def rows_of(both=0, only_a=0, only_b=0, neither=0):
    table = [(1, 1)] * both + [(1, 0)] * only_a + [(0, 1)] * only_b + [(0, 0)] * neither
    return tuple(row(outcomes) for outcomes in zip(*table, strict=True))


def rng(seed=0):
    return np.random.default_rng(seed)


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [
        (0, 5, 0.0, 0.4345),
        (1, 5, 0.0362, 0.6245),
        (3, 5, 0.2307, 0.8824),
        (4, 5, 0.3755, 0.9638),
        (5, 5, 0.5655, 1.0),
        (0, 10, 0.0, 0.2775),
        (50, 100, 0.4038, 0.5962),
        (100, 100, 0.9630, 1.0),
    ],
)
def test_known_values(successes, trials, low, high):
    np.testing.assert_allclose(wilson_interval(successes, trials), (low, high), atol=5e-5)


@given(counts)
def test_the_interval_is_the_closed_form(count):
    successes, trials = count
    z, p = 1.959963984540054, successes / trials
    middle = (p + z**2 / (2 * trials)) / (1 + z**2 / trials)
    half = z / (1 + z**2 / trials) * np.sqrt(p * (1 - p) / trials + z**2 / (4 * trials**2))
    expected = np.clip([middle - half, middle + half], 0.0, 1.0)
    np.testing.assert_allclose(wilson_interval(successes, trials), expected, atol=1e-9)


@given(counts)
def test_the_interval_holds_the_rate_and_mirrors_failures(count):
    successes, trials = count
    low, high = wilson_interval(successes, trials)
    assert 0.0 <= low <= successes / trials <= high <= 1.0
    mirrored = wilson_interval(trials - successes, trials)
    np.testing.assert_allclose(mirrored, (1.0 - high, 1.0 - low), atol=1e-12)


def test_more_confidence_is_a_wider_interval():
    low, high = wilson_interval(3, 5, confidence=0.5)
    wider = wilson_interval(3, 5, confidence=0.99)
    assert wider[0] < low < high < wider[1]


def test_without_a_trial_nothing_is_known():
    assert wilson_interval(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("only_a", "only_b", "p"),
    [
        (10, 2, 2 * (1 + 12 + 66) / 2**12),
        (6, 0, 2 / 2**6),
        (5, 0, 2 / 2**5),
        (3, 3, 1.0),
        (0, 0, 1.0),
    ],
)
def test_mcnemar_is_the_exact_binomial(only_a, only_b, p):
    assert mcnemar_p(only_a, only_b) == pytest.approx(p)
    assert mcnemar_p(only_b, only_a) == pytest.approx(p)


def test_pairs_are_counted_by_who_succeeds():
    paired = compare(*rows_of(both=4, only_a=3, only_b=1, neither=2), rng())
    assert (paired.both, paired.only_a, paired.only_b, paired.neither) == (4, 3, 1, 2)
    assert (paired.n, paired.n_void) == (10, 0)
    assert paired.difference == pytest.approx(0.2)
    assert paired.p_value == mcnemar_p(3, 1)


def test_pairs_match_by_posture_and_set_and_void_ones_are_left_out():
    a = {(0, "x"): True, (1, "x"): False, (0, "y"): None, (0, "z"): True, (0, "only a"): True}
    b = {(0, "z"): None, (1, "x"): True, (0, "x"): False, (0, "y"): None, (2, "x"): True}
    paired = compare(a, b, rng())
    assert (paired.both, paired.only_a, paired.only_b, paired.neither) == (0, 1, 1, 0)
    assert paired.n_void == 2


def test_without_a_pair_nothing_is_known():
    paired = compare({(0, "x"): True}, {(0, "x"): None}, rng())
    assert np.isnan(paired.difference)
    assert paired.interval == (-1.0, 1.0)
    plain = paired.to_dict()
    assert plain["pc_difference"] is None
    assert plain["probability_of_improvement"] is None
    assert plain["n_void"] == 1
    json.dumps(plain, allow_nan=False)


def test_plain_values_are_percentages():
    plain = compare(*rows_of(both=4, only_a=3, only_b=1, neither=2), rng()).to_dict()
    assert plain["pc_difference"] == pytest.approx(20.0)
    low, high = plain["pc_difference_ci95"]
    assert -100.0 <= low < 20.0 < high <= 100.0
    assert plain["probability_of_improvement"] == pytest.approx(0.6)
    np.testing.assert_allclose(
        plain["probability_of_improvement_ci95"], [0.5 + low / 200, 0.5 + high / 200]
    )
    json.dumps(plain, allow_nan=False)


@given(cells)
def test_the_difference_is_antisymmetric_and_probabilities_sum_to_one(table):
    a = {(s, str(i)): y for i, (y, _, s) in enumerate(table)}
    b = {(s, str(i)): y for i, (_, y, s) in enumerate(table)}
    forth, back = compare(a, b, rng(), 200), compare(b, a, rng(), 200)
    assert forth.difference == -back.difference
    assert forth.p_value == back.p_value
    assert forth.probability_of_improvement + back.probability_of_improvement == pytest.approx(1.0)


@given(cells)
def test_the_probability_of_improvement_is_rliables(table):
    """Mean over tasks of U / (n_a n_b), each pair of posture and set a task with one run."""
    a = {(s, str(i)): y for i, (y, _, s) in enumerate(table)}
    b = {(s, str(i)): y for i, (_, y, s) in enumerate(table)}
    expected = np.mean([mannwhitneyu([a[key]], [b[key]]).statistic for key in a])
    assert compare(a, b, rng(), 10).probability_of_improvement == pytest.approx(expected)


@given(cells)
def test_the_interval_holds_the_difference_and_stays_in_range(table):
    a = {(s, str(i)): y for i, (y, _, s) in enumerate(table)}
    b = {(s, str(i)): y for i, (_, y, s) in enumerate(table)}
    paired = compare(a, b, rng(), 500)
    low, high = paired.interval
    assert -1.0 <= low <= paired.difference <= high <= 1.0


def test_the_interval_mirrors_but_for_the_draw():
    a, b = rows_of(both=40, only_a=30, only_b=10, neither=20)
    low, high = compare(a, b, rng()).interval
    np.testing.assert_allclose(compare(b, a, rng()).interval, (-high, -low), atol=0.011)


def test_the_interval_is_that_of_the_generator_whatever_the_order_of_episodes():
    a, b = row([1, 1, 0, 1, 0, 0, 1, 1], 3), row([0, 1, 1, 0, 0, 1, 0, 0], 3)
    first = compare(a, b, rng(1))
    assert compare(a, b, rng(1)) == first
    assert compare(dict(reversed(a.items())), dict(reversed(b.items())), rng(1)) == first
    assert compare(a, b, rng(2), 50).interval != compare(a, b, rng(1), 50).interval


def test_with_one_set_a_large_interval_is_the_normal_one():
    paired = compare(*rows_of(both=800, only_a=500, only_b=300, neither=400), rng())
    half = 1.96 * np.sqrt((0.25 + 0.15 - 0.1**2) / 2000)
    np.testing.assert_allclose(paired.interval, (0.1 - half, 0.1 + half), atol=2e-3)


def test_pairs_that_all_agree_leave_a_doubt_that_shrinks_with_their_number():
    few = compare(*rows_of(both=3, neither=2), rng()).interval
    many = compare(*rows_of(both=60, neither=40), rng()).interval
    assert few[0] < -0.1
    assert few[1] > 0.1
    assert -0.05 < many[0] <= 0.0 <= many[1] < 0.05


def test_two_levels_of_resampling_have_the_variance_of_both():
    """Davison and Hinkley (1997), Section 3.8: clusters and members both drawn with replacement."""
    n_sets, size = 40, 50
    shares = rng(3).uniform(0.1, 0.9, n_sets)
    first = {
        (s, f"{s} {i}"): i < round(share * size)
        for s, share in enumerate(shares)
        for i in range(size)
    }
    rates = np.array([round(share * size) / size for share in shares])
    variance = rates.var() / n_sets + np.mean(rates * (1 - rates)) / (n_sets * size)
    low, high = contrast([first], [1], rng()).interval
    assert (high - low) / (2 * 1.96) == pytest.approx(np.sqrt(variance), rel=0.04)


def test_sets_that_differ_widen_the_interval():
    lucky = [1] * 20 + [0] * 20
    apart = {(i // 20, str(i)): bool(y) for i, y in enumerate(lucky)}
    mixed = {(i % 2, str(i)): bool(y) for i, y in enumerate(lucky)}
    never = dict.fromkeys(apart, False), dict.fromkeys(mixed, False)
    wide, narrow = compare(apart, never[0], rng()), compare(mixed, never[1], rng())
    assert wide.difference == narrow.difference
    assert np.ptp(wide.interval) > 1.5 * np.ptp(narrow.interval)


def test_a_difference_of_differences_adds_up():
    draws = rng(5).random((4, 60)) < np.array([[0.8], [0.3], [0.6], [0.4]])
    rows = [row(outcomes, 3) for outcomes in draws]
    gains = contrast(rows, (1, -1, -1, 1), rng())
    first, second = compare(rows[0], rows[1], rng()), compare(rows[2], rows[3], rng())
    assert gains.estimate == pytest.approx(first.difference - second.difference)
    assert gains.successes == tuple(draws.sum(axis=1))
    low, high = gains.interval
    assert -2.0 <= low < gains.estimate < high <= 2.0
    assert high - low > np.ptp(first.interval)


def test_a_difference_of_differences_without_episodes_can_be_anything():
    assert contrast([{}, {}, {}, {}], (1, -1, -1, 1), rng()).interval == (-2.0, 2.0)


def test_more_confidence_is_a_wider_difference():
    rows = rows_of(both=10, only_a=8, only_b=3, neither=9)
    low, high = contrast(rows, (1, -1), rng(), confidence=0.8).interval
    wider = contrast(rows, (1, -1), rng(), confidence=0.99).interval
    assert wider[0] < low < high < wider[1]


@pytest.mark.parametrize(
    ("n", "sets", "spread", "least"),
    [(5, 1, 0.0, 0.93), (40, 1, 0.0, 0.91), (50, 5, 0.0, 0.93), (100, 5, 0.3, 0.86)],
)
def test_the_interval_covers_the_true_difference(n, sets, spread, least):
    """Rates 0.7 and 0.4 on average; each set moves both apart or together, `spread` in all."""
    draw, hits, trials = rng(7), 0, 300
    for _ in range(trials):
        luck = draw.uniform(-spread, spread, sets)[np.arange(n) % sets] / 2
        a, b = draw.random(n) < 0.7 + luck, draw.random(n) < 0.4 - luck
        low, high = compare(row(a, sets), row(b, sets), draw, 400).interval
        hits += low <= 0.3 + 1e-9 and high >= 0.3 - 1e-9
    assert least <= hits / trials


def test_a_paired_result_cannot_be_changed():
    paired = Paired(1, 2, 3, 4, 0, (-0.5, 0.5))
    with pytest.raises(AttributeError):
        paired.both = 2


def rows_of_sets(*successes, n=40):
    """A row with so many successes among the n episodes of each set."""
    return {
        (number, f"arm{i}"): i < many for number, many in enumerate(successes) for i in range(n)
    }


def test_one_set_says_nothing_of_others():
    assert rate_interval_over_sets(rows_of_sets(30), np.random.default_rng(0)) is None
    assert rate_interval_over_sets({}, np.random.default_rng(0)) is None


def test_sets_alike_give_about_wilson_s_interval_and_sets_that_differ_a_wider_one():
    alike = rate_interval_over_sets(rows_of_sets(30, 30, 30, 30, 30), np.random.default_rng(0))
    wilson = wilson_interval(150, 200)
    np.testing.assert_allclose(alike, wilson, atol=0.02)
    apart = rate_interval_over_sets(rows_of_sets(40, 40, 30, 20, 20), np.random.default_rng(0))
    assert apart[1] - apart[0] > 1.8 * (wilson[1] - wilson[0])
    assert apart[0] < 0.75 < apart[1]


def quantiles_of_a_mean(values, probabilities, n, shares):
    """Quantiles of the mean of n independent draws, whose distribution is a convolution."""
    total = np.ones(1)
    for _ in range(n):
        total = np.convolve(total, probabilities)
    return min(values) + np.searchsorted(np.cumsum(total), shares) / n


@pytest.mark.parametrize(("both", "only_a", "only_b", "neither"), [(5, 0, 0, 0), (3, 4, 1, 3)])
@pytest.mark.parametrize("confidence", [0.95, 0.7])
def test_one_set_is_a_bootstrap_with_half_an_episode_more_in_each_cell(
    both, only_a, only_b, neither, confidence
):
    rows = rows_of(both, only_a, only_b, neither)
    n = both + only_a + only_b + neither
    cells = np.array([only_b + 0.5, both + neither + 1.0, only_a + 0.5])
    tail = (1 - confidence) / 2
    expected = quantiles_of_a_mean([-1, 0, 1], cells / (n + 2), n, [tail, 1 - tail])
    found = contrast(rows, (1, -1), rng(), confidence, 20_000).interval
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_single_row_has_one_success_and_one_failure_more():
    expected = quantiles_of_a_mean([0, 1], np.array([1, 9]) / 10, 8, [0.025, 0.975])
    np.testing.assert_allclose(contrast([row([1] * 8)], (1,), rng()).interval, expected)


def test_the_pseudo_episodes_are_spread_over_the_sets():
    """All alike in every set: whichever sets are drawn, each has two in so many more episodes."""
    episodes = {(s, f"{s} {i}"): True for s in range(4) for i in range(5)}
    share = 0.25 / 5.5
    expected = quantiles_of_a_mean([0, 1], [share, 1 - share], 20, [0.025, 0.975])
    np.testing.assert_allclose(contrast([episodes], (1,), rng()).interval, expected)


def test_sets_of_unequal_size_count_by_their_episodes():
    """A set drawn brings as many episodes as it has, so the mean is over all that were drawn."""
    big = {(0, f"{i}"): True for i in range(400)}
    small = {(1, f"{i}"): False for i in range(100)}
    # Both sets once (half of the draws): about 400 in 500.
    middle = contrast([big | small], (1,), rng(), confidence=0.4).interval
    np.testing.assert_allclose(middle, (0.8, 0.8), atol=0.02)
    assert contrast([big | small], (1,), rng()).interval[0] < 0.03


def test_two_sets_are_enough_to_speak_of_others():
    rows = rows_of_sets(30, 30)
    assert rate_interval_over_sets(rows, rng(4)) == contrast([rows], (1,), rng(4)).interval


def test_a_weighted_sum_without_an_episode_is_no_number_and_counts_what_is_void():
    rows = [{(0, "x"): True, (0, "y"): None}, {(0, "x"): None, (0, "y"): True, (0, "z"): True}]
    empty = contrast(rows, (2, -1), rng())
    assert np.isnan(empty.estimate)
    assert (empty.n, empty.n_void, empty.successes) == (0, 2, (0, 0))
    assert empty.interval == (-1.0, 2.0)
    assert (empty.weights, contrast(rows[:1], (3,), rng()).estimate) == ((2, -1), 3.0)


def test_the_scale_of_a_probability_is_that_of_a_difference():
    paired = Paired(1, 5, 2, 2, 3, (-0.5, 0.75))
    assert paired.to_dict() == {
        "n_pairs": 10,
        "n_void": 3,
        "n_both": 1,
        "n_only_a": 5,
        "n_only_b": 2,
        "n_neither": 2,
        "pc_difference": pytest.approx(30.0),
        "pc_difference_ci95": [-50.0, 75.0],
        "p_mcnemar": pytest.approx(2 * (1 + 7 + 21) / 2**7),
        "probability_of_improvement": pytest.approx(0.65),
        "probability_of_improvement_ci95": [0.25, 0.875],
    }


def test_intervals_are_of_ten_thousand_samples_unless_asked_for_others():
    a, b = row([1, 1, 0, 1, 0, 0, 1, 1], 3), row([0, 1, 1, 0, 0, 1, 0, 0], 3)
    sources = rng(1), rng(1), rng(1), rng(1)
    one, other = compare(a, b, sources[0]), compare(a, b, sources[1], 10_000)
    assert one.interval == other.interval
    one, other = contrast((a, b), (1, -1), sources[2]), contrast((a, b), (1, -1), sources[3])
    assert one == other
    # Each has drawn as much of its source as the others.
    assert len({str(source.bit_generator.state) for source in sources}) == 1


def test_holm_multiplies_the_smallest_by_their_number_and_never_changes_their_order():
    # By hand: 4 x 0.005, 3 x 0.01, 2 x 0.03, and 0.04, which may not be below the one before.
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([]) == []
    assert holm([0.7]) == [0.7]
    p = np.random.default_rng(0).random(30)
    corrected = np.array(holm(p))
    assert (corrected >= p).all()
    assert (corrected <= np.minimum(1.0, 30 * p)).all()  # never beyond Bonferroni's
    assert (np.diff(corrected[np.argsort(p)]) >= 0.0).all()
