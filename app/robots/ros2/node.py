"""The node over ROS 2's own rclpy: subscriptions to the robot's topics, the publisher of its commands, and what the
graph says of both. rclpy's executor runs in a thread of its own.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry as RosOdometry
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState, CameraInfo, CompressedImage, Image, Imu, JointState, LaserScan

from app.base.kinematic_model import KinematicModel
from app.logs.ros.live.classes import Unsupported, message_class
from app.robots.guard import BaseVelocity
from app.robots.ros2 import qos
from app.robots.ros2.body_node import LOOK_S, SILENT_S, BodyNode, other_type
from app.robots.ros2.config import CLOCK, TRANSFORMS, TWIST_STAMPED, Ros2Config
from app.robots.ros2.joint_actions import JointActions
from app.robots.ros2.joint_commands import JointCommands
from app.robots.ros2.messages import set_stamp

CLASSES: dict[str, Any] = {
    f"{package}/msg/{each.__name__}": each
    for package, classes in (
        ("nav_msgs", (RosOdometry,)),
        ("sensor_msgs", (BatteryState, CameraInfo, CompressedImage, Image, Imu, JointState, LaserScan)),
    )
    for each in classes
}
_SPIN_S = 0.05
#: So often, at the end, for an answer to a goal that is to be cancelled.
_LAST_SPINS = 3
_ACKNOWLEDGED_S = 0.2
_DEPTH = 5
#: Depth of the topic for commands: an older one is worth nothing.
_NEWEST = 1


@dataclass(slots=True)
class _Reading:
    """A subscription; ``entity`` is rclpy's, ``asked`` its quality of service."""

    topic: str
    type: str
    message_class: Any
    entity: Any = None
    asked: qos.Qos | None = None


