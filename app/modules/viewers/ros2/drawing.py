"""Which topics a channel has in a graph of ROS 2, and the messages on those that no recording has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from app.logs.ros import typestore
from app.logs.ros.frames import ODOM, TF, Transform, pose2_numbers
from app.logs.ros.live.blank import blank
from app.logs.ros.record import Record, RecordTopic
from app.logs.stamps import to_ns
from app.messages import Localization
from app.modules.viewers.ros2.navigate import pose_stamped
from app.modules.viewers.topics import recorded

Transforms = Literal["none", "map", "all"]
"""Which transforms are sent: none, that of ``odom`` in ``map``, or the robot's and its sensors', too."""
MAP = "map"
_POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
#: The covariance of x, y and theta among the six of a pose in space.
_PLANAR = np.ix_((0, 1, 5), (0, 1, 5))


def drawn(transforms: Transforms) -> Callable[[str, type[Any]], tuple[RecordTopic, ...]]:
    """The topics of a channel: as in a recording, and of the place on the map its pose."""

    def topics(channel: str, message_type: type[Any]) -> tuple[RecordTopic, ...]:
        found = tuple(topic for topic in recorded(channel, message_type) if topic != TF or transforms == "all")
        if message_type is Localization:
            found += (_pose_topic(channel), *(() if transforms == "none" else (TF,)))
        return found

    return topics


class PlaceRecords:
    """The records of the place on the map, beside those of a recording."""

    def __init__(self) -> None:
        self._transform = Transform(MAP, ODOM)

    def encode(self, channel: str, message: Localization) -> list[Record]:
        """The pose with its covariance, and the transform of ``odom``."""
        stamp_ns = to_ns(message.stamp)
        made, posed = blank(_POSE), pose_stamped(message.X_MB, message.stamp)
        made.header, made.pose.pose = posed.header, posed.pose
        covariance = np.zeros((6, 6))
        covariance[_PLANAR] = message.covariance
        made.pose.covariance = covariance.reshape(-1)
        data = bytes(typestore.store().serialize_cdr(made, _POSE, little_endian=True))
        return [
            Record(_pose_topic(channel).name, _POSE, stamp_ns, data),
            self._transform.record(stamp_ns, pose2_numbers(message.X_MO)),
        ]


def _pose_topic(channel: str) -> RecordTopic:
    return RecordTopic(f"/{channel}/pose", _POSE, None)
