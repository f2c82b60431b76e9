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
def sensed(
    flex: np.ndarray,
    geom: np.ndarray,
    distance: np.ndarray,
    dim: np.ndarray,
    address: np.ndarray,
    frame: np.ndarray,
    force: np.ndarray,
    link_of_geom: np.ndarray,
    grip: tuple[int, int],
    share: float,
    load: np.ndarray,
    net: np.ndarray,
    normal: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, int]:
    """What force sensors read after a step, from what they read before it.

    Args:
        flex: As all up to ``link_of_geom`` of `cloth_on_links`.
        grip: First row of the grip's constraints, and the one behind their last.
        share: How much of a change a sensor sees in a step, 0 to 1.
        load: Of the gripper before, (3,) [N].
        net: As in `cloth_on_links`, as the sensors read it before.
        normal: The like.

    Returns:
        The same of ``load``, ``net`` and ``normal`` now, and what `cloth_on_links` returns.
    """
    net_now, normal_now = np.empty_like(net), np.empty_like(normal)
    depth, others = cloth_on_links(
        flex, geom, distance, dim, address, frame, force, link_of_geom, net_now, normal_now
    )
    # A grip's force is that on the hand; the cloth feels the opposite.
    pull = np.zeros(3)
    for row in range(grip[0], grip[1]):
        pull[(row - grip[0]) % 3] -= force[row]
    for axis in range(3):
        pull[axis] = load[axis] + share * (pull[axis] - load[axis])
    for link in range(len(normal)):
        normal_now[link] = normal[link] + share * (normal_now[link] - normal[link])
        for axis in range(3):
            before = net[link, axis]
            net_now[link, axis] = before + share * (net_now[link, axis] - before)
    return pull, net_now, normal_now, depth, others


@compiled
def servo_torques(
    command: np.ndarray,
    position: np.ndarray,
    velocity: np.ndarray,
    explicit: np.ndarray,
    gravity: np.ndarray,
    stiffness: np.ndarray,
    damping: np.ndarray,
    effort: np.ndarray,
) -> np.ndarray:
    """Torques (n,) of servos [N m], all arguments (n,), see `World.arm_torque`."""
    torque = np.empty_like(position)
    for i in range(len(position)):
        servo = explicit[i]
        if abs(explicit[i]) < effort[i]:
            servo = stiffness[i] * (command[i] - position[i]) - damping[i] * velocity[i]
        torque[i] = servo + gravity[i]
    return torque


@compiled
def near_limits(
    position: np.ndarray,
    velocity: np.ndarray,
    torque: np.ndarray,
    middle: np.ndarray,
    limits: np.ndarray,
    ratio: np.ndarray,
) -> None:
    """Raise ratios (3,) to how near joints (n,) are to any of their limits.

    Args:
        position: Positions (n,) [rad].
        velocity: Their speeds (n,) [rad/s].
        torque: Torques (n,) [N m].
        middle: Middle of the range of positions, (n,) [rad].
        limits: Of positions, from there, of speeds and of torques, (3, n).
        ratio: Of the three, 1 at the limit, which is written.
    """
    for i in range(len(position)):
        ratio[0] = max(ratio[0], abs(position[i] - middle[i]) / limits[0, i])
        ratio[1] = max(ratio[1], abs(velocity[i]) / limits[1, i])
        ratio[2] = max(ratio[2], abs(torque[i]) / limits[2, i])


@compiled
def longest(vectors: np.ndarray) -> float:
    """The largest length of vectors (n, 3)."""
    most = 0.0
    for i in range(len(vectors)):
        square = vectors[i, 0] ** 2 + vectors[i, 1] ** 2 + vectors[i, 2] ** 2
        most = max(most, square)
    return np.sqrt(most)


@compiled
def fastest(velocities: np.ndarray) -> float:
    """The largest speed of velocities (3 n,), three numbers each."""
    most = 0.0
    for i in range(0, len(velocities), 3):
        square = velocities[i] ** 2 + velocities[i + 1] ** 2 + velocities[i + 2] ** 2
        most = max(most, square)
    return np.sqrt(most)


@compiled
def is_sound(
    warnings: np.ndarray,
    positions: np.ndarray,
    velocities: np.ndarray,
    doubts: np.ndarray,
    longest: float,
) -> bool:
    """Whether there is no warning, no doubt longer than so, and every number is finite."""
    sound = True
    for number in warnings:
        sound = sound and number == 0
    for time in doubts:
        sound = sound and not time > longest
    for value in positions:
        sound = sound and np.isfinite(value)
    for value in velocities:
        sound = sound and np.isfinite(value)
    return sound


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
def edge_strain(
    vertices: np.ndarray, edges: np.ndarray, rest: np.ndarray, strain: np.ndarray
) -> None:
    """Strain (n_edges,) of edges (n_edges, 2) of places (n_vertices, 3), of lengths at rest."""
    for e in range(len(edges)):
        square = 0.0
        for axis in range(3):
            square += (vertices[edges[e, 1], axis] - vertices[edges[e, 0], axis]) ** 2
        strain[e] = np.sqrt(square) / rest[e] - 1.0


@compiled
def percentile(values: np.ndarray, weights: np.ndarray, percent: float) -> float:
    """The value of (n,) that `percent` per cent of the weight (n,) stays at or below."""
    order = np.argsort(values)
    total = 0.0
    for i in order:
        total += weights[i]
    covered, wanted = 0.0, percent / 100.0 * total
    for i in order:
        covered += weights[i]
        if covered >= wanted:
            return values[i]
    return values[order[-1]]
