"""Set-points of joints to controllers of ros2_control: the messages, as objects of rosbags."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.logs.ros import typestore
from app.logs.stamps import to_ns
from app.robots.ros2.config import TRAJECTORY, JointTopicConfig

#: A point of a trajectory is reached so many periods after it was sent: the next is there before.
_PERIODS_AHEAD = 2


def trajectory(names: tuple[str, ...], positions: NDArray[np.float64], rate_hz: float) -> Any:
    """A trajectory_msgs/JointTrajectory of one point, that joints ``names`` are at ``positions`` (rad, m) two periods
    of ``rate_hz`` later."""
    none = np.zeros(0)
    within = typestore.make("builtin_interfaces/msg/Duration", *divmod(to_ns(_PERIODS_AHEAD / rate_hz), 10**9))
    point = typestore.make("trajectory_msgs/msg/JointTrajectoryPoint", positions, none, none, none, within)
    # A stamp of zero: it begins as it arrives, whatever the two clocks say.
    return typestore.make(
        TRAJECTORY, typestore.make("std_msgs/msg/Header", typestore.time(0), ""), list(names), [point]
    )


def joint_message(topic: JointTopicConfig, names: tuple[str, ...], positions: tuple[float, ...]) -> Any:
    """The message of ``topic`` that sends joints ``names`` to ``positions`` (rad, m)."""
    numbers = np.array(positions, np.float64)
    if topic.type == TRAJECTORY:
        return trajectory(names, numbers, topic.hz)
    return typestore.make(topic.type, typestore.make("std_msgs/msg/MultiArrayLayout", [], 0), numbers)


def encoded(topic: JointTopicConfig, names: tuple[str, ...], positions: tuple[float, ...]) -> bytes:
    """The CDR of :func:`joint_message`."""
    message = joint_message(topic, names, positions)
    return bytes(typestore.store().serialize_cdr(message, topic.type, little_endian=True))
