import json
from dataclasses import replace

import pytest
from fake_benchmark import write_suite

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.plan import (
    Plan,
    demonstration_seed,
    fitting_seed,
    make_plan,
    posture_seed,
    variation_seed,
)
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.variation import FACTORS
from dressing_sim.errors import InvalidInputError
from dressing_sim.provenance import versions
from dressing_sim.suites.suites import load_suite

ENTRIES = (Entry("expert"), Entry("tp-gmm", "case_a"), Entry("tp-gmm", "baseline7:3"))


@pytest.fixture
def protocol(tmp_path):
    return Protocol("p", write_suite(tmp_path / "suite.json", 5), ENTRIES, demonstration_sets=3)


def test_episodes_are_all_test_postures_of_a_row_and_then_of_the_next(protocol):
    plan = make_plan(protocol, seed=7)
    assert [job.index for job in plan.jobs] == list(range(15))
    assert [(job.entry, job.posture.name) for job in plan.jobs] == [
        (entry, f"arm{i}") for entry in ENTRIES for i in range(5)
    ]


def test_rows_are_paired_by_posture_set_and_seed(protocol):
    jobs = make_plan(protocol, seed=7).jobs
    rows = [
        [(j.posture, j.demonstration_set, j.seed) for j in jobs if j.entry == e] for e in ENTRIES
    ]
    assert rows[0] == rows[1] == rows[2]
    assert [number for _, number, _ in rows[0]] == [0, 1, 2, 0, 1]
    assert len({seed for *_, seed in rows[0]}) == 5


def test_what_is_shown_is_what_the_rows_name(protocol):
    plan = make_plan(protocol)
    assert list(plan.demonstrated) == ["case_a", "baseline7:3"]
    assert list(plan.demonstrated["baseline7:3"]) == load_suite("baseline7")[:3]


def test_a_plan_is_the_same_after_a_file(protocol):
    plan = make_plan(
        replace(protocol, entries=(*ENTRIES, Entry("tp-gmm", "case_b"))),
        seed=3,
        config=EpisodeConfig(hold=0.1 + 0.2),
    )
    values = json.loads(json.dumps(plan.to_dict()))
    assert Plan.from_dict(values) == plan
    assert values["versions"] == versions()


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"suite": "nowhere"}, "nowhere"),
        ({"entries": (Entry("nobody", "case_a"),)}, "nobody"),
        ({"entries": (Entry("tp-gmm", "nowhere"),)}, "nowhere"),
        ({"entries": (Entry("tp-gmm", "case_a:3"),)}, "case_a:3"),
        ({"entries": (Entry("tp-gmm"),)}, "nothing to learn from"),
        ({"entries": ()}, "no rows"),
        ({"entries": (Entry("expert", None, ("colour",)),)}, "unknown factor 'colour'"),
    ],
)
def test_a_mistake_is_an_error_before_anything_runs(protocol, change, part):
    with pytest.raises(InvalidInputError, match=part):
        make_plan(replace(protocol, **change))


def test_every_posture_set_and_attempt_is_demonstrated_with_a_seed_of_its_own(posture):
    names = ["a", "b", "ab", "ba", "", "Ω", "a" * 2000, "0/0 a"]
    seeds = {
        (seed, number, attempt, name): demonstration_seed(
            seed, replace(posture, name=name), number, attempt
        )
        for seed in (0, 1, 2**31)
        for number in range(3)
        for attempt in range(3)
        for name in names
    }
    assert len(set(seeds.values())) == len(seeds)
    assert all(0 <= seed < 2**32 for seed in seeds.values())
    bent = replace(posture, name="a", elbow_deg=3.0)
    assert posture_seed(1, bent) == seeds[1, 0, 0, "a"]


def test_seeds_stay_what_they_are():
    # Published results depend on them.
    (posture, *_) = load_suite("paper5")
    assert posture_seed(0, posture) == 674733354
    assert demonstration_seed(0, posture, 1, 2) == 3990030615
    assert fitting_seed(0, Entry("tp-gmm", "case_a"), 0) == 3913875991
    assert variation_seed(0, posture) == 4139423629


def test_a_policy_is_fitted_with_a_seed_of_its_own_whatever_varies():
    seeds = {
        fitting_seed(seed, Entry(policy, shown), number)
        for seed in (0, 1)
        for policy in ("a", "b")
        for shown in ("x", "y")
        for number in (0, 1)
    }
    assert len(seeds) == 16
    assert fitting_seed(0, Entry("a", "x", ("arm",)), 0) == fitting_seed(0, Entry("a", "x"), 0)


def test_an_episode_without_variation_is_as_planned(protocol):
    plan = make_plan(protocol)
    assert plan.jobs[0].situation(plan.config) == (plan.tested[0], plan.config, {})


def test_a_variation_is_drawn_anew_for_each_posture_and_the_same_for_each_policy(protocol):
    plan = make_plan(protocol.with_variation(["friction", "arm"]), seed=3)
    drawn = [job.situation(plan.config) for job in plan.jobs]
    assert drawn[:5] == drawn[5:10] == drawn[10:]
    assert len({values["friction"] for *_, values in drawn}) == 5
    assert all(config != plan.config for _, config, _ in drawn)
    assert drawn == [job.situation(plan.config) for job in plan.jobs]
    again = make_plan(protocol.with_variation(["friction", "arm"]), seed=4)
    assert again.jobs[0].situation(plan.config) != drawn[0]


def test_what_is_drawn_can_be_written_to_a_file(protocol):
    plan = make_plan(protocol.with_variation(FACTORS))
    for job in plan.jobs[:5]:
        _, _, drawn = job.situation(plan.config)
        assert set(drawn) == set(FACTORS)
        assert json.loads(json.dumps(drawn)) == drawn
