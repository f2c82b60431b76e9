"""What a judge looks at, and a policy that abstains."""

import json
import math

import numpy as np
import pytest
from fake_benchmark import Threads, steady_demonstrate

from dressing_sim.arm import Posture
from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.failures import hardest
from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.report.markdown import markdown
from dressing_sim.benchmark.run import runner
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.studies.study import run_study
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.recording import Recording
from dressing_sim.errors import Abstained, InvalidInputError
from dressing_sim.learning import Frame, SyntheticDemonstration, rotation
from dressing_sim.learning.calibration import Logistic
from dressing_sim.policies.confidence import FEATURES, Judge, JudgedPolicy, PathFeatures, pose_of
from dressing_sim.policies.hosted import hosted_policy
from dressing_sim.policies.registry import make_policy
from dressing_sim.policies.skeleton import Skeleton
from dressing_sim.suites.suites import load_suite
from dressing_sim.world.scene import WorldConfig, grip_start

VALIDATION = load_suite("val50")


def begin(posture):
    return grip_start(posture, WorldConfig().sleeve)


def demonstration(posture, seed):
    path = Operator().generate(posture, begin(posture), seed)
    return SyntheticDemonstration(path.positions, path.dt, posture.frames())


SHOWN = [demonstration(posture, seed) for seed, posture in enumerate(load_suite("case_a"))]
SEEN = PathFeatures(SHOWN)


def looked(frames, path):
    return dict(zip(FEATURES, SEEN.of(frames, path), strict=True))


def judge(weight=-8.0, policy="transport"):
    """Certain where the arm is straight, and the less so the more it is bent."""
    weights = np.zeros(len(FEATURES))
    weights[0] = weight
    zeros, ones = np.zeros(len(FEATURES)), np.ones(len(FEATURES))
    return Judge(policy, "case_a", Logistic(zeros, ones, weights, 4.0), 50, "val50, seed 0")


def test_a_demonstration_itself_is_nothing_new():
    shown = SHOWN[0]
    found = looked(shown.frames, shown.positions)
    assert found["novelty"] == pytest.approx(0.0, abs=0.02)
    assert found["shortfall"] < 5e-3
    assert found["passes"] == 1.0
    assert found["end_height"] > 0.0
    assert found["reach"] > 0.0
    posture = VALIDATION[0]
    assert looked(posture.frames(), shown.positions)["novelty"] > 0.1


def test_features_tell_what_is_wrong_with_a_path():
    shown = SHOWN[0]
    good = looked(shown.frames, shown.positions)
    skeleton = Skeleton.of(shown.frames)
    near = looked(shown.frames, shown.positions - 0.5 * skeleton.outward(shown.positions))
    assert near["shortfall"] > good["shortfall"] + 0.05
    assert near["hand_shortfall"] > good["hand_shortfall"]
    assert near["disagreement"] > good["disagreement"]
    short = looked(shown.frames, shown.positions[:30])
    assert (short["passes"], short["end_distance"] > good["end_distance"]) == (0.0, True)
    far = looked(shown.frames, 1.5 * shown.positions)
    assert far["reach"] < 0.0 < good["reach"]
    assert all(map(np.isfinite, [*near.values(), *short.values(), *far.values()]))


def test_all_but_the_reach_are_the_same_where_the_scene_is_turned_and_moved():
    turn, shift = rotation([0.0, 0.0, 0.9]), np.array([0.1, -0.2, 0.1])
    posture = VALIDATION[1]
    path = demonstration(posture, 3).positions
    frames = [Frame(turn @ f.A, turn @ f.b + shift) for f in posture.frames()]
    found, there = looked(posture.frames(), path), looked(frames, path @ turn.T + shift)
    for name in set(FEATURES) - {"reach"}:
        assert there[name] == pytest.approx(found[name], abs=1e-6), name


@pytest.mark.parametrize("upright", [False, True])
def test_the_pose_of_an_arm_does_not_depend_on_where_it_faces(upright):
    elbow = np.array([0.0, 0.0, -0.3]) if upright else np.array([0.2, 0.1, -0.2])
    arm = Skeleton(np.zeros(3), elbow, elbow + [0.1, 0.2, 0.1])
    turn = rotation([0.0, 0.0, 2.0])
    joints = (arm.shoulder, arm.elbow, arm.wrist)
    moved = Skeleton(*(turn @ joint + [1.0, 2.0, 3.0] for joint in joints))
    np.testing.assert_allclose(pose_of(moved), pose_of(arm), atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(pose_of(arm).reshape(2, 3), axis=1), 1.0)


def test_a_judge_is_the_same_from_its_file(tmp_path):
    judge().save(tmp_path / "judge.json")
    loaded = Judge.load(tmp_path / "judge.json")
    assert loaded.to_dict() == judge().to_dict()
    features = SEEN.of(SHOWN[0].frames, SHOWN[0].positions)
    assert loaded.probability(features) == judge().probability(features)


def damaged(part, value):
    values = judge().to_dict()
    values[part] = value
    return json.dumps(values)


SCALE = judge().to_dict()["features"] | {"bend": {"mean": 0.0, "scale": 0.0, "weight": 1.0}}
MEAN = judge().to_dict()["features"] | {"bend": {"mean": True, "scale": 1.0, "weight": 1.0}}


