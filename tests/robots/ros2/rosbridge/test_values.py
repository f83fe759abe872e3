"""Messages in JSON as rosbridge writes them: there and back, and what is none of them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.logs.importers.ros_messages import Unreadable
from app.logs.ros import typestore
from app.logs.ros.live.blank import blank
from app.logs.ros.live.kinds import Kind, fields_of
from app.robots.guard import BaseVelocity
from app.robots.ros2.config import (
    CAMERA_INFO,
    COMPRESSED_IMAGE,
    IMAGE,
    POSITIONS,
    TRAJECTORY,
    TRANSFORMS,
    TWIST,
    TWIST_STAMPED,
    TYPES,
)
from app.robots.ros2.rosbridge.twist import twist_message
from app.robots.ros2.rosbridge.values import from_message, parsed, plain_name, same_type, to_message

KINDS = (
    *TYPES.values(), IMAGE, COMPRESSED_IMAGE, CAMERA_INFO, TRANSFORMS, TRAJECTORY, POSITIONS, TWIST, TWIST_STAMPED,
    "rosgraph_msgs/msg/Clock",
)  # fmt: skip
ODOMETRY = TYPES["odometry"]
#: As JSON has it: what is not finite is null, which comes back as NaN.
FLOATS = st.floats(allow_infinity=False).map(lambda value: math.nan if math.isnan(value) else value)


def values(kind: Kind) -> st.SearchStrategy[Any]:
    """Values of a field."""
    if not (kind.is_array or kind.is_sequence):
        return one(kind)
    least, most = (kind.count, kind.count) if kind.is_array else (0, 3)
    many = st.lists(one(kind), min_size=least, max_size=most)
    if kind.nested or kind.base.endswith("string"):
        return many
    dtype = {"byte": "uint8", "octet": "uint8", "char": "uint8"}.get(kind.base, kind.base)
    return many.map(lambda numbers: np.array(numbers, dtype))


def one(kind: Kind) -> st.SearchStrategy[Any]:
    """Values of a field that is no array, or of one of its elements."""
    if kind.nested:
        return messages(kind.nested)
    if kind.base.endswith("string"):
        return st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=8)
    if kind.base.startswith("float"):
        return FLOATS if kind.base == "float64" else st.floats(width=32, allow_infinity=False, allow_nan=False)
    if kind.base == "bool":
        return st.booleans()
    limits = np.iinfo({"byte": "uint8", "octet": "uint8", "char": "uint8"}.get(kind.base, kind.base))
    return st.integers(int(limits.min), int(limits.max))


def messages(name: str) -> st.SearchStrategy[Any]:
    """Messages of a type."""
    make = typestore.store().types[name]
    return st.tuples(*(values(kind) for _, kind in fields_of(name))).map(lambda fields: make(*fields))


def cdr(kind: str, message: Any) -> bytes:
    """``message`` in ROS's own coding, which checks each field's type, too."""
    return bytes(typestore.store().serialize_cdr(message, kind))


@settings(max_examples=100)
@given(st.sampled_from(KINDS).flatmap(lambda kind: st.tuples(st.just(kind), messages(kind))), st.booleans())
def test_a_message_goes_there_and_back(made: tuple[str, Any], ros1: bool) -> None:
    kind, message = made
    text = json.dumps(from_message(kind, message, ros1=ros1), allow_nan=False)
    assert cdr(kind, to_message(kind, json.loads(text))) == cdr(kind, message)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)


@settings(max_examples=50)
@given(st.sampled_from(KINDS), JSON, st.data())
def test_whatever_comes_is_a_message_or_a_sentence(kind: str, value: Any, data: st.DataObject) -> None:
    """``value`` in the place of one part of a message, however deep."""
    given = from_message(kind, blank(kind))
    part: Any = given
    while True:
        key = data.draw(st.sampled_from(sorted(part)) if isinstance(part, dict) else st.integers(0, len(part) - 1))
        if not isinstance(part[key], dict | list) or not part[key] or data.draw(st.booleans()):
            break
        part = part[key]
    part[key] = value
    said = ""
    try:
        cdr(kind, to_message(kind, given))
    except Unreadable as failure:
        said = str(failure)
    assert len(said) < 400


ROSBRIDGE_WROTE = """{
  "header": {"stamp": {"sec": 12, "nanosec": 500000000}, "frame_id": "laser"}, "angle_min": -1, "angle_max": 1.0,
  "angle_increment": 1.0, "time_increment": 0.0, "scan_time": 0.1, "range_min": 0.1, "range_max": 10.0,
  "ranges": [1, null, 2.5], "intensities": []
}"""


def test_a_scan_as_rosbridge_writes_it() -> None:
    scan = to_message("sensor_msgs/msg/LaserScan", parsed(ROSBRIDGE_WROTE))
    assert scan.ranges.dtype == np.float32
    assert np.array_equal(scan.ranges, np.array([1.0, np.nan, 2.5], np.float32), equal_nan=True)
    assert (scan.header.stamp.sec, scan.header.stamp.nanosec, scan.angle_min) == (12, 500_000_000, -1.0)
    of_ros1 = ROSBRIDGE_WROTE.replace('"sec"', '"secs"').replace('"nanosec"', '"nsecs"').replace("{\n", '{"seq": 1,', 1)
    of_ros1 = of_ros1.replace("null", "Infinity")
    scan = to_message("sensor_msgs/msg/LaserScan", parsed(of_ros1))
    assert (scan.header.stamp.sec, scan.ranges[1]) == (12, np.inf)


def test_bytes_are_base64_or_a_list() -> None:
    picture = from_message(COMPRESSED_IMAGE, blank(COMPRESSED_IMAGE, format="jpeg", data=np.arange(4, dtype=np.uint8)))
    assert picture["data"] == "AAECAw=="
    for data in ("AAECAw==", [0, 1, 2, 3]):
        assert to_message(COMPRESSED_IMAGE, picture | {"data": data}).data.tolist() == [0, 1, 2, 3]


def test_what_came_late_to_ros_may_be_missing() -> None:
    battery = from_message(TYPES["battery"], blank(TYPES["battery"], percentage=0.5))
    del battery["temperature"]
    assert to_message(TYPES["battery"], battery).percentage == 0.5


def _set(*path: str, to: Any) -> Callable[[dict[str, Any]], None]:
    def change(message: dict[str, Any]) -> None:
        for key in path[:-1]:
            message = message[key]
        message[path[-1]] = to

    return change


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (_set("pose", to=3), "pose is 3, no geometry_msgs/PoseWithCovariance"),
        (_set("pose", "pose", "position", "x", to="1"), 'pose.pose.position.x is "1", no number'),
        (_set("pose", "covariance", to=[0.0]), "pose.covariance has 1 values, not 36"),
        (_set("pose", "covariance", to=[0.0] * 35 + [True]), "pose.covariance[35] is true, no float64"),
        (_set("header", "stamp", "sec", to=1 << 31), "header.stamp.sec is 2147483648, no int32"),
        (_set("header", "frame_id", to=None), "header.frame_id is null, no text"),
        (_set("header", to={}), "it has no header.stamp"),
        (lambda message: message.clear(), "it has no header"),
    ],
)
def test_what_is_wrong_is_a_sentence(change: Callable[[dict[str, Any]], None], said: str) -> None:
    message = from_message(ODOMETRY, blank(ODOMETRY))
    change(message)
    with pytest.raises(Unreadable) as refused:
        to_message(ODOMETRY, message)
    assert str(refused.value) == said


@pytest.mark.parametrize(
    ("frame", "said"),
    [
        ("{", "it is no JSON"), ("[" * 100_000, "it is no JSON"), (b"\xff\xfe\xff", "it is no JSON"),
        ("9" * 5000, "it is no JSON"), ("[1]", "it is no object, but a list"),
    ],
)  # fmt: skip
def test_a_frame_that_is_no_message(frame: str | bytes, said: str) -> None:
    with pytest.raises(Unreadable, match=said):
        parsed(frame)


def test_types_have_two_names() -> None:
    assert plain_name(ODOMETRY) == "nav_msgs/Odometry"
    assert same_type("nav_msgs/Odometry", ODOMETRY)
    assert not same_type("nav_msgs/Path", ODOMETRY)


def test_a_velocity() -> None:
    velocity = BaseVelocity(0.2, -0.5, 0.1)
    plain = twist_message(velocity, None, 3.0, ros1=True)
    twist = to_message(TWIST, plain)
    assert (twist.linear.x, twist.linear.y, twist.angular.z) == (0.2, 0.1, -0.5)
    for ros1 in (False, True):
        stamped = twist_message(velocity, "base_link", 3.25, ros1=ros1)
        assert stamped["header"]["stamp"] == (
            {"secs": 3, "nsecs": 250_000_000} if ros1 else {"sec": 3, "nanosec": 250_000_000}
        )
        assert stamped["twist"] == plain
    # Without a stamp rosbridge puts in the robot's own time.
    assert twist_message(velocity, "base_link", None, ros1=False)["header"] == {"frame_id": "base_link"}
