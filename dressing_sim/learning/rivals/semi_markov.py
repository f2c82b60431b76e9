"""A task-parameterized hidden semi-Markov model, generated and tracked by optimal control.

States k = 1..K follow each other; each has a Gaussian over [y, v] in every frame and a Gaussian
duration. It is learned as a hidden Markov model from left to right (Rabiner 1989), whose emission
is the product over frames; durations are the time that demonstrations spend in a state. In a new
situation states are products of the frames' Gaussians, the most likely state at each phase gives a
stepwise reference, and `tracking` follows it with precision Q = S^-1.

Source: Pignat and Calinon (2017), "Learning adaptive dressing assistance from human demonstration",
Robotics and Autonomous Systems 93, doi:10.1016/j.robot.2017.03.017.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.special import logsumexp, ndtr

from dressing_sim.learning.em import Mixture, covariance_floor, initialise_by_time
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.gmr import lift, product, to_world
from dressing_sim.learning.rivals.method import Method, Shown, Skill
from dressing_sim.learning.rivals.tracking import track


@dataclass(frozen=True, slots=True)
class SemiMarkov(Method):
    """TP-HSMM with LQR tracking, see the module."""

    may_be_zero: ClassVar[frozenset[str]] = frozenset({"steps"})

    states: int = 8
    """K."""
    floor: float = 1e-3
    """Added to variances of positions and of velocities, as a fraction of the data's."""
    effort: float = 1e-4
    """R, over the scale squared: how dear a force is against a standard deviation missed."""
    steps: int = 20
    """Of expectation-maximisation."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The states and their durations."""
        model = _Chain.of(shown, self.states, self.floor, self.steps)
        sequence = model.sequence(self.samples)
        p, effort = shown.points.shape[2], self.effort / shown.scale**2

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            bases, origins = lift(frames, n_time=0, n_copies=2)
            fused = product(to_world(model.states, bases, origins))
            precisions = np.linalg.inv(fused.covariances[0])
            states = track(fused.means[0][sequence], precisions[sequence], effort, start)
            return states[:, :p]

        return skill


@dataclass(frozen=True, eq=False)
class _Chain:
    """States in their order, and how long each lasts: mean and variance (K,), in phase."""

    states: Mixture
    durations: FloatArray
    variances: FloatArray

    @classmethod
    def of(cls, shown: Shown, count: int, floor: float, steps: int) -> _Chain:
        """Learned by `steps` of Baum and Welch's algorithm, from equal bins of time."""
        data = _observations(shown)  # (P, D, M, N)
        n_frames, size, m, n = data.shape
        flat = data.reshape(n_frames, size, m * n)
        floors = covariance_floor(flat, (size // 2, size // 2), (floor, floor), True)
        states = initialise_by_time(flat, [n] * m, count, floors)
        stay = np.full(count, 1.0 - count / n)
        occupied = _occupation(data, states, stay)
        for _ in range(steps):
            states = _moments(flat, occupied.transpose(1, 0, 2).reshape(count, -1), floors)
            dwell = occupied.sum(axis=2).mean(axis=0)
            stay = np.clip(1.0 - 1.0 / np.maximum(dwell, 1.0), 0.01, 1.0 - 1e-6)
            occupied = _occupation(data, states, stay)
        dwell = occupied.sum(axis=2) / n
        return cls(states, dwell.mean(axis=0), dwell.var(axis=0) + 0.25 / n**2)

    def sequence(self, samples: int) -> FloatArray:
        """The most likely state at each phase: P(k) = P(k begun by then) - P(k ended by then)."""
        ends, spread = np.cumsum(self.durations), np.sqrt(np.cumsum(self.variances))
        phase = np.linspace(0.0, 1.0, samples)[:, None]
        ended = ndtr((phase - ends[:-1]) / spread[:-1])  # the last state does not end
        begun = np.concatenate([np.ones((samples, 1)), ended], axis=1)
        return np.argmax(begun - np.concatenate([ended, np.zeros((samples, 1))], axis=1), axis=1)


def _observations(shown: Shown) -> FloatArray:
    """Positions and velocities over phase in each frame, (P, 2p, M, N)."""
    local = shown.local
    velocities = np.gradient(local, shown.phase, axis=2)
    return np.concatenate([local, velocities], axis=3).transpose(1, 3, 0, 2)


def _moments(data: FloatArray, weights: FloatArray, floors: FloatArray) -> Mixture:
    """Means and covariances of samples (P, D, S) with shares (K, S) of them."""
    mass = np.maximum(weights.sum(axis=1), 1e-9)
    means = np.einsum("ks,pds->kpd", weights, data) / mass[:, None, None]
    centred = data[None] - means[..., None]
    covariances = np.einsum("ks,kpds,kpes->kpde", weights, centred, centred, optimize=True)
    return Mixture(mass / mass.sum(), means, covariances / mass[:, None, None, None] + floors)


def _occupation(data: FloatArray, states: Mixture, stay: FloatArray) -> FloatArray:
    """P(state k at row n | demonstration m), (M, K, N), forwards and backwards."""
    log = _log_densities(data, states)  # (N, M, K)
    count, _, k = log.shape
    transition = np.full((k, k), -np.inf)
    transition[np.arange(k), np.arange(k)] = np.log(stay)
    transition[np.arange(k - 1), np.arange(1, k)] = np.log1p(-stay[:-1])
    transition[-1, -1] = 0.0
    ahead, behind = np.empty_like(log), np.zeros_like(log)
    ahead[0] = np.where(np.arange(k) == 0, log[0], -np.inf)
    for row in range(1, count):
        ahead[row] = log[row] + logsumexp(ahead[row - 1][:, :, None] + transition, axis=1)
    behind[-1] = np.where(np.arange(k) == k - 1, 0.0, -np.inf)
    for row in range(count - 2, -1, -1):
        behind[row] = logsumexp(transition + (log[row + 1] + behind[row + 1])[:, None], axis=2)
    both = ahead + behind
    return np.exp(both - logsumexp(both, axis=2, keepdims=True)).transpose(1, 2, 0)


def _log_densities(data: FloatArray, states: Mixture) -> FloatArray:
    """log prod_p N(x_p | k), (N, M, K)."""
    precisions = np.linalg.inv(states.covariances)
    _, log = np.linalg.slogdet(2.0 * np.pi * states.covariances)
    centred = data[None] - states.means[..., None, None]
    squares = np.einsum("kpdmn,kpde,kpemn->kmn", centred, precisions, centred, optimize=True)
    return -0.5 * (squares + log.sum(axis=1)[:, None, None]).transpose(2, 1, 0)
