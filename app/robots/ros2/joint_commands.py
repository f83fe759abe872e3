"""Set-points of joints to controllers of ros2_control: the messages, and their publishers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy

from app.logs.ros import typestore
from app.logs.ros.live.classes import message_class
from app.logs.stamps import to_ns
from app.robots.ros2.config import TRAJECTORY, JointTopicConfig, Ros2Config
from app.robots.ros2.health import Seen, unheard

#: A point of a trajectory is reached so many periods after it was sent: the next is there before.
_PERIODS_AHEAD = 2
#: An older set-point is worth nothing.
_NEWEST = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.RELIABLE)


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


def encoded(topic: JointTopicConfig, names: tuple[str, ...], positions: tuple[float, ...]) -> bytes:
    """The CDR of the message of ``topic`` that sends joints ``names`` to ``positions`` (rad, m)."""
    numbers = np.array(positions, np.float64)
    if topic.type != TRAJECTORY:
        layout = typestore.make("std_msgs/msg/MultiArrayLayout", [], 0)
        return typestore.serialise(topic.type, layout, numbers)
    made = trajectory(names, numbers, topic.hz)
    return typestore.serialise(topic.type, made.header, made.joint_names, made.points)


class JointCommands:
    """The publishers of ``config``'s groups in ``node`` that have a topic. ``look`` is called in rclpy's thread, all
    else in the guard's. Raises Unsupported where the middleware is another than Fast DDS."""

    def __init__(self, node: Node, config: Ros2Config) -> None:
        self._node = node
        self._topics: Mapping[str, JointTopicConfig] = {
            name: topic for name, topic in config.joint_commands.items() if topic.action is None
        }
        self._joints = {name: tuple(joint.name for joint in group.joints) for name, group in config.groups.items()}
        self._seen = {name: Seen(name, config.full_name(topic.topic or "")) for name, topic in self._topics.items()}
        self._writers: dict[str, Any] = {
            name: node.create_publisher(message_class(topic.type), self._seen[name].topic, _NEWEST)
            for name, topic in self._topics.items()
        }

    @property
    def faults(self) -> dict[str, str]:
        """Why commands do not reach a group, by its name; "" where they do, as far as can be known."""
        return {name: unheard(seen) for name, seen in self._seen.items()}

    def look(self) -> list[str]:
        """See who listens; sentences for people on others who command the same joints."""
        sentences = []
        own = self._node.get_name()
        for name, topic in self._topics.items():
            seen = self._seen[name]
            infos = self._node.get_subscriptions_info_by_topic(seen.topic)
            kinds = sorted({info.topic_type for info in infos})
            ours = sum(info.topic_type == topic.type for info in infos)
            problem = f"has the type {', '.join(kinds)}; the mapping writes {topic.type}" if kinds and not ours else ""
            self._seen[name] = replace(seen, others=ours, problem=problem)
            others = {info.node_name for info in self._node.get_publishers_info_by_topic(seen.topic)} - {own}
            if others:
                sentences.append(f"{', '.join(sorted(others))} can publish on {seen.topic}, too: past the guard")
        return sentences

    def publish(self, name: str, positions: tuple[float, ...]) -> None:
        """Send the joints of the group ``name`` to ``positions`` (rad, m), in its order."""
        self._writers[name].publish(encoded(self._topics[name], self._joints[name], positions))
