"""Set-points of joints over rosbridge, which go by topics alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from app.robots.ros2.config import Ros2Config
from app.robots.ros2.health import Seen, unheard
from app.robots.ros2.joint_messages import joint_message


class JointTopics:
    """The topics for set-points of ``config``'s groups; ``send`` is given topic, type and message."""

    def __init__(self, config: Ros2Config, send: Callable[[str, str, Any], None]) -> None:
        self._topics = dict(config.joint_commands)
        self._joints = {name: tuple(joint.name for joint in group.joints) for name, group in config.groups.items()}
        self._seen = {name: Seen(name, config.full_name(topic.topic or "")) for name, topic in self._topics.items()}
        self._send = send

    @property
    def types(self) -> dict[str, str]:
        """The type by topic."""
        return {self._seen[name].topic: topic.type for name, topic in self._topics.items()}

    @property
    def faults(self) -> dict[str, str]:
        """As of :class:`app.robots.ros2.body_node.JointWriters`."""
        return {name: unheard(seen) for name, seen in self._seen.items()}

    def note(self, topic: str, others: int, problem: str) -> None:
        """Note how many listen to ``topic``, and what is wrong with its type."""
        for name, seen in self._seen.items():
            if seen.topic == topic:
                self._seen[name] = replace(seen, others=others, problem=problem)

    def publish(self, name: str, positions: tuple[float, ...]) -> None:
        """As of :class:`app.robots.ros2.body_node.JointWriters`."""
        topic = self._topics[name]
        self._send(self._seen[name].topic, topic.type, joint_message(topic, self._joints[name], positions))


class NoActions:
    """No group has an action: a mapping over rosbridge with one is refused."""

    def __init__(self) -> None:
        self.faults: dict[str, str] = {}
        self.refusals: dict[str, str] = {}

    def __contains__(self, name: str) -> bool:
        return False

    def ready(self, name: str) -> bool:
        """As of :class:`app.robots.ros2.body_node.JointGoals`."""
        return False

    def publish(self, name: str, positions: tuple[float, ...]) -> None:
        """There is no action."""

    def halt(self, name: str) -> None:
        """There is no action."""
