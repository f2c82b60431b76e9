"""Compiled loops give the bits of the array operations that they stand for."""

import numpy as np
import pytest

from dressing_sim.world.kernels import edge_strain, longest, near_limits, percentile, servo_torques


@pytest.mark.parametrize("percent", [1.0, 50.0, 95.0, 100.0])
def test_a_percentile_is_that_of_the_sorted_weights(percent):
    rng = np.random.default_rng(5)
    for n in (1, 2, 17, 300):
        values, weights = rng.random(n), rng.choice([0.3, 0.7, 1.1], n)
        order = np.argsort(values)
        covered = np.cumsum(weights[order])
        index = np.searchsorted(covered, percent / 100.0 * covered[-1])
        assert percentile(values, weights, percent) == values[order[min(index, n - 1)]]


def test_lengths_are_numpys_norms():
    rng = np.random.default_rng(6)
    for n in (1, 5, 400):
        vectors = rng.normal(size=(n, 3))
        assert longest(vectors) == np.linalg.norm(vectors, axis=1).max()
        edges, rest = rng.integers(0, n, (n, 2)), rng.uniform(0.5, 1.0, n)
        strain = np.empty(n)
        edge_strain(vectors, edges, rest, strain)
        lengths = np.linalg.norm(vectors[edges[:, 1]] - vectors[edges[:, 0]], axis=1)
        np.testing.assert_array_equal(strain, lengths / rest - 1.0)


def test_torques_and_their_ratios_are_those_of_whole_arrays():
    rng = np.random.default_rng(7)
    for _ in range(20):
        command, q, v, explicit, gravity = rng.normal(size=(5, 7))
        stiffness, damping, effort = rng.uniform(0.5, 2.0, (3, 7))
        implicit = stiffness * (command - q) - damping * v
        expected = np.where(np.abs(explicit) < effort, implicit, explicit) + gravity
        torque = servo_torques(command, q, v, explicit, gravity, stiffness, damping, effort)
        np.testing.assert_array_equal(torque, expected)
        middle, limits, ratio = 0.1 * q, rng.uniform(1.0, 2.0, (3, 7)), np.zeros(3)
        near_limits(q, v, torque, middle, limits, ratio)
        used = np.abs(np.array([q - middle, v, torque]) / limits).max(axis=1)
        np.testing.assert_array_equal(ratio, used)
