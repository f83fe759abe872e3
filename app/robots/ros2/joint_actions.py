"""Set-points of joints as goals of FollowJointTrajectory, for robots that take no topics."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from rclpy.action import ActionClient
from rclpy.node import Node

from app.logs.ros.live.blank import blank
from app.logs.ros.live.joint_trajectory_action import FOLLOW, follow_joint_trajectory
from app.robots.ros2.config import JointTopicConfig, Ros2Config
from app.robots.ros2.goals import Goals
from app.robots.ros2.joint_messages import trajectory

_SEND = f"{FOLLOW}_SendGoal"


class JointActions:
    """The clients of ``config``'s groups in ``node`` that have an action. ``run`` has a function run in rclpy's thread,
    in which ``look`` and ``end`` are called; all else is called in the guard's. Raises Unsupported where the middleware
    is another than Fast DDS."""

    def __init__(self, node: Node, config: Ros2Config, run: Callable[[Callable[[], None]], object]) -> None:
        self._node = node
        self._run = run
        self._topics: Mapping[str, JointTopicConfig] = {
            name: topic for name, topic in config.joint_commands.items() if topic.action is not None
        }
        self._joints = {name: tuple(joint.name for joint in config.groups[name].joints) for name in self._topics}
        self._names = {name: config.full_name(topic.action or "") for name, topic in self._topics.items()}
        self._sentences: list[str] = []
        kind = follow_joint_trajectory() if self._topics else None
        self._clients = {name: ActionClient(node, kind, action) for name, action in self._names.items()}
        self._goals = {
            name: Goals(
                action,
                partial(self._send, name),
                time.monotonic,
                self._sentences.append,
                period_s=1.0 / self._topics[name].hz,
            )
            for name, action in self._names.items()
        }
        #: Groups with a goal that rclpy's thread has not sent yet.
        self._queued: set[str] = set()
        #: Why commands do not reach a group, by its name; "" where they do, as far as can be known.
        self.faults = {name: f"nothing serves the action {action}" for name, action in self._names.items()}

    def __contains__(self, name: str) -> bool:
        return name in self._topics

    @property
    def refusals(self) -> dict[str, str]:
        """Why the last goal of a group was not taken, or ended badly, by its name; "" where it was not."""
        return {name: goals.refusal for name, goals in self._goals.items()}

    def ready(self, name: str) -> bool:
        """Whether the group ``name`` can be sent its next goal."""
        return name not in self._queued and self._goals[name].ready

    def publish(self, name: str, positions: tuple[float, ...]) -> None:
        """Send the joints of the group ``name``, which is ready, to ``positions`` (rad, m), in its order."""
        self._queued.add(name)
        self._run(partial(self._pursue, name, positions))

    def halt(self, name: str) -> None:
        """Cancel what the group ``name`` was sent."""
        if self._goals[name].pursued:
            self._run(self._goals[name].halt)

    def look(self) -> list[str]:
        """See who serves; sentences for people."""
        for name, action in self._names.items():
            present = self._clients[name].server_is_ready()
            self._goals[name].look(present)
            self.faults[name] = "" if present else self._missing(action)
        sentences, self._sentences[:] = list(self._sentences), []
        return sentences

    def end(self) -> bool:
        """Cancel all; whether something was."""
        ended = [goals for goals in self._goals.values() if goals.pursued]
        for goals in ended:
            goals.halt()
        return bool(ended)

    def _pursue(self, name: str, positions: tuple[float, ...]) -> None:
        self._goals[name].pursue(positions)
        self._queued.discard(name)

    def _missing(self, action: str) -> str:
        kinds = dict(self._node.get_service_names_and_types()).get(f"{action}/_action/send_goal", [])
        others = sorted(kind.removesuffix("_SendGoal") for kind in kinds if kind != _SEND)
        if others:
            return f"{action} has the type {', '.join(others)}; the mapping's is {FOLLOW}"
        return f"nothing serves the action {action}: commands do not reach the robot"

    def _send(self, name: str, positions: tuple[float, ...]) -> Any:
        goal = blank(f"{FOLLOW}_Goal")
        goal.trajectory = trajectory(self._joints[name], np.array(positions, np.float64), self._topics[name].hz)
        return self._clients[name].send_goal_async(goal)
