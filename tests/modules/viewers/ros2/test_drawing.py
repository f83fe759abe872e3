from __future__ import annotations

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.logs.ros import typestore
from app.logs.ros.frames import TF
from app.messages import Image, Localization, Odometry, read_only
from app.modules.viewers.ros2.drawing import PlaceRecords, Transforms, drawn
from app.modules.viewers.topics import ShownTopics


@pytest.mark.parametrize(
    ("transforms", "by"),
    [("none", set()), ("map", {"localization"}), ("all", {"localization", "odometry"})],
)
def test_transforms_are_those_that_are_asked_for(transforms: Transforms, by: set[str]) -> None:
    channels = {"localization": Localization, "odometry": Odometry, "kinect": Image}
    topics = ShownTopics(channels, drawn(transforms))
    assert topics.channels_of(TF.name) == by
    assert topics.types["/localization/pose"] == "geometry_msgs/msg/PoseWithCovarianceStamped"
    assert topics.types["/odometry"] == "nav_msgs/msg/Odometry"


def test_the_place_on_the_map_is_a_pose_and_a_transform() -> None:
    covariance = read_only(np.arange(9.0).reshape(3, 3))
    place = Localization(2.5, Pose2(1.0, 2.0, 3.0), Pose2(4.0, 5.0, -1.0), covariance, "mapping", 1.0, "")
    pose, transform = PlaceRecords().encode("localization", place)
    assert (pose.topic, transform.topic) == ("/localization/pose", "/tf")
    made = typestore.deserialise(pose.type, pose.data)
    assert (made.header.frame_id, typestore.seconds(made.header.stamp)) == ("map", 2.5)
    assert (made.pose.pose.position.x, made.pose.pose.orientation.z) == (4.0, np.sin(-0.5))
    full = made.pose.covariance.reshape(6, 6)
    assert full[np.ix_((0, 1, 5), (0, 1, 5))].tolist() == covariance.tolist()
    assert np.count_nonzero(full) == 8
    (moved,) = typestore.deserialise(transform.type, transform.data).transforms
    assert (moved.header.frame_id, moved.child_frame_id) == ("map", "odom")
    assert (moved.transform.translation.y, moved.transform.rotation.w) == (2.0, np.cos(1.5))
