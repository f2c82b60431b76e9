"""Every public function takes what it is meant for and refuses all else by an error of ours."""

import inspect
import subprocess
import sys
from itertools import chain

import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

import dressing_sim
from dressing_sim import learning
from dressing_sim.benchmark.studies import evaluate as evaluate_module
from dressing_sim.envs import dm
from dressing_sim.envs.gym import DressArm
from dressing_sim.envs.task import env_config
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.learning import TPGMM, BoundsSampler, Frame, TimeTPGMM, TrajectoryTPGMM
from dressing_sim.policies.confidence import Judge
from dressing_sim.policies.paper import TPGMMConfig
from dressing_sim.policies.registry import make_policy
from dressing_sim.policies.transported import TransportConfig
from dressing_sim.suites.people import load_person
from dressing_sim.suites.robots import load_robot, with_robot
from dressing_sim.suites.wardrobe import load_garment
from dressing_sim.world.robot import PANDA, Robot, ServoConfig
from dressing_sim.world.scene import SolverConfig
from dressing_sim.world.sleeve import SleeveConfig


class Hostile:
    """An object that raises whatever it is asked."""

    def fails(self, *_arguments):
        raise RuntimeError("hostile")

    __repr__ = __len__ = __iter__ = __float__ = __eq__ = __array__ = fails
    __hash__ = None


WRONG = {
    "None": None,
    "3": 3,
    "-1": -1,
    "x": "x",
    "bytes": b"x",
    "[]": [],
    "{}": {},
    "NaN": float("nan"),
    "1e300": 1e300,
    "1j": 1j,
    "True": True,
    "nan array": np.full((4, 3), np.nan),
    "complex array": np.zeros((4, 3), complex),
    "texts": np.array(["a", "b"]),
    "scalar array": np.array(0.1),
    "object": object(),
    "function": lambda *arguments: None,
    "class": object,
    "10**400": 10**400,
    "hostile": Hostile(),
}

DEMONSTRATIONS = reaching_demonstrations(2)
FRAMES = DEMONSTRATIONS[0].frames
LINE = np.linspace([0.3, 0.0, 0.5], [0.5, -0.2, 0.4], 10)
RNG = np.random.default_rng(0)
MODEL = TPGMM(2).fit(DEMONSTRATIONS)
TRAJECTORY = TrajectoryTPGMM(2, samples=30).fit(DEMONSTRATIONS)
TIMED = TimeTPGMM(2).fit(DEMONSTRATIONS)
CLOCK = learning.Clock.of(DEMONSTRATIONS, learning.Alignment())
FUSED = MODEL.in_situation(FRAMES).marginal(3)
BOUNDS = BoundsSampler.around(DEMONSTRATIONS)

#: Out of the robot's reach: nothing is simulated after the cloth has settled.
FAR = dressing_sim.Posture("far", -60, 0, 0, 0)

#: Valid arguments; one after the other is replaced by a wrong one.
VALID = {
    "Demonstration": {
        "positions": LINE,
        "dt": 0.1,
        "posture": FAR,
        "seed": 0,
        "commands": np.zeros((10, 7)),
    },
    "Dressing": {"posture": FAR},
    "EpisodeConfig": {},
    "Operator": {},
    "Path": {"positions": LINE},
    "Posture": {
        "name": "a",
        "flexion_deg": 60,
        "abduction_deg": 10,
        "rotation_deg": 10,
        "elbow_deg": 10,
    },
    "demonstrate": {"posture": FAR, "seed": 0},
    "dress": {"path_or_policy": LINE, "posture": FAR},
    "evaluate": {},
    "load_demonstrations": {"path": "none.h5"},
    "load_suite": {"name_or_file": "paper5"},
    "record": {"source": LINE, "posture": FAR},
    "sample_postures": {"n": 1, "rng": RNG},
    "save_demonstrations": {"path": "some.h5", "demonstrations": []},
    "TPGMM": {"n_components": 2},
    "Alignment": {},
    "AugmentOptions": {},
    "BoundsSampler": {"bounds": BOUNDS.bounds},
    "EMOptions": {},
    "Frame": {"A": np.eye(3), "b": np.zeros(3)},
    "FrameBounds": {
        "base": np.eye(3),
        "angles": (np.zeros(3), np.ones(3)),
        "translation": (np.zeros(3), np.ones(3)),
    },
    "SyntheticDemonstration": {"positions": LINE, "dt": 0.1, "frames": FRAMES},
    "TimeTPGMM": {},
    "TrajectoryTPGMM": {},
    "add_white_noise": {"positions": LINE, "snr_db": 30.0, "rng": RNG},
    "augment": {
        "demonstrations": DEMONSTRATIONS,
        "rng": RNG,
        "policy": TRAJECTORY,
        "options": learning.AugmentOptions(max_iterations=1),
    },
    "bic": {"model": MODEL, "demonstrations": DEMONSTRATIONS},
    "choose_by_bic": {"model": MODEL, "demonstrations": DEMONSTRATIONS, "candidates": [1]},
    "choose_by_dirichlet_process": {"model": MODEL, "demonstrations": DEMONSTRATIONS},
    "dtw": {"x": LINE, "y": LINE},
    "dtw_cost": {"reproductions": [LINE], "demonstrated": [LINE]},
    "dtw_distance": {"x": LINE, "y": LINE},
    "euler_angles": {"matrix": np.eye(3)},
    "load_model": {"path": "none.npz"},
    "n_parameters": {"n_components": 1, "n_frames": 1, "n_dims": 1},
    "noise_deviation": {"positions": LINE, "snr_db": 30.0, "reference": "world"},
    "remarks": {"demonstrations": DEMONSTRATIONS},
    "rms_cost": {"reproductions": [LINE], "demonstrated": [LINE]},
    "rotation": {"angles": 1.0},
    "save_model": {"model": MODEL, "path": "some.npz"},
}