class RosNode(BodyNode):
    """The node over rclpy; see :class:`app.robots.ros2.body_node.BodyNode`. Raises Unsupported for types that are not
    among ROS 2's wheels, where the middleware is another than Fast DDS."""

    joint_commands: JointCommands
    joint_actions: JointActions

    def __init__(self, config: Ros2Config, model: KinematicModel, offset: float, wake: Callable[[], None]) -> None:
        super().__init__(config, model, offset, wake)
        self._readings = {
            name: _Reading(topic, kind, Clock if name == CLOCK else class_of(kind))
            for name, (topic, kind) in config.subscriptions.items()
        }
        self._offered = qos.writer(())
        self._publishing = threading.Lock()
        self._looked = -math.inf
        self._ending = False
        # No log files in the person's home; no services of parameters, which this node does not need.
        arguments = ["--ros-args", "--disable-external-lib-logs"]
        # Signals are the process's own: rclpy's handlers would close the writer before its last word.
        rclpy.init(args=arguments, domain_id=config.graph.domain, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node("hbba", enable_rosout=False, start_parameter_services=False)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._writer: Any = self._create_writer()
        self.joint_commands = JointCommands(self._node, config)
        self.joint_actions = JointActions(self._node, config, self._executor.create_task)
        self._follow_static_transforms()
        self._thread = threading.Thread(target=self._run, name="rclpy", daemon=True)

    # The guard's side

    def start(self) -> None:
        self._thread.start()

    def topics(self) -> list[str]:
        names = dict(self._node.get_topic_names_and_types())
        asked = {self._commands.topic, self._config.full_name("tf_static"), "/parameter_events"}
        own = {reading.topic for reading in self._readings.values()} | asked
        mine = self._node.get_name()
        return sorted(
            name
            for name in names
            if name not in own or any(info.node_name != mine for info in self._node.get_publishers_info_by_topic(name))
        )

    def publish(self, velocity: BaseVelocity, now: float) -> None:
        stamped = TwistStamped()
        twist = stamped.twist
        twist.linear.x, twist.linear.y, twist.angular.z = (
            velocity.linear_mps, velocity.lateral_mps, velocity.angular_radps,
        )  # fmt: skip
        if self._config.base.type == TWIST_STAMPED:
            stamped.header.frame_id = self._config.base.frame
            set_stamp(stamped.header, self._clock.outgoing(now))
        with self._publishing:
            self._writer.publish(stamped if self._config.base.type == TWIST_STAMPED else twist)

    def close(self) -> None:
        self._ending = True
        with self._publishing:
            self._writer.wait_for_all_acked(Duration(seconds=_ACKNOWLEDGED_S))
        self._executor.wake()
        self._thread.join(timeout=4 * _SPIN_S)

    # rclpy's thread

    def _run(self) -> None:
        try:
            while not self._ending:
                if time.monotonic() - self._looked >= LOOK_S:
                    self._look()
                    self._looked = time.monotonic()
                self._follow_demand()
                self._executor.spin_once(timeout_sec=_SPIN_S)
            for _ in range(_LAST_SPINS):
                if not self.joint_actions.end():
                    break
                self._executor.spin_once(timeout_sec=_SPIN_S)
        except Exception as failure:  # noqa: BLE001  # the guard's thread raises it
            self.failure = failure
            self._wake()

    def _follow_demand(self) -> None:
        for name, reading in self._readings.items():
            wanted = self._is_wanted(name)
            if wanted and reading.entity is None:
                self._subscribe(name, reading, reading.asked or qos.reader(()))
            elif not wanted and reading.entity is not None:
                self._node.destroy_subscription(reading.entity)
                reading.entity = None

    def _subscribe(self, name: str, reading: _Reading, asked: qos.Qos) -> None:
        if reading.entity is not None:
            self._node.destroy_subscription(reading.entity)
        reading.asked = asked

        def take(message: Any) -> None:
            self._take(name, message.read() if reading.type == TRANSFORMS else message)

        reading.entity = self._node.create_subscription(
            reading.message_class, reading.topic, take, profile(asked, _DEPTH)
        )

    def _look(self) -> None:
        """See who publishes and who listens; ask for and offer what the others can take."""
        for name, reading in self._readings.items():
            infos = self._node.get_publishers_info_by_topic(reading.topic)
            ours = [info for info in infos if info.topic_type == reading.type]
            self._mistyped[name] = other_type([info.topic_type for info in infos], reading.type)
            self._seen[name] = replace(self._seen[name], others=len(ours))
            asked = qos.reader(offered_by(info) for info in ours)
            if ours and asked != reading.asked and reading.entity is not None:
                self._subscribe(name, reading, asked)
            if not infos and reading.entity is not None and time.monotonic() - self._began > SILENT_S:
                self._caution(f"{name}: {reading.topic} has no publisher")
        for sentence in (*self.joint_commands.look(), *self.joint_actions.look()):
            self._caution(sentence)
        self._look_at_commands()

    def _look_at_commands(self) -> None:
        topic, kind = self._commands.topic, self._config.base.type
        infos = self._node.get_subscriptions_info_by_topic(topic)
        ours = [info for info in infos if info.topic_type == kind]
        problem = other_type([info.topic_type for info in infos], kind)
        self._commands = replace(self._commands, problem=problem, others=len(ours))
        offered = qos.writer(offered_by(info) for info in ours)
        if ours and offered != self._offered:
            self._offered = offered
            with self._publishing:
                self._node.destroy_publisher(self._writer)
                self._writer = self._create_writer()
        rivals = {info.node_name for info in self._node.get_publishers_info_by_topic(topic)} - {self._node.get_name()}
        if rivals:
            self._caution(f"{', '.join(sorted(rivals))} can publish on {topic}, too: past this program's guard")

    def _create_writer(self) -> Any:
        kind = TwistStamped if self._config.base.type == TWIST_STAMPED else Twist
        offer = profile(self._offered, _NEWEST)
        if self._config.graph.clock == "header":
            # The two clocks agree within the tolerance: what waits longer, as in a frozen robot's socket, is not taken.
            limits = self._config.limits
            offer.lifespan = Duration(seconds=limits.command_timeout_s + self._config.graph.clock_tolerance_s)
        return self._node.create_publisher(kind, self._commands.topic, offer)

    def _follow_static_transforms(self) -> None:
        """Hold the model against what the robot says of its sensors' places."""
        try:
            kind = message_class(TRANSFORMS)
        except Unsupported:
            return
        asked = profile(qos.Qos(reliable=True, transient_local=True), 100)

        def take(message: Any) -> None:
            self._take_static(message.read())

        self._node.create_subscription(kind, self._config.full_name("tf_static"), take, asked)


def class_of(kind: str) -> Any:
    """rclpy's class of a type that is read. Raises Unsupported for one that is not among ROS 2's wheels, where the
    middleware is another."""
    return CLASSES.get(kind) or message_class(kind)


def profile(wanted: qos.Qos, depth: int) -> QoSProfile:
    """rclpy's profile of ``wanted``, which keeps the last ``depth`` messages."""
    deadline = {} if wanted.deadline_s is None else {"deadline": Duration(seconds=wanted.deadline_s)}
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if wanted.reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if wanted.transient_local else DurabilityPolicy.VOLATILE,
        **deadline,
    )


def offered_by(info: Any) -> qos.Qos:
    """What an endpoint (rclpy's TopicEndpointInfo) offers or asks for."""
    offered = info.qos_profile
    deadline_s = offered.deadline.nanoseconds / 1e9
    return qos.Qos(
        reliable=offered.reliability == ReliabilityPolicy.RELIABLE,
        transient_local=offered.durability == DurabilityPolicy.TRANSIENT_LOCAL,
        # Without a deadline the middleware says 0, or the longest time that it can.
        deadline_s=deadline_s if 0 < deadline_s < 1e8 else None,
    )
