"""Messages that become one record: generated types, and those that ROS has a type for which holds all they hold."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from app.base.geometry import Pose2
from app.logs.ros import typestore
from app.logs.ros.frames import BASE, ODOM, TF, Transform, header, pose2_numbers
from app.logs.ros.generated import generated
from app.logs.ros.record import MAIN, Record, RecordTopic
from app.logs.ros.record_templates import Numbers
from app.messages import JointState, LogLine, Odometry, Twist

_COVARIANCE = 36
#: A place in a message counted from its end, in float64.
_NUMBER = -8


class GeneratedConverter:
    """Any message, as the definition made of its class."""

    def __init__(self, channel: str, cls: type[Any], definition: str | None = None) -> None:
        """Reads records of an earlier ``definition``, from before there were more fields. Raises UnrecordableType."""
        self._generated = generated(cls)
        self._written = None if definition is None else typestore.of_definition(self._generated.type, definition)
        self._topic = f"/{channel}"
        self.topics: tuple[RecordTopic, ...] = (RecordTopic(self._topic, self._generated.type),)

    def encode(self, message: Any, stamp_ns: int) -> list[Record]:
        return [Record(self._topic, self._generated.type, stamp_ns, self._generated.encode(message))]

    def decode(self, parts: Mapping[str, bytes]) -> Any:
        if self._written is None:
            return self._generated.decode(parts[MAIN])
        return self._generated.from_ros(typestore.deserialise(self._generated.type, parts[MAIN], self._written))


class OdometryConverter:
    """``nav_msgs/Odometry`` (covariances zero: unknown) and the transform of ``base_link`` in ``odom``.

    Theta comes back to 1e-15, and modulo two turns.
    """

    _TYPE = "nav_msgs/msg/Odometry"

    def __init__(self, channel: str) -> None:
        self.topics = (RecordTopic(f"/{channel}", self._TYPE), TF)
        zeros = np.zeros(_COVARIANCE)
        pose = typestore.make(
            "geometry_msgs/msg/Pose",
            typestore.make("geometry_msgs/msg/Point", 0.0, 0.0, 0.0),
            typestore.make("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0),
        )
        twist_at = (6 + _COVARIANCE) * _NUMBER
        self._numbers = Numbers(
            typestore.serialise(
                self._TYPE,
                header(ODOM),
                BASE,
                typestore.make("geometry_msgs/msg/PoseWithCovariance", pose, zeros),
                typestore.make("geometry_msgs/msg/TwistWithCovariance", _twist(0.0, 0.0), zeros),
            ),
            (twist_at + (7 + _COVARIANCE) * _NUMBER, 7),
            (twist_at, 6),
        )
        self._transform = Transform(ODOM, BASE)

    def encode(self, message: Odometry, stamp_ns: int) -> list[Record]:
        pose = pose2_numbers(message.X_OB)
        data = self._numbers.fill(stamp_ns, pose, _velocity(message))
        return [Record(self.topics[0].name, self._TYPE, stamp_ns, data), self._transform.record(stamp_ns, pose)]

    def decode(self, parts: Mapping[str, bytes]) -> Odometry:
        ros = typestore.deserialise(self._TYPE, parts[MAIN])
        position, turn = ros.pose.pose.position, ros.pose.pose.orientation
        twist = ros.twist.twist
        pose = Pose2(position.x, position.y, 2.0 * math.atan2(turn.z, turn.w))
        linear = twist.linear
        return Odometry(typestore.seconds(ros.header.stamp), pose, linear.x, twist.angular.z, lateral_mps=linear.y)


class TwistConverter:
    """``geometry_msgs/TwistStamped`` in ``base_link``."""

    _TYPE = "geometry_msgs/msg/TwistStamped"

    def __init__(self, channel: str) -> None:
        self.topics = (RecordTopic(f"/{channel}", self._TYPE),)
        template = typestore.serialise(self._TYPE, header(BASE), _twist(0.0, 0.0))
        self._numbers = Numbers(template, (6 * _NUMBER, 6))

    def encode(self, message: Twist, stamp_ns: int) -> list[Record]:
        data = self._numbers.fill(stamp_ns, _velocity(message))
        return [Record(self.topics[0].name, self._TYPE, stamp_ns, data)]

    def decode(self, parts: Mapping[str, bytes]) -> Twist:
        ros = typestore.deserialise(self._TYPE, parts[MAIN])
        linear = ros.twist.linear
        return Twist(typestore.seconds(ros.header.stamp), linear.x, ros.twist.angular.z, lateral_mps=linear.y)


class JointStateConverter:
    """``sensor_msgs/JointState``."""

    _TYPE = "sensor_msgs/msg/JointState"

    def __init__(self, channel: str) -> None:
        self.topics = (RecordTopic(f"/{channel}", self._TYPE),)
        self._names: tuple[str, ...] = ()
        self._has_efforts = False
        self._numbers = self._template(())

    def encode(self, message: JointState, stamp_ns: int) -> list[Record]:
        has_efforts = bool(message.efforts)
        if message.names != self._names or has_efforts != self._has_efforts:
            self._names, self._has_efforts = message.names, has_efforts
            self._numbers = self._template(message.names, has_efforts)
        data = self._numbers.fill(stamp_ns, message.positions, message.efforts)
        return [Record(self.topics[0].name, self._TYPE, stamp_ns, data)]

    def decode(self, parts: Mapping[str, bytes]) -> JointState:
        ros = typestore.deserialise(self._TYPE, parts[MAIN])
        stamp = typestore.seconds(ros.header.stamp)
        return JointState(stamp, tuple(ros.name), tuple(ros.position.tolist()), tuple(ros.effort.tolist()))

    def _template(self, names: tuple[str, ...], has_efforts: bool = False) -> Numbers:
        count = len(names)
        efforts = count if has_efforts else 0
        data = typestore.serialise(self._TYPE, header(""), list(names), np.zeros(count), np.zeros(0), np.zeros(efforts))
        # Between positions and efforts stand the lengths of velocities, 0, and efforts.
        return Numbers(data, ((count + 1 + efforts) * _NUMBER, count), (efforts * _NUMBER or len(data), efforts))


class LogLineConverter:
    """``rcl_interfaces/Log``, whose levels are Python's."""

    _TYPE = "rcl_interfaces/msg/Log"

    def __init__(self, channel: str) -> None:
        self.topics = (RecordTopic(f"/{channel}", self._TYPE),)

    def encode(self, message: LogLine, stamp_ns: int) -> list[Record]:
        level = min(max(message.level, 0), 255)
        source, text = typestore.encodable(message.source), typestore.encodable(message.text)
        data = typestore.serialise(self._TYPE, typestore.time(stamp_ns), level, source, text, "", "", 0)
        return [Record(self.topics[0].name, self._TYPE, stamp_ns, data)]

    def decode(self, parts: Mapping[str, bytes]) -> LogLine:
        ros = typestore.deserialise(self._TYPE, parts[MAIN])
        return LogLine(typestore.seconds(ros.stamp), ros.level, ros.name, ros.msg)


def _velocity(message: Odometry | Twist) -> tuple[float, ...]:
    """The six numbers of a ``geometry_msgs/Twist``."""
    return (message.linear_mps, message.lateral_mps, 0.0, 0.0, 0.0, message.angular_radps)


def _twist(linear: float, angular: float) -> Any:
    return typestore.make(
        "geometry_msgs/msg/Twist",
        typestore.make("geometry_msgs/msg/Vector3", linear, 0.0, 0.0),
        typestore.make("geometry_msgs/msg/Vector3", 0.0, 0.0, angular),
    )