#: Methods of what these make.
METHODS = {
    "TPGMM.fit": (MODEL.fit, {"demonstrations": DEMONSTRATIONS, "weights": [1.0, 2.0]}),
    "TPGMM.samples": (MODEL.samples, {"demonstrations": DEMONSTRATIONS}),
    "TPGMM.log_likelihood": (MODEL.log_likelihood, {"demonstrations": DEMONSTRATIONS}),
    "TPGMM.regression": (MODEL.regression, {"frames": FRAMES}),
    "TPGMM.in_situation": (MODEL.in_situation, {"frames": FRAMES}),
    "TrajectoryTPGMM.fit": (TRAJECTORY.fit, {"demonstrations": DEMONSTRATIONS}),
    "TrajectoryTPGMM.refit": (TRAJECTORY.refit, {"demonstrations": DEMONSTRATIONS}),
    "TrajectoryTPGMM.generate": (TRAJECTORY.generate, {"frames": FRAMES, "start": np.zeros(3)}),
    "TrajectoryTPGMM.synthesise": (TRAJECTORY.synthesise, {"frames": FRAMES}),
    "TrajectoryTPGMM.cost": (TRAJECTORY.cost, {"demonstrations": DEMONSTRATIONS}),
    "TrajectoryTPGMM.motion": (TRAJECTORY.motion, {"frames": FRAMES, "start": np.zeros(3)}),
    "TrajectoryTPGMM.log_density": (TRAJECTORY.log_density, {"frames": FRAMES, "points": LINE}),
    "TrajectoryTPGMM.sample": (
        TRAJECTORY.sample,
        {"frames": FRAMES, "start": np.zeros(3), "rng": RNG},
    ),
    "TimeTPGMM.fit": (TIMED.fit, {"demonstrations": DEMONSTRATIONS}),
    "TimeTPGMM.generate": (TIMED.generate, {"frames": FRAMES}),
    "TimeTPGMM.follow": (TIMED.follow, {"situations": [FRAMES, FRAMES]}),
    "TimeTPGMM.at_times": (TIMED.at_times, {"frames": FRAMES, "times": np.arange(3.0)}),
    "TimeTPGMM.motion": (TIMED.motion, {"frames": FRAMES}),
    "TimeTPGMM.log_density": (
        TIMED.log_density,
        {"frames": FRAMES, "times": np.arange(10.0), "points": LINE},
    ),
    "TimeTPGMM.sample": (TIMED.sample, {"frames": FRAMES, "rng": RNG}),
    "TimeTPGMM.cost": (TIMED.cost, {"demonstrations": DEMONSTRATIONS}),
    "Frame.to_world": (FRAMES[0].to_world, {"points": LINE}),
    "Frame.to_local": (FRAMES[0].to_local, {"points": LINE}),
    "BoundsSampler.around": (BoundsSampler.around, {"demonstrations": DEMONSTRATIONS}),
    "BoundsSampler.sample": (BOUNDS.sample, {"rng": RNG}),
    "FrameBounds.fixed": (learning.FrameBounds.fixed, {"frame": FRAMES[0]}),
    "Clock.of": (
        learning.Clock.of,
        {"demonstrations": DEMONSTRATIONS, "alignment": learning.Alignment()},
    ),
    "Clock.align": (CLOCK.align, {"demonstrations": DEMONSTRATIONS}),
    "GaussianMixture.log_density": (FUSED.log_density, {"points": LINE}),
    "GaussianMixture.deviations": (FUSED.deviations, {"points": LINE}),
    "GaussianMixture.marginal": (FUSED.marginal, {"n_dims": 1}),
    "GaussianMixture.sample": (FUSED.sample, {"count": 1, "rng": RNG}),
    "Endpoint.of": (learning.Endpoint.of, {"demonstrations": DEMONSTRATIONS, "index": 0}),
    "Endpoint.predict": (TRAJECTORY.end_point.predict, {"frames": FRAMES}),
    "Posture.from_dict": (dressing_sim.Posture.from_dict, {"values": FAR.to_dict()}),
    "Posture.frames": (FAR.frames, {}),
    "Operator.generate": (dressing_sim.Operator().generate, {"posture": FAR, "start": LINE[0]}),
}

