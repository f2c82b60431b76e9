import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.episode.dressing import Dressing
from dressing_sim.pictures.cloth import DrawnSleeve
from dressing_sim.pictures.person import SKIN_INSET, left_arm, person
from dressing_sim.pictures.visuals import drawing_spec
from dressing_sim.world.scene import WorldConfig

POSTURES = [
    Posture("straight", 75.0, 20.0, 40.0, 0.0),
    Posture("bent", 66.0, 30.0, 48.0, 140.0, "female_small"),
    Posture("hanging", 0.0, 0.0, 0.0, 20.0, "male_large"),
]


@pytest.mark.parametrize("posture", POSTURES, ids=lambda p: p.name)
def test_the_drawn_arm_is_within_the_simulated_one(posture):
    """Cloth sinks in by millimetres, where skin would give way; the sleeve may not look pierced."""
    arm = left_arm(posture)
    wrist, elbow, shoulder = posture.wrist, posture.elbow, posture.shoulder
    for start, end, radius in (
        (wrist, elbow, posture.arm_size.forearm_radius),
        (elbow, shoulder, posture.arm_size.upper_arm_radius),
    ):
        along = np.linspace(0.15, 0.8, 12)[:, None]
        axis = (end - start) / np.linalg.norm(end - start)
        side = np.cross(axis, [0.3, 0.5, 0.8])
        side /= np.linalg.norm(side)
        for angle in np.linspace(0.0, 2.0 * np.pi, 8):
            way = np.cos(angle) * side + np.sin(angle) * np.cross(axis, side)
            ring = start + along * (end - start) + (radius - 0.4 * SKIN_INSET) * way
            if posture.elbow_deg < 90.0:  # else the other half of the arm is there
                assert (arm(ring) > -1e-3).all()
        assert (arm(start + along * (end - start)) < 0.0).all()


def test_a_person_sits_on_the_floor_whole():
    parts = {part.name: part for part in person(POSTURES[0])}
    assert parts.keys() == {"skin", "skin_hand", "shirt", "trousers", "shoes"}
    for part in parts.values():
        assert np.isfinite(part.vertices).all()
        assert ((part.light >= 0.0) & (part.light <= 1.0)).all()
        np.testing.assert_allclose(np.linalg.norm(part.normals, axis=1), 1.0, atol=1e-6)
        assert part.faces.max() < len(part.vertices)
    floor = POSTURES[0].shoulder_position[2] - 1.0
    assert parts["shoes"].vertices[:, 2].min() == pytest.approx(floor, abs=0.02)


def test_no_skin_pokes_through_the_drawn_sleeve(posture):
    """Even where the simulated cloth has sunk into the arm, and nothing else is moved."""
    dressing = Dressing(posture)
    dressing.reset()
    arm = left_arm(posture)
    _, sleeve = drawing_spec(posture, WorldConfig())
    assert isinstance(sleeve, DrawnSleeve)
    cloth = dressing.world.cloth
    onto = 0.5 * (posture.elbow + posture.wrist) - cloth.mean(axis=0)
    for positions in (cloth, cloth + onto):
        points, normals = sleeve.shape(positions)
        assert arm(points).min() > -2.5e-3
        assert np.isfinite(normals).all()
    free = cloth + np.array([0.0, 0.0, 5.0])
    moved = sleeve.shape(free)[0] - sleeve.shape(free + 1.0)[0]
    np.testing.assert_allclose(moved, -1.0, atol=1e-9)
