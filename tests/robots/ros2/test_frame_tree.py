from __future__ import annotations

import math
from pathlib import Path

import pytest

from app.base import paths
from app.base.kinematic_model import load_model
from app.cli import main
from app.logs.importers.transforms import StampedTransform, Transforms
from app.robots.ros2.config import TYPES
from app.robots.ros2.frame_tree import differences, dot, text
from tests.logs.importers import bags

TURTLEBOT = paths.config_dir() / "robots" / "turtlebot4.urdf"


def placed(x: float, y: float = 0.0, z: float = 0.0, turn: float = 0.0) -> StampedTransform:
    return StampedTransform(0.0, (x, y, z), (0.0, 0.0, math.sin(turn / 2), math.cos(turn / 2)))


def tree(*edges: tuple[str, str, bool]) -> Transforms:
    frames = Transforms()
    for parent, child, static in edges:
        frames.add(parent, child, placed(1.0), static=static)
    return frames


ROBOT = tree(
    ("odom", "base_link", False),
    ("base_link", "laser", True),
    ("base_link", "camera", True),
    ("camera", "camera_optical", True),
)


def test_the_tree_is_drawn() -> None:
    assert text(ROBOT) == ["odom", "  ~ base_link", "    camera", "      camera_optical", "    laser"]
    assert text(Transforms()) == []
    assert text(tree(("map", "odom", False), ("world", "gantry", True))) == ["map", "  ~ odom", "world", "  gantry"]
    drawn = dot(ROBOT)
    assert drawn.startswith("digraph frames {\n")
    assert '  "odom" -> "base_link" [style=dashed];\n' in drawn
    assert '  "camera" -> "camera_optical";\n' in drawn
    assert '"a\\"b"' in dot(tree(("map", 'a"b', True)))


def test_a_ring_ends() -> None:
    assert text(tree(("a", "b", True), ("b", "a", True))) == ["a", "  b", "    a (above)"]


@pytest.mark.parametrize(
    ("moved", "turned", "said"),
    [(0.0, 0.0, ""), (0.02, 0.02, ""), (0.1, 0.0, "0.10 m and 0°"), (0.0, 0.2, "0.00 m and 11°")],
)
def test_a_sensor_that_is_elsewhere_than_in_the_model_is_noticed(moved: float, turned: float, said: str) -> None:
    model = load_model(TURTLEBOT)
    X_BL = model.pose("rplidar_link")
    heading = math.atan2(X_BL.rotation[1, 0], X_BL.rotation[0, 0])
    x, y, z = X_BL.translation
    frames = Transforms()
    frames.add("base_link", "rplidar_link", placed(x + moved, y, z, heading + turned), static=True)
    found = differences(frames, model, ["rplidar_link", "no_such_link"])
    assert len(found) == bool(said)
    assert said in "".join(found)
    # What moves, or is not said, is not compared.
    assert differences(tree(("base_link", "rplidar_link", False)), model, ["rplidar_link"]) == []


def test_a_bags_frames_are_in_the_proposal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def transform(parent: str, child: str, x: float) -> bags.Fields:
        moved = {"translation": {"x": x}, "rotation": {"w": 1.0}}
        return {"transforms": [{"header": bags.header(10**9, parent), "child_frame_id": child, "transform": moved}]}

    sent = [
        bags.Sent(10**9, "/odom", TYPES["odometry"], {"header": bags.header(10**9, "odom")}),
        bags.Sent(10**9, "/tf", "tf2_msgs/msg/TFMessage", transform("odom", "base_link", 0.0)),
        bags.Sent(10**9, "/tf_static", "tf2_msgs/msg/TFMessage", transform("base_link", "rplidar_link", 0.5)),
        bags.Sent(10**9, "/scan", TYPES["hokuyo"], {"header": bags.header(10**9, "rplidar_link"), "ranges": [1.0]}),
    ]
    folder, drawn = bags.write_ros2_sqlite(tmp_path / "run", sent), tmp_path / "frames.dot"
    main(["ros", "map", str(folder), "--model", str(TURTLEBOT), "--dot", str(drawn)])
    said = capsys.readouterr()
    assert said.out.endswith("#   odom\n#     ~ base_link\n#       rplidar_link\n")
    assert "missing: rplidar_link: the robot's transforms have it 0.5" in said.err
    assert '"odom" -> "base_link" [style=dashed]' in drawn.read_text("utf-8")