#: What documented pages name beside the public names.
DOCUMENTED = {
    "Robot": (Robot, {"joints": PANDA.joints, "home": PANDA.home}),
    "ServoConfig": (ServoConfig, {}),
    "SleeveConfig": (SleeveConfig, {}),
    "SolverConfig": (SolverConfig, {}),
    "Thresholds": (Thresholds, {}),
    "TPGMMConfig": (TPGMMConfig, {}),
    "TransportConfig": (TransportConfig, {}),
    "Judge.from_dict": (Judge.from_dict, {"values": {}}),
    "Judge.load": (Judge.load, {"path": "none.json"}),
    "dm.load": (dm.load, {"posture": FAR, "seed": 0}),
    "DressArm": (DressArm, {"posture": FAR}),
    "env_config": (env_config, {"choices": {}}),
    "load_garment": (load_garment, {"name_or_file": "tshirt-m"}),
    "load_person": (load_person, {"name_or_file": "male"}),
    "load_robot": (load_robot, {"name_or_file": "panda"}),
    "make_policy": (make_policy, {"name": "tp-gmm"}),
    "with_robot": (with_robot, {"config": EpisodeConfig(), "name_or_file": "panda"}),
}

#: Public names that are no functions of a user: protocols, types, and results that others make.
NONE = {
    *("DemonstrationLike", "Inputs", "Policy", "SituationSampler", "TimedPath"),
    *("FUSION_ORDERS", "FusionOrder", "METHODS", "Method", "__version__"),
    *("Augmentation", "Candidate", "EMRecord", "Endpoint", "Mixture", "Outcome", "Situation"),
    *("Clock", "GaussianMixture", "Motion", "Remark", "Warping"),
}


def public(name):
    return getattr(dressing_sim if name in dressing_sim.__all__ else learning, name)


CALLS = {**{name: (name, valid) for name, valid in VALID.items()}, **METHODS, **DOCUMENTED}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A folder of one's own, in which nothing is evaluated."""
    monkeypatch.chdir(tmp_path)

    def begun(*_arguments, **_settings):
        raise DressingSimError("it would run")

    monkeypatch.setattr(evaluate_module, "run_study", begun)


def test_no_public_name_is_forgotten():
    names = set(chain(dressing_sim.__all__, learning.__all__))
    assert names == set(VALID) | NONE


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("name", CALLS)
def test_a_wrong_argument_is_refused_or_does_no_harm(name, wrong):
    function, valid = CALLS[name]
    function = public(function) if isinstance(function, str) else function
    kinds = (inspect.Parameter.VAR_POSITIONAL, inspect.Parameter.VAR_KEYWORD)
    parameters = inspect.signature(function).parameters.values()
    for parameter in [one.name for one in parameters if one.kind not in kinds]:
        try:
            function(**{**valid, parameter: WRONG[wrong]})
        except DressingSimError as error:
            assert "\n" not in str(error)  # noqa: PT017


@pytest.mark.parametrize("wrong", WRONG)
def test_all_arguments_wrong_at_once(wrong):
    for name in VALID:
        valid = dict.fromkeys(VALID[name], WRONG[wrong])
        try:
            public(name)(**valid)
        except DressingSimError as error:
            assert "\n" not in str(error)  # noqa: PT017


@pytest.mark.parametrize("wrong", [w for w in WRONG.values() if not isinstance(w, Frame)])
def test_a_situation_is_of_frames(wrong):
    with pytest.raises(InvalidInputError):
        learning.Situation(wrong)
    with pytest.raises(InvalidInputError):
        learning.Situation(shoulder=wrong)


@pytest.mark.parametrize(
    "call",
    [
        lambda name: dressing_sim.dress(LINE, name),
        lambda name: dressing_sim.record(LINE, name),
        lambda name: dressing_sim.demonstrate(name, 0),
    ],
)
def test_a_posture_may_be_given_by_its_name(call):
    with pytest.raises(InvalidInputError, match="unknown posture 'nope'; valid is one of"):
        call("nope")


def test_by_name_and_by_itself_a_posture_is_the_same():
    by_itself = dressing_sim.Posture("-60,0,0,0", -60, 0, 0, 0)
    assert dressing_sim.dress(LINE, "-60,0,0,0") == dressing_sim.dress(LINE, by_itself)


def test_a_script_without_a_guard_is_told_in_a_line(tmp_path):
    script = tmp_path / "script.py"
    script.write_text("import dressing_sim\ndressing_sim.evaluate('expert', suite='case_a')\n")
    run = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, check=False, cwd=tmp_path
    )
    assert run.returncode == 1
    lines = run.stderr.splitlines()
    assert any("put what it does under if __name__ == '__main__':" in line for line in lines)
    assert "under if __name__ == '__main__'" in lines[-1]
    assert "bootstrapping" not in run.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["script.py"]
