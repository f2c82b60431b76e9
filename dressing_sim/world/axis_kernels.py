"""Loops over points and rings about an arm's axis, compiled."""

import numpy as np

from dressing_sim.compiled import compiled


@compiled
def arm_coordinate(points: np.ndarray, joints: np.ndarray, s: np.ndarray) -> None:
    """Arm coordinate (n,) of the points (n, 3), see `ArmAxis.coordinate`."""
    wrist, elbow, shoulder = joints[0], joints[1], joints[2]
    forearm, upper = elbow - wrist, shoulder - elbow
    ff = forearm[0] * forearm[0] + forearm[1] * forearm[1] + forearm[2] * forearm[2]
    uu = upper[0] * upper[0] + upper[1] * upper[1] + upper[2] * upper[2]
    for i in range(len(points)):
        along, beyond = 0.0, 0.0
        for axis in range(3):
            along += (points[i, axis] - wrist[axis]) * forearm[axis]
            beyond += (points[i, axis] - elbow[axis]) * upper[axis]
        s1, s2 = min(along / ff, 1.0), max(beyond / uu, 0.0)
        d1, d2 = 0.0, 0.0
        for axis in range(3):
            d1 += (points[i, axis] - (wrist[axis] + s1 * forearm[axis])) ** 2
            d2 += (points[i, axis] - (elbow[axis] + s2 * upper[axis])) ** 2
        s[i] = s1 if d1 <= d2 else 1.0 + s2


@compiled
def ring_coordinates(rings: np.ndarray, joints: np.ndarray, s: np.ndarray) -> None:
    """Arm coordinate (n,) of the centres of rings (n, n_around, 3), see `arm_coordinate`."""
    centres = np.empty((len(rings), 3))
    for i in range(len(rings)):
        for axis in range(3):
            place = 0.0
            for vertex in range(rings.shape[1]):
                place += rings[i, vertex, axis]
            centres[i, axis] = place / rings.shape[1]
    arm_coordinate(centres, joints, s)


@compiled
def windings(rings: np.ndarray, chain: np.ndarray, counted: np.ndarray) -> None:
    """How often (n,) rings (n, n_around, 3) wind round a chain (m, 3), see `ArmAxis.winding`.

    Between a segment p1 p2 of the chain and one q1 q2 of a ring there are four planes: two through
    a p and the ring's segment, and two through a q and the chain's segment. Neighbours share them.
    """
    n_around, n_chain = rings.shape[1], len(chain)
    at_p, at_q = np.empty((n_chain, 3)), np.empty((2, n_chain - 1, 3))
    for r in range(len(rings)):
        ring, area = rings[r], 0.0
        for k in range(n_chain - 1):
            _normal(ring[0], chain[k], ring[0], chain[k + 1], at_q[0, k])
        for i in range(n_around):
            here, there = ring[i], ring[(i + 1) % n_around]
            now, after = i % 2, (i + 1) % 2
            for k in range(n_chain):
                _normal(here, chain[k], there, chain[k], at_p[k])
            for k in range(n_chain - 1):
                _normal(there, chain[k], there, chain[k + 1], at_q[after, k])
                n1, n2, n3, n4 = at_p[k], at_q[after, k], at_p[k + 1], at_q[now, k]
                angles = _arcsin(n1, n2) - _arcsin(n2, n3) + _arcsin(n3, n4) - _arcsin(n4, n1)
                area += angles * _side(chain[k], chain[k + 1], here, there)
        counted[r] = round(area / (4.0 * np.pi))


@compiled
def _normal(
    a: np.ndarray, a_from: np.ndarray, b: np.ndarray, b_from: np.ndarray, n: np.ndarray
) -> None:
    """Unit vector n (3,) along the cross product of two ways; zero if that is."""
    ax, ay, az = a[0] - a_from[0], a[1] - a_from[1], a[2] - a_from[2]
    bx, by, bz = b[0] - b_from[0], b[1] - b_from[1], b[2] - b_from[2]
    n[0], n[1], n[2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    length = np.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
    for axis in range(3):
        n[axis] /= length if length > 0.0 else 1.0


@compiled
def _arcsin(a: np.ndarray, b: np.ndarray) -> float:
    """Arc sine of the dot product of unit vectors (3,)."""
    return np.arcsin(min(max(a[0] * b[0] + a[1] * b[1] + a[2] * b[2], -1.0), 1.0))


@compiled
def _side(p1: np.ndarray, p2: np.ndarray, q1: np.ndarray, q2: np.ndarray) -> float:
    """On which side of the segment p1 p2 a segment q1 q2 passes: 1, -1, or 0 if they meet."""
    ax, ay, az = p2[0] - p1[0], p2[1] - p1[1], p2[2] - p1[2]
    bx, by, bz = q2[0] - q1[0], q2[1] - q1[1], q2[2] - q1[2]
    volume = (
        (ay * bz - az * by) * (q1[0] - p1[0])
        + (az * bx - ax * bz) * (q1[1] - p1[1])
        + (ax * by - ay * bx) * (q1[2] - p1[2])
    )
    return np.sign(volume)
