from itertools import product

import mujoco
import numpy as np
import pytest

from dressing_sim.arm import ARM_SIZES, LEFT, Posture
from dressing_sim.world.mannequin import ARM_LINKS, LINKS, add_mannequin
from dressing_sim.world.scene import WorldConfig, build_spec
from dressing_sim.world.sleeve import FLEX

CAPSULE, SPHERE = mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_SPHERE


def mannequin(posture, friction=0.4):
    spec = mujoco.MjSpec()
    add_mannequin(spec, posture, friction, contype=1, conaffinity=6)
    return spec.compile()


def parts(model, link, kind):
    """Ends (start, end) and radius of the capsules or spheres of a link."""
    for i in np.flatnonzero(model.geom_bodyid == model.body(link).id):
        if model.geom_type[i] == kind:
            matrix = np.zeros(9)
            mujoco.mju_quat2Mat(matrix, model.geom_quat[i])
            half = (model.geom_size[i, 1] if kind == CAPSULE else 0.0) * matrix.reshape(3, 3)[:, 2]
            middle = model.body(link).pos + model.geom_pos[i]
            yield middle - half, middle + half, model.geom_size[i, 0]


def has_capsule(model, link, start, end, radius):
    return any(
        np.isclose(r, radius)
        and (np.allclose([a, b], [start, end]) or np.allclose([b, a], [start, end]))
        for a, b, r in parts(model, link, CAPSULE)
    )


@pytest.mark.parametrize("size", ARM_SIZES)
@pytest.mark.parametrize("angles", [(0, 0, 0, 0), (66, 30, 48, 65), (-20, 100, -40, 150)])
def test_the_arm_is_where_the_posture_says(size, angles):
    posture = Posture("any", *angles, size=size, shoulder_position=(0.5, -0.2, 0.3))
    model, arm = mannequin(posture), posture.arm_size
    assert has_capsule(model, "forearm", posture.wrist, posture.elbow, arm.forearm_radius)
    assert has_capsule(model, "upper_arm", posture.elbow, posture.shoulder, arm.upper_arm_radius)
    hand = [(a, b) for a, b, _ in parts(model, "hand", CAPSULE)]
    assert any(np.allclose(posture.wrist, end) for pair in hand for end in pair)


@pytest.mark.parametrize("joint", ["shoulder", "elbow", "wrist"])
def test_a_sphere_closes_every_joint(posture, joint):
    model, place = mannequin(posture), getattr(posture, joint)
    spheres = [s for link in ARM_LINKS for s in parts(model, link, SPHERE)]
    radius = max(r for centre, _, r in spheres if np.allclose(centre, place))
    meeting = [
        r
        for link in ("forearm", "upper_arm")
        for a, b, r in parts(model, link, CAPSULE)
        if np.allclose(a, place) or np.allclose(b, place)
    ]
    assert radius > max(meeting)


def test_the_mannequin_cannot_move_and_its_trunk_is_on_the_right_of_its_left_arm(posture):
    model = mannequin(posture)
    assert model.nv == 0
    for link in ("torso", "head"):
        ends = [end for a, b, _ in parts(model, link, CAPSULE) for end in (a, b)]
        assert (np.mean(ends, axis=0) - posture.shoulder) @ LEFT < -0.1


def test_every_part_has_the_friction_it_was_given(posture):
    np.testing.assert_allclose(mannequin(posture, friction=0.7).geom_friction[:, 0], 0.7)


def test_cloth_and_robot_touch_the_mannequin_and_nothing_else_touches(posture):
    spec, _ = build_spec(posture, WorldConfig())
    model = spec.compile()
    flex = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_FLEX, FLEX)
    masks = {"cloth": {(int(model.flex_contype[flex]), int(model.flex_conaffinity[flex]))}}
    mannequin_bodies = [model.body(link).id for link in LINKS]
    on_mannequin = np.isin(model.geom_bodyid, mannequin_bodies)
    for name, chosen in (("mannequin", on_mannequin), ("robot", ~on_mannequin)):
        masks[name] = set(
            zip(
                model.geom_contype[chosen].tolist(),
                model.geom_conaffinity[chosen].tolist(),
                strict=True,
            )
        )

    def touch(one, other):
        pairs = product(masks[one], masks[other])
        return {bool(a[0] & b[1] or b[0] & a[1]) for a, b in pairs}

    assert touch("cloth", "mannequin") == {True}
    assert touch("robot", "mannequin") == {True}
    assert touch("robot", "cloth") == {False}
    assert touch("cloth", "cloth") == {False}
    assert touch("robot", "robot") == {False}
    assert model.flex_selfcollide[flex] == mujoco.mjtFlexSelf.mjFLEXSELF_NONE
