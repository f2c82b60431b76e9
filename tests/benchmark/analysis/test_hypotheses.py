import pytest

from dressing_sim.benchmark.analysis.hypotheses import PAPER_TABLE
from dressing_sim.benchmark.studies.success_tables import next_to_paper


def row(policy, demonstrations, n_success, n_episodes, **more):
    return {
        "policy": policy,
        "demonstrations": demonstrations,
        "n_success": n_success,
        "n_episodes": n_episodes,
        **more,
    }


def test_rates_stand_next_to_the_papers_with_intervals():
    cells = next_to_paper(
        [
            row("expert", None, 5, 5),
            row("tp-gmm", "case_a", 2, 4, variation=[]),
            row("tp-gmm-rf", "case_a", 0, 0),
        ]
    )
    assert cells[1:] == [
        ["expert", "-", "100 % (5 / 5)", "57 - 100 %", "-", "-"],
        ["tp-gmm", "case_a", "50 % (2 / 4)", "15 - 85 %", "20 % (1 / 5)", "4 - 62 %"],
        ["tp-gmm-rf", "case_a", "-", "0 - 100 %", "80 % (4 / 5)", "38 - 96 %"],
    ]
    assert all(len(line) == len(cells[0]) for line in cells)


def test_rows_under_variation_are_not_the_papers():
    varied = row("tp-gmm", "case_a", 2, 4, variation=["friction"])
    nominal = row("tp-gmm", "case_b", 2, 4)
    assert [line[1] for line in next_to_paper([varied, nominal])[1:]] == ["case_b"]


def test_without_a_row_of_the_papers_there_is_only_the_heading():
    assert len(next_to_paper([row("mine", "case_a", 1, 2)])) == 1


@pytest.mark.parametrize(("demonstrations", "share"), [("case_a", 8 / 15), ("case_b", 6 / 15)])
def test_the_papers_two_demonstration_policies(demonstrations, share):
    tried = [counts for (_, shown), counts in PAPER_TABLE.items() if shown == demonstrations]
    successes, trials = zip(*tried, strict=True)
    assert sum(successes) / sum(trials) == share
