"""The simulated cloth against closed forms: strips stretched, bent, and laid on an incline.

"The manual" is that of MuJoCo 4.0.
"""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from cloth_strips import (
    FABRIC,
    GRAVITY,
    HEIGHT,
    SLEEVE,
    SOLVER,
    Strip,
    X,
    Y,
    Z,
    beam_mesh,
    creep,
    shares,
    strip_mesh,
)

# Stretching


def stretched(load, cells, kind, edge=0.040, weightless=False):
    """A strip that hangs along x from its end at x = 0, pulled by a load a width [N/m].

    Returns:
        The strip, and the vertices and shares of width of its free end.
    """
    mesh, _ = beam_mesh(FABRIC, cells, edge, kind)
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    held, end = np.flatnonzero(x < 1e-9), np.flatnonzero(x > x.max() - 1e-9)
    # The edge that is held is free to contract.
    middle = held[np.argmin(np.abs(y[held] - y.mean()))]
    fixed = dict.fromkeys(held.tolist(), "xz") | {int(middle): "xyz"}
    strip = Strip(FABRIC, mesh, fixed, weightless=weightless)
    strip.model.opt.gravity[:] = 0.0 if weightless else GRAVITY * X
    widths = shares(y[end])
    strip.pull(end, np.outer(load * widths, X))
    strip.settle(1.0)
    return strip, end, widths


@pytest.mark.parametrize("load", [0.0, 0.9, 1.8])
@pytest.mark.parametrize("kind", ["squares", "axial", "circumferential"])
@pytest.mark.parametrize(
    ("cells", "edge"), [((6, 2), 0.040), ((12, 4), 0.020), ((6, 2), 0.034), ((12, 4), 0.017)]
)
def test_a_hanging_strip_stretches_as_its_membrane_stiffness_says(cells, edge, kind, load):
    """Uniaxial stress of a St Venant-Kirchhoff membrane (the manual's flex elasticity).

    With K = E t, a tension n per width at rest stretches by l where K l (l^2 - 1) / 2 = n, which
    is a strain of n / K as long as that is small. At s below the top edge n is the end load and
    the weight of what hangs below, ``load + rho g (L - s)``. Up to 1 % of strain here.

    Linear elements with lumped masses are exact in their nodes for a bar under its own weight;
    the 0.01 % are for the mesh's unequal corners (measured: 0.002 % and less).
    """
    strip, end, widths = stretched(load, cells, kind, edge=edge)
    start = strip.mesh.vertices[end, 0]
    length, stiffness = start[0], FABRIC.membrane_stiffness
    s = (np.arange(1000) + 0.5) / 1000 * length
    strain = (load + FABRIC.areal_density * GRAVITY * (length - s)) / stiffness
    stretch = np.ones_like(s)
    for _ in range(20):  # Newton's method
        stretch -= (stretch * (stretch**2 - 1) / 2 - strain) / ((3 * stretch**2 - 1) / 2)
    expected = np.mean(stretch - 1.0) * length
    elongation = widths @ (strip.vertices[end, 0] - start) / widths.sum()
    assert elongation == pytest.approx(expected, rel=1e-4)
    # Small strains: the linear law, its error is 3/2 of the strain.
    assert elongation == pytest.approx(strain.mean() * length, rel=0.02)


@pytest.mark.parametrize("kind", ["squares", "axial", "circumferential"])
def test_a_pulled_strip_gets_narrower_as_poissons_ratio_says(kind):
    """Green strains under uniaxial stress: across = -nu * along. Uniform, so the mesh is exact."""
    strip, end, _ = stretched(1.8, (6, 2), kind, weightless=True)
    rest, now = strip.mesh.vertices, strip.vertices
    along = (now[end, 0] / rest[end, 0]).mean()
    across = np.ptp(now[end, 1]) / np.ptp(rest[end, 1])
    assert along > 1.005
    assert -(across**2 - 1) / (along**2 - 1) == pytest.approx(FABRIC.poisson, rel=1e-3)


# Bending
#
# Strips a hundred times and more as rigid as the fabric, so that they bend little under their
# weight. The solver's iterations are the most for the linear system of a step, too, so tests say
# how many their strips need.


def bulk_bending_energy(curvature, kind, cell=0.01):
    """Bending energy an area, away from edges, of a sheet of a given curvature (2, 2) [1/m].

    The discrete hinges are quadratic in the deflection, so the energy is -f w / 2. Of n x n cells
    it is quadratic in n, and the second difference is that of the area alone.
    """
    energies = []
    for n in (4, 6, 8):
        mesh, step = beam_mesh(FABRIC, (n, n), cell, kind)
        sheet = Strip(FABRIC, mesh, weightless=True, elasticity=1)
        flat = mesh.vertices[:, :2]
        deflection = 0.5 * np.einsum("ni,ij,nj->n", flat, curvature, flat)
        sheet.data.qpos[2::3] = deflection
        mujoco.mj_forward(sheet.model, sheet.data)
        energies.append(-0.5 * sheet.data.qfrc_spring[2::3] @ deflection)
    area = step * cell * (HEIGHT if kind == "circumferential" else 1.0)
    return np.diff(energies, 2)[0] / 8.0 / area


