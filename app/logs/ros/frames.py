"""Transforms for ``/tf``, drawn by every viewer and read back by none: each message carries its own poses exactly."""

from __future__ import annotations

import math

from app.base.geometry import Pose2, Pose3
from app.logs.ros import typestore
from app.logs.ros.record import Record, RecordTopic
from app.logs.ros.record_templates import Numbers

TF = RecordTopic("/tf", "tf2_msgs/msg/TFMessage", None)
ODOM = "odom"
BASE = "base_link"

#: Offset of the first transform's stamp: after the encapsulation and the number of transforms.
_STAMP = 8


def header(frame: str) -> object:
    """A ``std_msgs/Header`` of ``frame``, to be stamped."""
    return typestore.make("std_msgs/msg/Header", typestore.time(0), frame)


def pose2_numbers(pose: Pose2) -> tuple[float, ...]:
    """Translation and quaternion (x, y, z, w) of a planar pose; the half angle keeps theta up to two turns apart."""
    half = 0.5 * pose.theta
    return pose.x, pose.y, 0.0, 0.0, 0.0, math.sin(half), math.cos(half)


def pose3_numbers(pose: Pose3) -> tuple[float, ...]:
    """Translation and quaternion (x, y, z, w) of a pose in space."""
    w, x, y, z = pose.quaternion_wxyz()
    return (*pose.translation.tolist(), x, y, z, w)


class Transform:
    """The transform of ``child`` in ``parent``, as records."""

    def __init__(self, parent: str, child: str) -> None:
        nothing = typestore.make("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
        unit = typestore.make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
        transform = typestore.make("geometry_msgs/msg/Transform", nothing, unit)
        stamped = typestore.make("geometry_msgs/msg/TransformStamped", header(parent), child, transform)
        self._numbers = Numbers(typestore.serialise(TF.type, [stamped]), (-56, 7), stamp=_STAMP)

    def record(self, stamp_ns: int, numbers: tuple[float, ...]) -> Record:
        """``numbers``: translation (m) and quaternion x, y, z, w."""
        return Record(TF.name, TF.type, stamp_ns, self._numbers.fill(stamp_ns, numbers))
