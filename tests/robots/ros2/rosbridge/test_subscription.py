"""What is asked of rosbridge for a topic, and when again."""

from __future__ import annotations

from app.robots.ros2.config import TRANSFORMS, load_ros2_config
from app.robots.ros2.rosbridge.subscription import Subscription, subscriptions
from tests.robots.ros2.robot import MAPPING

SCAN = "sensor_msgs/msg/LaserScan"


def test_the_newest_is_enough_at_most_twice_as_often_as_mapped() -> None:
    asked = Subscription("hokuyo", "/scan", SCAN, 10.0).asking(0.0, is_ros1=False)
    assert asked == {
        "op": "subscribe", "id": "hbba hokuyo", "topic": "/scan", "type": SCAN, "throttle_rate": 50, "queue_length": 1,
    }  # fmt: skip
    of_ros1 = Subscription("hokuyo", "/scan", SCAN, 10.0).asking(0.0, is_ros1=True)
    assert of_ros1["type"] == "sensor_msgs/LaserScan"
    # Of transforms and joints all are needed, of each publisher.
    every = Subscription("odometry", "/tf", TRANSFORMS, None).asking(0.0, is_ros1=None)
    assert every == {"op": "subscribe", "id": "hbba odometry", "topic": "/tf"}


def test_what_stays_silent_is_asked_for_again_ever_more_rarely() -> None:
    scans = Subscription("hokuyo", "/scan", SCAN, 10.0)
    assert not scans.is_due(100.0), "it was not asked for"
    scans.asking(0.0, is_ros1=False)
    again: list[float] = []
    for tenths in range(1, 1000):
        if scans.is_due(tenths / 10):
            scans.asking(tenths / 10, is_ros1=False)
            again.append(tenths / 10)
    assert [round(after - before) for before, after in zip([0.0, *again], again, strict=False)] == [
        2,
        4,
        8,
        16,
        16,
        16,
        16,
        16,
    ]
    scans.came(100.0)
    assert not scans.is_due(102.0)
    assert scans.is_silent(102.0)
    assert scans.is_due(102.1)


def test_a_slow_topic_is_not_silent_between_its_messages() -> None:
    battery = Subscription("battery", "/battery_state", "sensor_msgs/msg/BatteryState", 0.2)
    assert battery.asking(0.0, is_ros1=False)["throttle_rate"] == 100, "its messages must not grow old there"
    battery.came(1.0)
    assert not battery.is_due(15.0)
    assert battery.is_due(16.1)


def test_once_types_are_known_what_gave_nothing_is_asked_for_at_once() -> None:
    scans = Subscription("hokuyo", "/scan", SCAN, 10.0)
    scans.asking(1.0, is_ros1=None)
    assert not scans.has_type
    scans.came(2.0)
    scans.hurry()
    assert scans.asked == 1.0
    scans.asking(3.0, is_ros1=None)
    scans.hurry()
    assert scans.asked is None


def test_those_of_a_mapping() -> None:
    found = subscriptions(load_ros2_config(MAPPING))
    assert {name for name, each in found.items() if each.is_picture} == {"camera", "camera.info"}
    assert found["tf_static"].topic == "/tf_static"
    assert "throttle_rate" not in found["joints"].asking(0.0, is_ros1=False)