@pytest.mark.parametrize("kind", ["squares", "axial", "circumferential"])
@pytest.mark.parametrize("direction", [X, Y])
def test_a_cylinder_stores_the_energy_of_its_curvature(direction, kind):
    """D kappa^2 / 2 an area, Kirchhoff's plate (the manual's flex elasticity)."""
    energy = bulk_bending_energy(1e-3 * np.outer(direction, direction)[:2, :2], kind)
    assert energy == pytest.approx(FABRIC.bending_stiffness * 1e-6 / 2, rel=1e-6)


def test_equilateral_triangles_bend_like_an_isotropic_plate(rng):
    """D / 2 (tr^2 - 2 (1 - nu) det) of the curvature an area, with nu = -1/3, in every direction.

    Two triangles of side a fold by an angle proportional to k_nn - k_tt / 3, where t is along
    their common edge: their tips are 3 times as far from its middle, squared, as its ends are. The
    mean square over the three directions of edges is proportional to k1^2 + k2^2 - 2/3 k1 k2
    (Seung and Nelson, Phys. Rev. A 38, 1988). Kirchhoff's plate has the fabric's own nu there;
    the sign matters only where cloth curves both ways. Squares with diagonals are not isotropic.
    """
    for _ in range(3):
        curvature = 1e-3 * rng.normal(size=(2, 2))
        curvature += curvature.T
        invariants = np.trace(curvature) ** 2 - 2 * (1 + 1 / 3) * np.linalg.det(curvature)
        energy = bulk_bending_energy(curvature, "axial")
        assert energy == pytest.approx(FABRIC.bending_stiffness / 2 * invariants, rel=1e-6)


def cantilever(cells, edge, rigidity, kind, iterations=SOLVER.iterations):
    """Tip deflection under its own weight, measured over the closed form's.

    Euler-Bernoulli: w = q L^4 / (8 D b) at the tip, with q the weight per length, b the width. Two
    rows are fixed, and a hinge on the second stands for half a cell on either side of it. Of n
    cells, whose hinges each turn by h times M / D b, the sum is that with L^4 = (n (n - 1))^2 h^4.
    """
    fabric = replace(FABRIC, bending_stiffness=rigidity)
    mesh, step = beam_mesh(fabric, cells, edge, kind)
    x = mesh.vertices[:, 0]
    fixed = dict.fromkeys(np.flatnonzero(x < 1.01 * step).tolist(), "xyz")
    strip = Strip(fabric, mesh, fixed, iterations=iterations)
    strip.settle(1.0)
    n = cells[0]
    expected = fabric.areal_density * GRAVITY * (n * (n - 1) * step**2) ** 2 / (8.0 * rigidity)
    assert expected < 0.06 * x.max()  # small deflections
    return -strip.vertices[x > x.max() - 1e-9, 2].mean() / expected


@pytest.mark.parametrize("rigidity", [0.002, 0.004])
@pytest.mark.parametrize(
    ("cells", "edge", "iterations"),
    [((8, 4), 0.01, 50), ((8, 8), 0.01, 50), ((16, 8), 0.005, 500)],
)
def test_a_cantilever_bends_as_its_plate_stiffness_says(cells, edge, iterations, rigidity):
    """Squares, folds across the strip: no coupling of curvatures, so the beam's rigidity is D b.

    2 % for the strip's free edges, whose hinges have cloth on one side only.
    """
    ratio = cantilever(cells, edge, rigidity, "squares", iterations)
    assert ratio == pytest.approx(1.0, rel=0.02)


@pytest.mark.parametrize("kind", ["axial", "circumferential"])
@pytest.mark.parametrize(
    ("cells", "edge", "iterations"),
    [((8, 4), 0.01, 50), ((8, 8), 0.01, 50), ((16, 8), 0.005, 500)],
)
def test_a_cantilever_cut_from_a_sleeve_bends_nearly_so(cells, edge, iterations, kind):
    """Between the cylinder that the clamp forces on it, 1, and the free strip's 9/8 (below).

    Measured, in this order: axial 1.022, 1.013, 1.033, and 1.039 with cells of 2.5 mm;
    circumferential 1.001, 0.985, 1.026, 1.040. Where the clamp is, between the rows, matters by
    (h / L)^2 = 2 % in the coarse ones. Squares with diagonals that cross have 1.2.
    """
    ratio = cantilever(cells, edge, 0.002, kind, iterations)
    assert 0.98 < ratio < 1.05


