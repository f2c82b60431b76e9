"""How fast the learning library is, next to its peers in the same run, on one thread.

    pytest benchmarks/test_learning_speed.py -s -n 0 --benchmark-columns=median,iqr,rounds

Ours and the peer's calls alternate, so that a busy machine slows both; only the ratios mean
anything elsewhere. Compilation is not counted: it is cached on disk after the first call.
"""

import statistics
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.learning import (
    AugmentOptions,
    TimeTPGMM,
    TrajectoryTPGMM,
    augment,
    dtw,
    dtw_distance,
)
from dressing_sim.learning.em import EMOptions, Mixture, fit_mixture, initialise_by_time
from dressing_sim.learning.frame import Frame
from dressing_sim.learning.sampling import rotation
from dressing_sim.planar.generator import generate
from dressing_sim.planar.study import OPTIONS, situation_sampler


def seconds(call):
    begin = time.perf_counter()
    call()
    return time.perf_counter() - begin


def alternate(ours, peer, rounds):
    """Median times of two calls, taken in turns."""
    ours()
    peer()
    pairs = [(seconds(ours), seconds(peer)) for _ in range(rounds)]
    return tuple(statistics.median(times) for times in zip(*pairs, strict=True))


def smooth_samples(n_samples, n_dims, seed=0):
    """Samples along a noisy curve, (n_samples, n_dims)."""
    rng = np.random.default_rng(seed)
    waves = np.linspace(0, 1, n_samples)[:, None] * np.arange(1, 7) * np.pi
    curve = np.concatenate([np.sin(waves), np.cos(waves)], axis=1)
    return curve @ rng.standard_normal((12, n_dims)) + 0.1 * rng.standard_normal(
        (n_samples, n_dims)
    )


def em_per_step(data, n_components, few=10, many=110):
    """Our time for one EM step on (P, D, N) samples: the slope over the number of steps."""
    floor = np.tile(1e-4 * np.eye(data.shape[1]), (len(data), 1, 1))
    start = initialise_by_time(data, [data.shape[2]], n_components, floor)

    def fit(steps):
        # A tolerance below any change, so that all steps are taken.
        return fit_mixture(data, start, floor, EMOptions(steps, steps, 0.0))

    return (lambda: fit(few)), (lambda: fit(many)), many - few


def sklearn_per_step(samples, n_components, few=10, many=110):
    mixture = pytest.importorskip("sklearn.mixture").GaussianMixture
    import warnings

    groups = np.array_split(samples, n_components)
    means = np.array([group.mean(axis=0) for group in groups])

    def fit(steps):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return mixture(
                n_components,
                means_init=means,
                init_params="random_from_data",
                max_iter=steps,
                tol=0.0,
                reg_covar=1e-4,
                random_state=0,
            ).fit(samples)

    assert fit(many).n_iter_ == many
    return (lambda: fit(few)), (lambda: fit(many)), many - few


@pytest.mark.parametrize(
    ("n_samples", "n_frames", "n_dims", "n_components", "least"),
    [
        pytest.param(400, 2, 6, 4, 8.0, id="dressing, 400 x 12, K 4"),
        pytest.param(600, 2, 3, 8, 8.0, id="planar, 600 x 6, K 8"),
        pytest.param(400, 1, 12, 4, 4.0, id="one frame, 400 x 12, K 4 (the very same model)"),
    ],
)
def test_em_step_against_scikit_learn(benchmark, n_samples, n_frames, n_dims, n_components, least):
    """One EM step on the same numbers; scikit-learn sees all frames' coordinates in one vector."""
    samples = smooth_samples(n_samples, n_frames * n_dims)
    data = np.ascontiguousarray(samples.T.reshape(n_frames, n_dims, n_samples))
    few, many, steps = em_per_step(data, n_components)
    peer_few, peer_many, peer_steps = sklearn_per_step(samples, n_components)
    short = alternate(few, peer_few, 15)
    long = alternate(many, peer_many, 15)
    ours = (long[0] - short[0]) / steps
    peer = (long[1] - short[1]) / peer_steps
    benchmark.extra_info["ratio"] = peer / ours
    print(f"\nEM step: ours {1e6 * ours:.0f} us, scikit-learn {1e6 * peer:.0f} us, "
          f"{peer / ours:.1f} x")  # fmt: skip
    benchmark(many)
    assert peer / ours >= least


@pytest.mark.parametrize("with_path", [False, True], ids=["distance", "distance and path"])
def test_dtw_against_dtaidistance(benchmark, with_path):
    """Two 200 x 3 paths; the peer is C, with another step pattern, and gives the distance only."""
    peer_module = pytest.importorskip("dtaidistance.dtw_ndim")
    x, y = smooth_samples(200, 3), smooth_samples(200, 3, seed=1)
    call = dtw if with_path else dtw_distance
    peer_call = peer_module.distance_fast
    ours, peer = alternate(lambda: call(x, y), lambda: peer_call(x, y), 200)
    benchmark.extra_info["ratio"] = peer / ours
    print(f"\nDTW: ours {1e6 * ours:.0f} us, dtaidistance {1e6 * peer:.0f} us, {peer / ours:.1f} x")
    benchmark(call, x, y)
    assert peer / ours > 1.0


