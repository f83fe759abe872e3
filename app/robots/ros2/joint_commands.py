"""Set-points of joints to controllers of ros2_control: the publishers of rclpy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy

from app.logs.ros.live.classes import message_class
from app.robots.ros2.config import JointTopicConfig, Ros2Config
from app.robots.ros2.health import Seen, unheard
from app.robots.ros2.joint_messages import encoded

#: An older set-point is worth nothing.
_NEWEST = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.RELIABLE)


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