@pytest.mark.parametrize("kind", ["axial", "circumferential"])
@pytest.mark.parametrize("cells", [(12, 4), (12, 6)])
def test_a_strip_cut_from_a_sleeve_bends_an_eighth_more_easily_between_couples(cells, kind):
    """Four-point bending: curvature M / (D b (1 - nu^2)), with the triangles' nu of -1/3.

    The strip is free to curve across too, by -nu times its curvature along: D b falls by 1 - 1/9.
    Kirchhoff's plate with the fabric's nu has 1.099 here, our triangles 9/8, whatever the
    direction. 2 % for the free edges, 0.05 of the Poisson's ratio.
    """
    edge, rigidity, curvature = 0.040, 0.02, 0.1
    fabric = replace(FABRIC, bending_stiffness=rigidity)
    mesh, step = beam_mesh(fabric, cells, edge, kind)
    x, y = (mesh.vertices - mesh.vertices.mean(axis=0))[:, :2].T
    strip = Strip(fabric, mesh, weightless=True)
    force = curvature * rigidity / step  # a width
    for side in (-1.0, 1.0):
        for way, sign in ((0.0, 1.0), (step, -1.0)):
            line = np.flatnonzero(np.abs(x - side * (x.max() - way)) < 1e-9)
            strip.pull(line, np.outer(sign * force * shares(y[line]), Z))
    strip.settle(1.5)
    inner = np.abs(x) < x.max() - 2.5 * step
    x, y = x[inner], y[inner]
    shape = np.column_stack([np.ones_like(x), x, y, x * y, 0.5 * x**2, 0.5 * y**2])
    along, across = np.linalg.lstsq(shape, strip.vertices[inner, 2], rcond=None)[0][-2:]
    assert along / curvature == pytest.approx(9.0 / 8.0, rel=0.02)
    assert across / along == pytest.approx(1.0 / 3.0, abs=0.05)


# Friction and weight

FRICTION_ANGLE = np.arctan(FABRIC.friction)


def sheet_on(incline, edge=SLEEVE.edge):
    """A sheet of 17 cm on the inclined plane."""
    across, along = round(0.17 / edge), round(0.17 / (edge * HEIGHT))
    size = along * edge * HEIGHT * X, across * edge * Y
    mesh = strip_mesh(FABRIC, *size, (along, across), height=0.5 * FABRIC.thickness)
    return Strip(FABRIC, mesh, incline=incline)


@pytest.mark.parametrize("beyond", [1.0, 3.0, 10.0])
def test_cloth_slides_down_what_is_steeper_than_the_friction_angle(beyond):
    """Coulomb: a = g (sin - mu cos) of the incline; here 1, 3 and 10 degrees beyond atan(mu).

    Friction that slides is at the cone's edge, where it is exact: 0.1 % for the fit to the path.
    """
    incline = FRICTION_ANGLE + np.deg2rad(beyond)
    sheet = sheet_on(incline)
    history = np.array([(t, sheet.centre[0]) for t in sheet.run(1.5) if t > 0.5])
    acceleration = 2.0 * np.polyfit(*history.T, 2)[0]
    expected = GRAVITY * (np.sin(incline) - FABRIC.friction * np.cos(incline))
    assert acceleration == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("edge", [0.040, 0.034, 0.020, 0.017])
@pytest.mark.parametrize("below", [1.0, 3.0, 10.0])
def test_cloth_stays_on_what_is_less_steep_but_for_the_creep_of_soft_friction(below, edge):
    """Below atan(mu) friction carries m g sin of the incline, and nothing accelerates.

    What is left is `creep`, 0.1 mm/s and less, the same in every mesh.
    """
    incline = FRICTION_ANGLE - np.deg2rad(below)
    sheet = sheet_on(incline, edge)
    sheet.settle(0.5)
    history = np.array([(t, sheet.centre[0]) for t in sheet.run(1.0)])
    acceleration, speed = np.polyfit(*history.T, 2)[:2] * [2.0, 1.0]
    assert abs(acceleration) < 1e-6
    down, normal = GRAVITY * np.sin(incline), GRAVITY * np.cos(incline)
    np.testing.assert_allclose(
        sheet.support_force, sheet.mesh.masses.sum() * np.array([down, 0.0, -normal]), atol=1e-7
    )
    assert speed < 1.1e-4
    assert speed == pytest.approx(creep(down, normal), rel=1e-3)


def test_the_sensor_below_a_sheet_at_rest_reads_its_weight():
    """Newton: the support carries m g. Nothing moves, so only the solver's tolerance is left."""
    sheet = sheet_on(0.0)
    sheet.settle(1.0)
    np.testing.assert_allclose(sheet.support_force, [0.0, 0.0, -sheet.weight], atol=1e-7)
