import pytest
from fake_trials import STUCK, outcome

from dressing_sim.benchmark.studies.convergence_ladders import (
    LADDERS,
    METRICS,
    refined,
    refinement_table,
)
from dressing_sim.benchmark.studies.convergence_trials import PATHS, Trial, settings

SETTINGS = {setting.name: setting for setting in settings()}


@pytest.mark.parametrize("ladder", LADDERS, ids=lambda ladder: ladder.what)
def test_a_ladder_refines_one_thing_in_three_levels(ladder):
    sizes = [ladder.size(SETTINGS[name].config) for name in ladder.levels]
    assert 0.0 < sizes[0] < sizes[1] < sizes[2]
    others = [other for other in LADDERS if other is not ladder]
    for other in others:
        assert len({other.size(SETTINGS[name].config) for name in ladder.levels}) == 1


def test_metrics_are_extrapolated_over_the_episodes_that_succeed_on_all_levels():
    ladder = LADDERS[0]
    chosen = [SETTINGS[name] for name in ladder.levels]
    made = []
    for setting in chosen:
        size = ladder.size(setting.config)
        for kind in PATHS:
            for i in range(5):
                stuck = STUCK if i == 2 and setting.name == "coarse mesh" else ()
                strain = 9.0 if i == 2 else 0.1 + 20.0 * size**2
                made.append(Trial(len(made), setting.name, kind, f"p{i}", outcome(stuck, strain)))
    rows = refined(made, chosen)
    assert {row["ladder"] for row in rows} == {ladder.what}
    assert [row["metric"] for row in rows] == list(METRICS)
    pull, strain, s = rows
    assert strain["n_episodes"] == 4 * len(PATHS)
    assert strain["order"] == pytest.approx(2.0)
    assert strain["limit"] == pytest.approx(0.1)
    assert pull["limit"] == pytest.approx(1.0)
    assert (s["order"], s["index"]) == (None, 0.0)
    assert len(refinement_table({"refinement": rows})) == 4


def test_a_ladder_without_dressings_says_nothing():
    chosen = [SETTINGS[name] for name in LADDERS[0].levels]
    made = [Trial(i, s.name, "expert", "p", outcome(STUCK)) for i, s in enumerate(chosen)]
    assert refined(made, chosen) == []
