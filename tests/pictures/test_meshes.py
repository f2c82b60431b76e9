import logging
import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import trimesh

from dressing_sim.errors import InvalidInputError
from dressing_sim.pictures import meshes
from dressing_sim.pictures.meshes import cache_folder, converted_meshes, robot_skin
from dressing_sim.world.description import addressed, urdf_path
from dressing_sim.world.robot import Robot, ServoConfig

COLLADA = addressed("package://example-robot-data/robots/panda_description/meshes/visual/hand.dae")


@pytest.fixture(autouse=True)
def empty(tmp_path, monkeypatch):
    """A user without a cache; warnings are told anew."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    meshes._told.clear()


@pytest.fixture
def kept():
    converted_meshes(COLLADA)
    (file,) = cache_folder().iterdir()
    return file


def test_a_link_has_a_mesh_of_each_colour(kept):
    found = converted_meshes(COLLADA)
    assert len(found) > 1
    for colour, content in found.items():
        assert len(bytes.fromhex(colour)) == 3
        assert content.count("\nf ") > 100


def test_what_is_kept_is_read_and_not_converted_again(kept, monkeypatch):
    expected = converted_meshes(COLLADA)
    monkeypatch.setattr(meshes, "_convert", lambda collada: pytest.fail("converted again"))
    assert converted_meshes(COLLADA) == expected


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: content[:100],
        lambda content: content[:-1],
        lambda content: content[:500] + b"x" + content[501:],
        lambda content: b"nonsense",
    ],
)
def test_a_damaged_file_costs_a_warning_and_is_made_anew(kept, damage, caplog):
    good = kept.read_bytes()
    expected = converted_meshes(COLLADA)
    kept.write_bytes(damage(good))
    with caplog.at_level(logging.WARNING):
        assert converted_meshes(COLLADA) == expected
    assert len(caplog.messages) == 1
    assert str(kept) in caplog.messages[0]
    assert kept.read_bytes() == good


def test_without_a_folder_to_write_to_meshes_are_made_each_time(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with caplog.at_level(logging.WARNING):
        first, second = converted_meshes(COLLADA), converted_meshes(COLLADA)
    assert first == second
    assert len(caplog.messages) == 1
    assert str(tmp_path / "file") in caplog.messages[0]


def test_many_at_once_find_a_whole_file():
    with ThreadPoolExecutor(8) as threads:
        found = list(threads.map(converted_meshes, [COLLADA] * 8))
    assert all(one == found[0] for one in found)
    assert [name for name in os.listdir(cache_folder()) if not name.endswith(".meshes")] == []


SHAPES = """<robot name="shapes">
  <material name="blue"><color rgba="0 0 1 1"/></material>
  <link name="base">
    <visual><geometry><box size="0.1 0.2 0.3"/></geometry><material name="blue"/></visual>
    <visual><origin xyz="1 2 3" rpy="0 0 0.5"/><geometry><sphere radius="0.1"/></geometry></visual>
    <visual><geometry><cylinder radius="0.1" length="0.4"/></geometry></visual>
    <visual>
      <geometry><mesh filename="package://mine/brick.stl" scale="0.001 0.001 0.002"/></geometry>
      <material name=""><color rgba="1 0 0 1"/></material>
    </visual>
  </link>
  <link name="tip"/>
  <joint name="a" type="revolute">
    <parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="2" effort="50"/>
  </joint>
</robot>"""


@pytest.fixture
def shapes(tmp_path):
    """A robot that looks like boxes, and a brick of 100 x 50 x 20 mm that is stretched."""
    folder = tmp_path / "mine"
    folder.mkdir()
    trimesh.creation.box(extents=(100.0, 50.0, 20.0)).export(folder / "brick.stl")
    (folder / "shapes.urdf").write_text(SHAPES)
    return Robot(
        name="shapes",
        urdf=str(folder / "shapes.urdf"),
        joints=("a",),
        fingers=(),
        tool="tip",
        home=(0.0,),
        acceleration=(1.0,),
        servo=ServoConfig((100.0,), (10.0,)),
    )


def extent(part):
    vertices = [line.split()[1:4] for line in part.obj.splitlines() if line.startswith("v ")]
    return np.ptp(np.array(vertices, dtype=float), axis=0)


def test_another_robot_is_drawn_as_its_description_says(shapes):
    box, ball, cylinder, brick = robot_skin(shapes)
    assert {part.link for part in (box, ball, cylinder, brick)} == {"base"}
    np.testing.assert_allclose(extent(box), [0.1, 0.2, 0.3])
    np.testing.assert_allclose(extent(ball), 0.2, rtol=0.02)
    np.testing.assert_allclose(extent(cylinder), [0.2, 0.2, 0.4], rtol=0.02)
    np.testing.assert_allclose(extent(brick), [0.1, 0.05, 0.04], rtol=1e-6)
    assert (box.colour, brick.colour) == ("0000ff", "ff0000")
    assert (ball.xyz, ball.rpy) == ((1.0, 2.0, 3.0), (0.0, 0.0, 0.5))
    assert len({part.name for part in (box, ball, cylinder, brick)}) == 4


def test_a_mesh_that_is_missing_or_none_is_refused_in_one_line(shapes):
    brick = addressed("package://mine/brick.stl", urdf_path(shapes).parent)
    for content, told in ((b"solid\nnonsense", "brick.stl: no"), (None, "cannot be read")):
        brick.unlink() if content is None else brick.write_bytes(content)
        with pytest.raises(InvalidInputError, match=told) as refused:
            list(robot_skin(shapes))
        assert "\n" not in str(refused.value)
