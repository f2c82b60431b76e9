import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.benchmark import runner
from dressing_sim.benchmark.policies import EXPERT
from dressing_sim.benchmark.protocol import Entry, Protocol
from dressing_sim.benchmark.runner import posture_seed, process_pool, run_protocol
from dressing_sim.benchmark.suites import load_suite
from dressing_sim.demonstration import Demonstration
from dressing_sim.episode import EpisodeConfig, Recording
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.judge import Failure, Outcome, Thresholds
from dressing_sim.operator import Operator
from dressing_sim.world.scene import WorldConfig
from dressing_sim.world.sleeve import SleeveConfig

ANGLES = {"flexion_deg": 75, "abduction_deg": 20, "rotation_deg": 40}

#: A coarse sleeve and rules that forgive all: quick, and every demonstration can be learned from.
QUICK = EpisodeConfig(
    world=WorldConfig(sleeve=SleeveConfig(vertices_around=10, vertices_along=4)),
    thresholds=replace(Thresholds(), armscye_s=-9.0, strain=9.0, grip_force=1e3, link_force=1e3),
    hold=0.2,
)


def suite_file(folder, name, *postures):
    path = folder / f"{name}.json"
    arms = [{"name": n, "elbow_deg": elbow, **ANGLES} for n, elbow in postures]
    path.write_text(json.dumps({"postures": arms}))
    return str(path)


@pytest.fixture(scope="module")
def protocol(tmp_path_factory):
    """Two rows, two test postures; one of the two demonstrated ones is in both sets."""
    folder = tmp_path_factory.mktemp("suites")
    test = suite_file(folder, "test", ("t1", 10), ("t2", 20))
    first = suite_file(folder, "first", ("a", 15))
    second = suite_file(folder, "second", ("b", 25), ("a", 15))
    return Protocol("tiny", test, (Entry("tp-gmm", first), Entry(EXPERT), Entry("tp-gmm", second)))


@pytest.fixture
def faked(monkeypatch):
    """Demonstrations and episodes without physics; who was asked for what is noted."""
    asked = {"demonstrated": [], "dressed": []}

    def demonstrate(posture, seed, operator, config):
        asked["demonstrated"].append((posture.name, seed))
        line = np.linspace(posture.wrist, posture.shoulder, 30)
        made = Demonstration(line, 0.05, posture, seed, np.zeros((30, 7)))
        return made, Outcome(True)

    def record(source, posture, seed, config):
        asked["dressed"].append((type(source).__name__, posture.name, seed))
        figures = {"strain": posture.elbow_deg}
        return Recording(Outcome(posture.name == "t1", figures=figures), None, None, None)

    monkeypatch.setattr(runner, "demonstrate", demonstrate)
    monkeypatch.setattr(runner, "record", record)
    return asked


def run(protocol, **arguments):
    with ThreadPoolExecutor(1) as executor:
        return run_protocol(protocol, executor, **arguments)


def test_one_worker_and_two_give_identical_results(protocol):
    small = replace(protocol, entries=protocol.entries[:2])

    def results(workers):
        with process_pool(workers) as executor:
            found = run_protocol(small, executor, seed=3, config=QUICK)
        return [(r.entry, r.posture, r.seed, r.outcome.to_dict()) for r in found]

    one = results(1)
    assert one == results(2)
    assert len(one) == 4
    assert all(outcome["figures"] for *_, outcome in one)


def test_results_are_one_a_row_and_posture_in_their_order(protocol, faked):
    results = run(protocol, seed=5)
    assert [(r.entry, r.posture.name) for r in results] == [
        (entry, name) for entry in protocol.entries for name in ("t1", "t2")
    ]
    assert all(r.seed == posture_seed(5, r.posture) for r in results)
    assert [seed for *_, seed in faked["dressed"]] == [r.seed for r in results]
    assert [r.outcome.success for r in results] == [True, False] * 3
    sources = [source for source, *_ in faked["dressed"]]
    assert sources[2:4] == [Operator.__name__] * 2
    assert Operator.__name__ not in sources[:2] + sources[4:]


def test_a_posture_in_two_suites_is_demonstrated_once_with_a_seed_of_its_own(protocol, faked):
    run(protocol, seed=5)
    seeds = dict(faked["demonstrated"])
    assert sorted(name for name, _ in faked["demonstrated"]) == ["a", "b"]
    assert seeds["a"] != seeds["b"]
    (alone,) = load_suite(protocol.entries[0].demonstrations)
    assert seeds["a"] == posture_seed(5, alone)


def test_progress_counts_demonstrations_and_then_episodes(protocol, faked):
    told = []
    run(protocol, progress=lambda stage, done, total, results: told.append(
        (stage, done, total, len(results))
    ))  # fmt: skip
    assert told == [
        *(("demonstrations", done, 2, 0) for done in range(3)),
        *(("episodes", done, 6, done) for done in range(7)),
    ]


@pytest.mark.parametrize(
    "outcome",
    [
        Outcome(False, (Failure("stuck", "the armscye stayed at the elbow"),)),
        Outcome(False, void="the armscye stayed at the elbow"),
    ],
)
def test_a_failed_demonstration_is_an_error_that_names_it(protocol, faked, monkeypatch, outcome):
    monkeypatch.setattr(runner, "demonstrate", lambda *arguments: (None, outcome))
    with pytest.raises(DressingSimError, match=r"'[ab]' with seed 7 failed: .*at the elbow"):
        run(protocol, seed=7)
    assert faked["dressed"] == []


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"suite": "nowhere"}, "nowhere"),
        ({"entries": (Entry("nobody", "case_a"),)}, "nobody"),
        ({"entries": (Entry("tp-gmm", "nowhere"),)}, "nowhere"),
    ],
)
def test_unknown_names_are_errors_before_anything_runs(protocol, faked, change, part):
    with pytest.raises(InvalidInputError, match=part):
        run(replace(protocol, **change))
    assert faked == {"demonstrated": [], "dressed": []}


def test_an_error_in_a_worker_reaches_whoever_asked(protocol):
    with pytest.raises(InvalidInputError, match="nothing"), process_pool(1) as executor:
        executor.submit(load_suite, "nothing").result()


def test_a_posture_has_a_seed_of_its_own_by_seed_and_name_alone(posture):
    names = ["a", "b", "ab", "ba", "", "Ω", "a" * 2000]
    seeds = {
        (seed, name): posture_seed(seed, replace(posture, name=name))
        for seed in (0, 1, 2**31)
        for name in names
    }
    assert len(set(seeds.values())) == len(seeds)
    assert all(0 <= seed < 2**32 for seed in seeds.values())
    bent = replace(posture, name="a", elbow_deg=3.0)
    assert posture_seed(1, bent) == seeds[1, "a"]
