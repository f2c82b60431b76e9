import numpy as np
import pytest
from lab_recordings import TURN_DEG, columns

from dressing_sim.datasets.prepare import ImportConfig
from dressing_sim.datasets.recording import of_columns
from dressing_sim.datasets.ros import read_bag
from dressing_sim.datasets.sources import read_source
from dressing_sim.datasets.topics import Topics
from dressing_sim.errors import InvalidInputError

rosbag2 = pytest.importorskip("rosbags.rosbag2")
typesys = pytest.importorskip("rosbags.typesys")

STORE = typesys.get_typestore(typesys.Stores.LATEST)
START_NS = 1_764_000_000_000_000_000


def _message(kind, at, numbers, frame):
    types = STORE.types
    seconds, rest = divmod(START_NS + round(1e9 * at), 10**9)
    stamp = types["builtin_interfaces/msg/Time"](int(seconds), int(rest))
    header = types["std_msgs/msg/Header"](stamp, frame)
    if kind == "Wrench":
        vector = types["geometry_msgs/msg/Vector3"]
        body = types["geometry_msgs/msg/Wrench"](vector(*numbers), vector(0.0, 0.0, 0.0))
    else:
        body = types["geometry_msgs/msg/Point"](*numbers[:3])
        if kind == "Pose":
            turn = types["geometry_msgs/msg/Quaternion"](*numbers[3:])
            body = types["geometry_msgs/msg/Pose"](body, turn)
    return types[f"geometry_msgs/msg/{kind}Stamped"](header, body)


def write_bag(path, values, frame="lab", odd_frame=None, plugin="SQLITE3"):
    """A bag of what a lab recorded, the joints at 10 Hz."""
    times = values["time"]
    pose = np.column_stack([values["gripper"], values["quaternion"]])
    topics = {"/gripper": ("Pose", times, pose), "/force": ("Wrench", times, values["force"])}
    for joint in ("shoulder", "elbow", "wrist"):
        topics[f"/{joint}"] = ("Point", times[::10], np.tile(values[joint], (len(times[::10]), 1)))
    storage = getattr(rosbag2.StoragePlugin, plugin)
    with rosbag2.Writer(path, version=9, storage_plugin=storage) as bag:
        for topic, (kind, at, rows) in topics.items():
            name = f"geometry_msgs/msg/{kind}Stamped"
            connection = bag.add_connection(topic, name, typestore=STORE)
            for when, row in zip(at, rows, strict=True):
                where = odd_frame if odd_frame and topic == "/wrist" else frame
                raw = STORE.serialize_cdr(_message(kind, when, row.tolist(), where), name)
                bag.write(connection, START_NS + round(1e9 * when), raw)
    return path


@pytest.mark.parametrize("plugin", ["SQLITE3", "MCAP"])
def test_a_bag_says_what_the_table_does(plugin, tmp_path):
    values = columns()
    read = read_bag(write_bag(tmp_path / "bag", values, plugin=plugin))
    wanted = of_columns("bag", values)
    for name in ("gripper", "shoulder", "elbow", "wrist", "quaternion", "force"):
        np.testing.assert_allclose(getattr(read, name), getattr(wanted, name), atol=1e-6)
    np.testing.assert_allclose(read.times, wanted.times - wanted.times[0], atol=1e-8)
    (made,) = read_source(tmp_path / "bag", ImportConfig(turn_deg=-TURN_DEG))
    assert (made.posture.name, made.commands) == ("bag", None)


def test_topics_are_chosen_and_missed_by_name(tmp_path):
    bag = write_bag(tmp_path / "bag", columns())
    with pytest.raises(InvalidInputError, match=r"no topic of the wrist; valid is --topics.wrist"):
        read_bag(bag, Topics(wrist="/hand"))
    with pytest.raises(InvalidInputError, match="has geometry_msgs/msg/WrenchStamped, valid is"):
        read_bag(bag, Topics(gripper="/force", force="/nothing"))


def test_frames_that_differ_and_damage_are_refused(tmp_path):
    with pytest.raises(InvalidInputError, match="different frames"):
        read_bag(write_bag(tmp_path / "odd", columns(), odd_frame="camera"))
    bag = write_bag(tmp_path / "bag", columns())
    (data,) = bag.glob("*.db3")
    data.write_bytes(data.read_bytes()[:5000])
    with pytest.raises(InvalidInputError, match="no ROS 2 bag, or damaged") as refused:
        read_bag(bag)
    assert "\n" not in str(refused.value)
    (bag / "metadata.yaml").write_text(":\n- [")
    with pytest.raises(InvalidInputError, match="no ROS 2 bag, or damaged"):
        read_bag(bag)