@pytest.mark.parametrize(
    "damage",
    [
        *("[]", "{}", '{"features": {"bend": 1}}', "no", '{"policy": "a", "policy": "b"}'),
        *(damaged("n_episodes", value) for value in (math.inf, "5", 2.5, -1)),
        *(damaged("features", value) for value in (SCALE, MEAN)),
        *(damaged(part, 3) for part in ("policy", "source", "more")),
    ],
)
def test_a_damaged_judge_is_one_line(tmp_path, damage):
    (tmp_path / "judge.json").write_text(damage)
    with pytest.raises(InvalidInputError, match=r"judge\.json") as caught:
        Judge.load(tmp_path / "judge.json")
    assert "\n" not in str(caught.value)


def test_a_policy_with_a_judge_makes_the_same_path_and_says_how_likely_it_is(tmp_path):
    judge().save(tmp_path / "judge.json")
    name = f"transport?judge={tmp_path / 'judge.json'}"
    policy, plain = (hosted_policy(one).fit(SHOWN) for one in (name, "transport"))
    for posture in VALIDATION[:3]:
        path = policy.generate(posture.frames(), begin(posture))
        own = plain.generate(posture.frames(), begin(posture))
        np.testing.assert_array_equal(path.positions, own.positions)
        assert (path.dt, own.probability) == (own.dt, None)
        bend = Skeleton.of(posture.frames()).bend
        assert path.probability == pytest.approx(1.0 / (1.0 + np.exp(8.0 * bend - 4.0)), abs=0.02)


def test_it_abstains_below_its_threshold_alone(tmp_path):
    judge().save(tmp_path / "judge.json")
    policy = hosted_policy(f"default?abstain=0.5&judge={tmp_path / 'judge.json'}").fit(SHOWN)
    bent = [Skeleton.of(posture.frames()).bend > 0.5 for posture in VALIDATION[:6]]
    assert set(bent) == {True, False}
    for posture, too_much in zip(VALIDATION[:6], bent, strict=True):
        if too_much:
            with pytest.raises(Abstained, match=r"below 0\.5"):
                policy.generate(posture.frames(), begin(posture))
        else:
            assert policy.generate(posture.frames(), begin(posture)).probability >= 0.5


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("transport?abstain=0.5", "valid is judge=FILE"),
        ("transport?judge=", "valid is judge=FILE"),
        ("transport?judge={file}&judge={file}", "valid is judge=FILE"),
        ("transport?judge={file}&abstain=often", "valid is 0 to 1"),
        ("transport?judge={file}&abstain=2", "abstain"),
        ("tp-gmm?judge={file}", "judges 'transport'; valid is a judge of 'tp-gmm'"),
        ("transport?judge={file}&phases=50", "valid is a judge of 'transport?phases=50'"),
        ("transport?judge={file}x", "judge.jsonx"),
    ],
)
def test_a_judge_that_does_not_fit_is_an_error(tmp_path, name, part):
    judge().save(tmp_path / "judge.json")
    with pytest.raises(InvalidInputError) as caught:
        make_policy(name.format(file=tmp_path / "judge.json"))
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_sees_the_posture_cannot_be_judged():
    class Knowing:
        inputs = "posture"

        def fit(self, demonstrations):
            return self

        def generate(self, posture: Posture, start):
            return np.zeros((2, 3))

    with pytest.raises(InvalidInputError, match="inputs are posture"):
        JudgedPolicy(Knowing(), judge())


def test_abstaining_stands_in_the_row_with_its_denominator(tmp_path, monkeypatch):
    """All that is simulated is whether a policy answers; whoever does dresses the arm."""

    def answers(source, posture, *_):
        source.generate(posture.frames(), begin(posture))
        return Recording(Outcome(True), None, None, np.empty((0, 3)))

    monkeypatch.setattr(runner, "record", answers)
    judge().save(tmp_path / "judge.json")
    suite = tmp_path / "suite.json"
    suite.write_text(json.dumps({"postures": [p.to_dict() for p in VALIDATION[:6]]}))
    names = ["transport", f"transport?judge={tmp_path / 'judge.json'}&abstain=0.5"]
    entries = tuple(Entry(name, "case_a") for name in names)
    plan = make_plan(Protocol("p", str(suite), entries))
    work = runner.Work(steady_demonstrate)
    done = run_study(Success(work), plan, Threads(1), tmp_path / "out")
    bends = np.array([Skeleton.of(p.frames()).bend for p in VALIDATION[:6]])
    left = int(np.sum(bends > 0.5))
    assert 0 < left < 6
    whole, part = done.summary["rows"]
    assert "n_abstained" not in whole
    assert (part["n_episodes"], part["n_success"], part["failures"]) == (6, 6 - left, {})
    assert (part["n_abstained"], part["n_attempted"]) == (left, 6 - left)
    assert part["pc_success_attempted"] == 100.0
    table = EpisodeTable.of(done.results)
    assert table.abstained.sum() == left
    assert not table.failed.any()
    assert hardest(table) == []
    told = next(r for r in done.results if r.outcome.abstained is not None)
    assert "estimated probability of success is 0." in told.outcome.abstained
    assert told.outcome.verdict == "abstained"
    assert f"{left}; of {6 - left} attempted 100 %" in markdown(done.document)
