import json
from pathlib import Path

import pytest

from dressing_sim.policies import paper, tuned
from dressing_sim.policies.hyperparameters import TUNED, changed
from dressing_sim.policies.registry import make_policy
from dressing_sim.policies.search_spaces import SPACES

RESULTS = Path(__file__).parents[2] / "docs/results"


def test_each_policy_of_the_paper_is_tuned():
    assert set(tuned.CHOSEN) >= set(paper.POLICIES)


@pytest.mark.parametrize("name", tuned.CHOSEN)
def test_what_is_chosen_is_what_the_search_found(name):
    found = json.loads((RESULTS / f"tune-{name}.json").read_text())
    assert found["chosen"] == f"{name}?{tuned.CHOSEN[name]}"
    assert found["search"]["trials"] == 60


def test_all_had_the_same_budget():
    files = [json.loads((RESULTS / f"tune-{name}.json").read_text()) for name in tuned.CHOSEN]
    searches = [found["search"] for found in files]
    assert all({**one, "policy": ""} == {**searches[0], "policy": ""} for one in searches)


@pytest.mark.parametrize("name", tuned.CHOSEN)
def test_a_tuned_policy_has_what_was_chosen_and_can_be_changed_further(name):
    config = tuned.POLICIES[f"{name}{TUNED}"]
    assert config == changed(paper.POLICIES[name], tuned.CHOSEN[name])
    assert set(dict(part.split("=") for part in tuned.CHOSEN[name].split("&"))) <= set(SPACES[name])
    make_policy(f"{name}{TUNED}")
    make_policy(f"{name}{TUNED}?end_radius=0.3" if name in paper.POLICIES else f"{name}{TUNED}")
