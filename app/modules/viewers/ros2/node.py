"""The node by which the program is in the graph: publishers, and services whose answers the program gives."""

from __future__ import annotations

import importlib
import itertools
import threading
import time
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from app.logs.ros import typestore
from app.logs.ros.live.classes import Unsupported, message_class, service_class
from app.modules.viewers.ros2.protocol import Call, Open, Ready, Service, Shown, encode

LOOK_S = 0.2
"""How often it is looked who listens."""
_DEPTH = 10
FAST_DDS = "rmw_fastrtps_cpp"


class GraphNode:
    """The node that offers what ``open`` says. ``send`` takes frames for the program, also from rclpy's thread."""

    def __init__(self, open: Open, send: Callable[[bytes], object]) -> None:
        self._link = send
        self._sending = threading.Lock()
        self._left_out: list[tuple[str, str]] = []
        for name, text in open.definitions:
            typestore.add(name, text)
        # No log files in the person's home; no services of parameters, for it has none.
        arguments = ["--ros-args", "--disable-external-lib-logs"]
        rclpy.init(args=arguments, domain_id=open.domain, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node(open.node, enable_rosout=False, start_parameter_services=False)
        self._publishers = [self._publisher(topic.name, topic.type, latched=topic.latched) for topic in open.topics]
        self._readers = [0] * len(self._publishers)
        self._looked = 0.0
        self._executor = SingleThreadedExecutor()
        self._numbers = itertools.count()
        #: Calls that wait for the program's answer: the future, and the class of the response.
        self._waiting: dict[int, tuple[Any, Any]] = {}
        for number, service in enumerate(open.services):
            self._serve(number, service)
        self._executor.add_node(self._node)
        threading.Thread(target=self._executor.spin, name="rclpy", daemon=True).start()

    @property
    def ready(self) -> Ready:
        """What to say once all is offered."""
        return Ready(tuple(self._left_out))

    def publish(self, topic: int, data: bytes) -> None:
        """Publish CDR on a topic."""
        publisher = self._publishers[topic]
        if publisher is not None:
            publisher.publish(data)

    def answer(self, call: int, data: bytes) -> None:
        """Give the answer to a call."""
        future, response = self._waiting.pop(call)
        future.set_result(response(data))
        self._executor.wake()  # it waits for messages, not for futures

    def look(self) -> float:
        """Say who listens, if it is time; the time until the next look (s)."""
        now = time.monotonic()
        if now - self._looked >= LOOK_S:
            self._looked = now
            for topic, publisher in enumerate(self._publishers):
                readers = 0 if publisher is None else publisher.get_subscription_count()
                if readers != self._readers[topic]:
                    self._readers[topic] = readers
                    self._send(encode(Shown(topic, readers)))
        return max(self._looked + LOOK_S - now, 0.0)

    def _send(self, frame: bytes) -> None:
        with self._sending:
            self._link(frame)

    def _publisher(self, name: str, kind: str, *, latched: bool) -> Any:
        offered = QoSProfile(
            history=HistoryPolicy.KEEP_LAST,
            depth=1 if latched else _DEPTH,
            reliability=ReliabilityPolicy.RELIABLE,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
        try:
            return self._node.create_publisher(_class(kind), name, offered)
        except Unsupported as failure:
            self._left_out.append((name, str(failure)))
            return None

    def _serve(self, number: int, service: Service) -> None:
        try:
            _only_fast_dds()
            made = service_class(service.type, service.request, service.response)
        except Unsupported as failure:
            self._left_out.append((service.name, str(failure)))
            return

        async def called(request: Any, response: Any) -> Any:
            call, future = next(self._numbers), Future(executor=self._executor)
            self._waiting[call] = (future, type(response))
            self._send(encode(Call(call, number, request.cdr)))
            return await future

        self._node.create_service(made, service.name, called)


def _class(kind: str) -> Any:
    """The class of a message type: that of its package where one is installed, else a made one. Raises Unsupported."""
    package, folder, short = kind.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.{folder}"), short)
    except ImportError:
        _only_fast_dds()
        return message_class(kind)


def _only_fast_dds() -> None:
    if (here := rclpy.get_rmw_implementation_identifier()) != FAST_DDS:
        raise Unsupported(f"it is offered over {FAST_DDS} alone, and this is {here}")
