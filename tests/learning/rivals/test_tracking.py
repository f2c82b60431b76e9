import numpy as np

from dressing_sim.learning.rivals.tracking import track


def batch(references, precisions, effort, start):
    """The same problem as one system of linear equations."""
    count, size = references.shape
    p, step = size // 2, 1.0 / (count - 1)
    forward = np.eye(size)
    forward[:p, p:] = step * np.eye(p)
    push = np.concatenate([0.5 * step**2 * np.eye(p), step * np.eye(p)])
    free = np.zeros((count, size))
    free[0, :p] = start
    effect = np.zeros((count, size, count - 1, p))
    for row in range(1, count):
        free[row] = forward @ free[row - 1]
        effect[row] = np.einsum("ij,jnk->ink", forward, effect[row - 1])
        effect[row, :, row - 1] = push
    flat = effect.reshape(count * size, -1)
    weights = np.zeros((count, size, count, size))
    weights[np.arange(count), :, np.arange(count)] = precisions
    weights = weights.reshape(count * size, -1)
    left = flat.T @ weights @ flat + effort * np.eye(flat.shape[1])
    forces = np.linalg.solve(left, flat.T @ weights @ (references - free).ravel())
    return free + (flat @ forces).reshape(count, size)


def test_it_is_the_least_of_all_the_same_cost_solved_at_once(rng):
    references = rng.standard_normal((25, 4))
    roots = rng.standard_normal((25, 4, 4))
    precisions = roots @ roots.transpose(0, 2, 1) + 0.1 * np.eye(4)
    start = np.array([0.5, -1.0])
    found = track(references, precisions, 0.01, start)
    np.testing.assert_allclose(found, batch(references, precisions, 0.01, start), atol=1e-6)


def test_dear_forces_leave_it_where_it_is_and_cheap_ones_follow():
    phase = np.linspace(0.0, 1.0, 50)
    references = np.column_stack([phase**2, 2.0 * phase])
    precisions = np.tile(np.diag([1.0, 1e-6]), (50, 1, 1))
    np.testing.assert_allclose(track(references, precisions, 1e12, np.zeros(1))[:, 0], 0, atol=1e-6)
    followed = track(references, precisions, 1e-12, np.zeros(1))
    np.testing.assert_allclose(followed[:, 0], phase**2, atol=1e-3)
