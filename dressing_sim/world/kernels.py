"""Loops that run in every physics or control step, compiled."""

import numpy as np

from dressing_sim.compiled import compiled


@compiled
def cloth_on_links(
    flex: np.ndarray,
    geom: np.ndarray,
    distance: np.ndarray,
    dim: np.ndarray,
    address: np.ndarray,
    frame: np.ndarray,
    force: np.ndarray,
    link_of_geom: np.ndarray,
    net: np.ndarray,
    normal: np.ndarray,
) -> tuple[float, int]:
    """Add up the cloth's contacts by the mannequin's links.

    Args:
        flex: Of the contacts' two participants, (n, 2); -1 for none.
        geom: The same of geoms.
        distance: Between the contacts' surfaces, (n,), negative inside [m].
        dim: Rows of each contact, (n,).
        address: First of them, (n,); -1 where the solver leaves a contact out.
        frame: Axes of each contact, (n, 9), the normal first.
        force: Of all rows of the solver [N].
        link_of_geom: Index of a geom's link, -1 of others; the last is that of no geom.
        net: Net force on each link, (n_links, 3), which is written.
        normal: Sum of its normal forces, (n_links,), which is written.

    Returns:
        How deep the cloth is in the mannequin where it is deepest, zero if it is not [m], and the
        number of contacts without cloth.
    """
    depth, others = 0.0, 0
    net[:] = 0.0
    normal[:] = 0.0
    for contact in range(len(dim)):
        if flex[contact, 0] < 0 and flex[contact, 1] < 0:
            others += 1
            continue
        first, second = link_of_geom[geom[contact, 0]], link_of_geom[geom[contact, 1]]
        link = max(first, second)
        if link < 0:
            continue
        depth = max(depth, -distance[contact])
        if address[contact] < 0:
            continue
        # The force acts on the second of the two.
        sign = 1.0 if second >= 0 else -1.0
        for row in range(min(3, dim[contact])):
            part = force[address[contact] + row]
            for axis in range(3):
                net[link, axis] += sign * part * frame[contact, 3 * row + axis]
        normal[link] += force[address[contact]]
    return depth, others


@compiled
def fastest(velocities: np.ndarray) -> float:
    """The largest speed of velocities (3 n,), three numbers each."""
    most = 0.0
    for i in range(0, len(velocities), 3):
        square = velocities[i] ** 2 + velocities[i + 1] ** 2 + velocities[i + 2] ** 2
        most = max(most, square)
    return np.sqrt(most)


@compiled
def all_finite(values: np.ndarray) -> bool:
    """Whether every number of (n,) is finite."""
    finite = True
    for value in values:
        finite = finite and np.isfinite(value)
    return finite


@compiled
def principal_strain(
    vertices: np.ndarray, triangles: np.ndarray, inverse: np.ndarray, strain: np.ndarray
) -> None:
    """Largest principal strain (n_triangles,) of triangles of places (n_vertices, 3).

    ``inverse`` (n_triangles, 2, 2) is that of the edges at rest, see `StrainGauge`.
    """
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        c11, c22, c12 = 0.0, 0.0, 0.0
        for axis in range(3):
            first = vertices[b, axis] - vertices[a, axis]
            second = vertices[c, axis] - vertices[a, axis]
            f1 = first * inverse[t, 0, 0] + second * inverse[t, 1, 0]
            f2 = first * inverse[t, 0, 1] + second * inverse[t, 1, 1]
            c11 += f1 * f1
            c22 += f2 * f2
            c12 += f1 * f2
        half = 0.5 * (c11 - c22)
        strain[t] = np.sqrt(0.5 * (c11 + c22) + np.sqrt(half * half + c12 * c12)) - 1.0


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
