from __future__ import annotations

import numpy as np

from app.logs.ros import typestore
from app.logs.ros.live.blank import blank
from app.logs.ros.live.kinds import fields_of


def test_a_blank_message_is_one() -> None:
    for name in ("sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"):
        made = blank(name)
        data = bytes(typestore.store().serialize_cdr(made, name))
        # An empty string is its final zero: its length, 1, is all that is not zero.
        assert sum(data[4:]) == str(made).count("''")
        assert str(typestore.deserialise(name, data)) == str(made)


def test_what_is_given_is_in_it() -> None:
    scan = blank("sensor_msgs/msg/LaserScan", ranges=np.ones(3, np.float32), range_max=2.0)
    back = typestore.deserialise(scan.__msgtype__, bytes(typestore.store().serialize_cdr(scan, scan.__msgtype__)))
    assert (back.ranges.tolist(), back.range_max, back.header.frame_id) == ([1.0, 1.0, 1.0], 2.0, "")


def test_parts_of_services_and_actions_are_types() -> None:
    typestore.add("some_msgs/action/Do_Goal", "string what\n")
    typestore.add("some_msgs/action/Do_SendGoal_Request", "some_msgs/action/Do_Goal goal\nstring<=3 bounded\n")
    request = blank("some_msgs/action/Do_SendGoal_Request")
    assert request.goal.what == ""
    (_, goal), (_, bounded) = fields_of("some_msgs/action/Do_SendGoal_Request")
    assert (goal.nested, bounded.string_bound, bounded.described) == ("some_msgs/action/Do_Goal", 3, 21)
