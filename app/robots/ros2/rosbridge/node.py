"""The node over rosbridge's WebSocket (protocol v2.0): subscriptions to the robot's topics, its commands, and what
rosapi says of the graph. Its event loop runs in a thread of its own.

There are two connections. By the first go commands, and all but pictures: they wait behind nothing large, and behind
no service, for rosbridge works off what one connection asks in turn. By the second go pictures, and the questions to
rosapi.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from app.base.kinematic_model import KinematicModel
from app.logs.importers.ros_messages import Unreadable
from app.robots.guard import BaseVelocity
from app.robots.ros2.body_node import LOOK_S, SILENT_S, BodyNode, other_type
from app.robots.ros2.config import TWIST_STAMPED, Ros2Config
from app.robots.ros2.health import Seen
from app.robots.ros2.rosbridge.connection import PING_S, Connection
from app.robots.ros2.rosbridge.joints import JointTopics, NoActions
from app.robots.ros2.rosbridge.rosapi import ASK_S, Rosapi
from app.robots.ros2.rosbridge.subscription import STATIC, Subscription, subscriptions
from app.robots.ros2.rosbridge.twist import twist_message
from app.robots.ros2.rosbridge.values import from_message, plain_name, same_type, to_message

ANSWER_S = PING_S + 1.0
"""An answer that is older is late behind other messages, as commands would be: the base stops."""
_MOST_BYTES, _MOST_PICTURE_BYTES = 4 << 20, 48 << 20
_ARRIVED_S = 0.2
#: rosbridge drops what waits in a connection that closes, and no answer says that it waits no more.
_WORKED_OFF_S = 0.1


class RosbridgeNode(BodyNode):
    """The node at ``config.graph.rosbridge``; see :class:`app.robots.ros2.body_node.BodyNode`."""

    def __init__(self, config: Ros2Config, model: KinematicModel, offset: float, wake: Callable[[], None]) -> None:
        super().__init__(config, model, offset, wake)
        url = config.graph.rosbridge
        assert url is not None  # by which this node was chosen
        self._url = url
        self._subscriptions = subscriptions(config)
        # Who publishes is asked of what is silent alone.
        self._seen = {name: replace(seen, others=None) for name, seen in self._seen.items()}
        self._control = Connection(
            url, _MOST_BYTES, opened=self._opened, take=self._take_control, say=self._say_unreadable
        )
        self._pictures = Connection(
            url, _MOST_PICTURE_BYTES, opened=self._pictures_opened, take=self._take_other, say=self._say_unreadable
        )
        self._rosapi = Rosapi(self._pictures.send)
        self.joint_commands = self._joint_topics = JointTopics(config, self._send_joints)
        self.joint_actions = NoActions()
        #: Whether the names of types are those of ROS 1; None while that is unknown.
        self._is_ros1: bool | None = None
        #: The types by topic, as rosapi says.
        self._types: dict[str, str] = {}
        #: Whether it is known who listens, or cannot be.
        self._has_looked = False
        self._timeout_s = config.limits.sensor_timeout_s
        self._loop = asyncio.new_event_loop()
        self._ending = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name="rosbridge", daemon=True)

    # The guard's side

    def start(self) -> None:
        self._thread.start()

    def want(self, streams: frozenset[str]) -> None:
        super().want(streams)
        self._post(self._follow_demand)

    @property
    def required(self) -> tuple[Seen, ...]:
        first, *others = super().required
        return (replace(first, problem=self._silence() or first.problem), *others)

    @property
    def commands(self) -> Seen:
        if self._silence():  # which is said of what is required already
            return replace(self._commands, problem="", others=1)
        problem = self._commands.problem
        if not (problem or self._has_looked):
            problem = self._pictures.problem or "rosapi has not said yet who listens"
        return replace(self._commands, problem=problem)

    def topics(self) -> list[str]:
        return sorted(self._types)

    def publish(self, velocity: BaseVelocity, now: float) -> None:
        base = self._config.base
        frame = base.frame if base.type == TWIST_STAMPED else None
        message = twist_message(velocity, frame, self._clock.outgoing(now), ros1=bool(self._is_ros1))
        self._post(self._publish, self._commands.topic, message)

    def close(self) -> None:
        self._post(self._ending.set)
        self._thread.join(timeout=1.0)

    def _silence(self) -> str:
        """Why nothing can be known of the robot now; "" while it can."""
        if self._control.problem:
            return self._control.problem
        now = time.monotonic()
        if now - self._control.heard <= self._timeout_s and now - self._control.answered <= ANSWER_S:
            return ""
        return f"rosbridge at {self._url} does not answer"

    def _post(self, function: Callable[..., None], *arguments: object) -> None:
        with contextlib.suppress(RuntimeError):  # the loop is closed: the thread ended, and says why
            self._loop.call_soon_threadsafe(function, *arguments)

    # The node's thread

    def _run(self) -> None:
        try:
            with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
                runner.run(self._hold())
        except Exception as failure:  # noqa: BLE001  # the guard's thread raises it
            self.failure = failure
            self._wake()

    async def _hold(self) -> None:
        ending = asyncio.create_task(self._ending.wait())
        parts = (self._control.run(), self._pictures.run(), self._look_always(), self._follow_always())
        tasks = [asyncio.create_task(part) for part in parts]
        try:
            done, _ = await asyncio.wait([ending, *tasks], return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
            await self._control.flush(_ARRIVED_S)
            await asyncio.sleep(_WORKED_OFF_S)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    def _opened(self) -> None:
        self._advertise()
        self._subscribe_all(self._control)

    def _pictures_opened(self) -> None:
        self._subscribe_all(self._pictures)

    def _advertise(self) -> None:
        topics = {self._commands.topic: self._config.base.type} | self._joint_topics.types
        for topic, kind in topics.items():
            named = plain_name(kind) if self._is_ros1 else kind
            # Of commands that wait there, older ones are worth nothing.
            self._control.send(
                {"op": "advertise", "id": f"advertise {topic}", "topic": topic, "type": named, "queue_size": 1}
            )

    def _subscribe_all(self, connection: Connection) -> None:
        for subscription in self._subscriptions.values():
            if self._connection(subscription) is connection:
                subscription.asked = None
        self._follow_demand()

    def _connection(self, subscription: Subscription) -> Connection:
        return self._pictures if subscription.is_picture else self._control

    async def _follow_always(self) -> None:
        while True:
            self._follow_demand()
            await asyncio.sleep(LOOK_S)

    def _follow_demand(self) -> None:
        """Subscribe to what is wanted, again to what stays silent: rosbridge drops one whose topic is not there yet."""
        now = time.monotonic()
        for name, subscription in self._subscriptions.items():
            connection = self._connection(subscription)
            if connection.problem:
                continue
            if not (name == STATIC or self._is_wanted(name)):
                if subscription.asked is not None:
                    connection.send(subscription.unsubscription())
                    subscription.asked = None
            elif subscription.asked is None or subscription.is_due(now):
                if subscription.asked is not None:
                    connection.send(subscription.unsubscription())
                connection.send(subscription.asking(now, self._is_ros1))

    def _take_control(self, message: dict[str, Any]) -> None:
        match message.get("op"):
            case "publish":
                self._take_published(message.get("topic"), message.get("msg"))
            case "status":
                self._take_status(message)
            case "fragment":
                self._caution(
                    f"rosbridge at {self._url} sends large messages in fragments, which are not read: choose "
                    "compressed pictures"
                )

    def _take_other(self, message: dict[str, Any]) -> None:
        if message.get("op") == "service_response":
            self._rosapi.take(message)
        else:
            self._take_control(message)

    def _take_published(self, topic: object, value: object) -> None:
        now = time.monotonic()
        for name, subscription in self._subscriptions.items():
            if subscription.topic != topic or subscription.asked is None:
                continue
            subscription.came(now)
            try:
                message = to_message(subscription.type, value)
            except Unreadable as failure:
                if name == STATIC:
                    self._caution(f"{topic}: {failure}", STATIC)
                else:
                    self._unusable(name, failure)
                continue
            if name == STATIC:
                self._take_static(message)
            else:
                self._seen[name] = replace(self._seen[name], others=None)
                self._take(name, message)

    def _take_status(self, message: dict[str, Any]) -> None:
        if any(each.id == message.get("id") and not each.has_type for each in self._subscriptions.values()):
            return  # the topic is not there yet
        if message.get("level") == "error" and isinstance(said := message.get("msg"), str):
            self._caution(f"rosbridge at {self._url}: {said[:300]}")

    def _say_unreadable(self, sentence: str) -> None:
        self._caution(sentence, "unreadable")

    def _publish(self, topic: str, message: dict[str, Any]) -> None:
        self._control.send({"op": "publish", "topic": topic, "msg": message}, topic)

    def _send_joints(self, topic: str, kind: str, message: Any) -> None:
        """Of the guard's thread."""
        self._post(self._publish, topic, from_message(kind, message, ros1=bool(self._is_ros1)))

    # What rosapi says

    async def _look_always(self) -> None:
        while True:
            if not self._pictures.problem:
                await self._look()
            await asyncio.sleep(LOOK_S)

    async def _look(self) -> None:
        types = await self._rosapi.types()
        if types is not None:
            self._take_types(types)
        await self._look_at_commands()
        now = time.monotonic()
        for name, subscription in self._subscriptions.items():
            if name == STATIC or subscription.asked is None or not subscription.is_silent(now):
                continue
            if (nodes := await self._rosapi.publishers(subscription.topic)) is not None:
                self._seen[name] = replace(self._seen[name], others=len(nodes))
                if not nodes and now - self._began > SILENT_S:
                    self._caution(f"{name}: {subscription.topic} has no publisher")

    def _take_types(self, types: dict[str, str]) -> None:
        self._types = types
        is_ros1 = all(kind.count("/") < 2 for kind in types.values()) if types else None
        if is_ros1 is not None and is_ros1 is not self._is_ros1:
            self._is_ros1 = is_ros1
            if not self._control.problem:
                self._advertise()
            for subscription in self._subscriptions.values():
                subscription.hurry()
            self._follow_demand()
        for name, subscription in self._subscriptions.items():
            if name != STATIC:
                self._mistyped[name] = self._other_type(subscription.topic, subscription.type)

    async def _look_at_commands(self) -> None:
        topics = {self._commands.topic: self._config.base.type} | self._joint_topics.types
        for topic, kind in topics.items():
            listeners = await self._rosapi.subscribers(topic)
            if listeners is None:
                if self._pictures.problem or self._has_looked:
                    return  # what was said last holds
                self._caution(
                    f"rosapi does not answer at {self._url} within {ASK_S:g} s: who listens to {topic}, and by which "
                    "type, is not known"
                )
            found = 1 if listeners is None else len(listeners)
            problem = self._other_type(topic, kind)
            if topic == self._commands.topic:
                self._commands = replace(self._commands, problem=problem, others=found)
            else:
                self._joint_topics.note(topic, found, problem)
            rivals = await self._rosapi.publishers(topic) if listeners is not None else None
            if rivals:
                self._caution(f"{', '.join(sorted(rivals))} can publish on {topic}, too: past this program's guard")
        self._has_looked = True

    def _other_type(self, topic: str, kind: str) -> str:
        return other_type([found] if (found := self._types.get(topic)) else [], kind, same_type)