@pytest.mark.parametrize("method", ["noise", "rf", "rf+noise"])
def test_a_planar_run_of_algorithm_1(benchmark, method):
    """M 8, L 50, K 8, three demonstrations of 200 samples: under half a second."""
    data = generate(1)
    sampler = situation_sampler(data, "paper")

    def run(seed):
        return augment(
            data.training,
            rng=np.random.default_rng(seed),
            options=replace(OPTIONS, method=method),
            policy=TimeTPGMM(8),
            sampler=sampler,
        )

    run(0)
    times = [seconds(lambda seed=seed: run(seed)) for seed in range(5)]
    print(f"\nplanar, {method}: {statistics.median(times):.3f} s")
    benchmark.pedantic(run, args=(0,), rounds=3)
    assert statistics.median(times) < 0.5


def dressing_like(count, seed=0):
    """Paths of 200 samples along a bent line between two frames, as over an arm."""
    from dressing_sim.learning import SyntheticDemonstration

    rng = np.random.default_rng(seed)
    demonstrations = []
    for _ in range(count):
        joints = np.array([[0.0, 0, 0], [0.28, 0, 0], [0.45, 0.2, 0]])
        joints += 0.05 * rng.standard_normal((3, 3))
        frames = tuple(Frame(rotation(0.3 * rng.standard_normal(3)), joints[i]) for i in (0, 2))
        phase = np.linspace(0, 1, 200)
        knots = [0.0, 0.5, 1.0]
        over = joints[::-1] + [0, 0, 0.09] + 0.01 * rng.standard_normal((3, 3))
        smooth = phase**2 * (3 - 2 * phase)
        path = np.stack([np.interp(smooth, knots, over[:, i]) for i in range(3)], axis=1)
        demonstrations.append(SyntheticDemonstration(path, 0.05, frames))
    return demonstrations


@pytest.mark.parametrize("method", ["noise", "rf", "rf+noise"])
def test_a_dressing_run_of_algorithm_1(benchmark, method):
    """M 7, L 100, K 4, two demonstrations of 200 samples: under a second (20 s in the paper)."""
    demonstrations = dressing_like(2)

    def run(seed):
        return augment(
            demonstrations, rng=np.random.default_rng(seed), options=AugmentOptions(method)
        )

    run(0)
    times = [seconds(lambda seed=seed: run(seed)) for seed in range(5)]
    print(f"\ndressing, {method}: {statistics.median(times):.3f} s")
    benchmark.pedantic(run, args=(0,), rounds=3)
    assert statistics.median(times) < 1.0


@pytest.mark.parametrize("fusion", ["regression-then-product", "product-then-regression"])
@pytest.mark.parametrize("kind", ["trajectory", "time"])
def test_a_path_for_a_new_situation(benchmark, kind, fusion):
    """Under a millisecond."""
    demonstrations = dressing_like(3)
    type_ = {"trajectory": TrajectoryTPGMM, "time": TimeTPGMM}[kind]
    policy = type_(4, fusion=fusion).fit(demonstrations)
    frames = dressing_like(1, seed=9)[0].frames
    start = demonstrations[0].positions[0]
    path = benchmark(policy.generate, frames, start)
    print(f"\n{kind}, {fusion}: {1e3 * benchmark.stats.stats.median:.3f} ms, {len(path)} samples")
    assert benchmark.stats.stats.median < 1e-3


def test_the_import(benchmark):
    """Under half a second, interpreter included."""
    command = [sys.executable, "-c", "import dressing_sim.learning"]

    def load():
        subprocess.run(command, check=True)

    load()
    times = [seconds(load) for _ in range(5)]
    print(f"\nimport: {statistics.median(times):.2f} s")
    benchmark.pedantic(load, rounds=3)
    assert statistics.median(times) < 0.5


def test_the_peers_agree_on_the_model():
    """What is compared is the same computation: one frame, the same steps, the same likelihood."""
    sklearn_mixture = pytest.importorskip("sklearn.mixture")
    samples = smooth_samples(400, 4)
    floor = 1e-6 * np.eye(4)[None]
    start = initialise_by_time(samples.T[None], [400], 3, floor)
    peer = sklearn_mixture.GaussianMixture(
        3,
        weights_init=start.priors,
        means_init=start.means[:, 0],
        precisions_init=np.linalg.inv(start.covariances[:, 0]),
        max_iter=500,
        tol=1e-12,
        reg_covar=1e-6,
    ).fit(samples)
    ours, _ = fit_mixture(samples.T[None], start, floor, EMOptions(5, 500, 1e-12))
    assert isinstance(ours, Mixture)
    np.testing.assert_allclose(ours.means[:, 0], peer.means_, atol=1e-4)
