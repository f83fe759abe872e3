"""The node: subscriptions to the robot's topics, the publisher of its commands, and what the graph says of both.

rclpy's executor runs in a thread of its own (:meth:`RosNode.run`), so that the guard waits for no callback. What that
thread hands over are whole values; nothing else of it is read from outside.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
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

from app.base.errors import ConfigError
from app.base.joint_buffer import JointBuffer
from app.base.kinematic_model import KinematicModel
from app.logs.importers.ros_messages import Unreadable
from app.logs.importers.ros_stream import add_transforms
from app.logs.importers.transforms import Transforms
from app.logs.ros.live.classes import Unsupported, message_class
from app.messages import JointState as Joints
from app.messages import Odometry
from app.robots.guard import BaseVelocity
from app.robots.ros2 import qos
from app.robots.ros2.camera import CameraReader, setting
from app.robots.ros2.config import INFO, TRANSFORMS, TWIST_STAMPED, Ros2Config
from app.robots.ros2.frame_tree import differences
from app.robots.ros2.health import Seen, began_again
from app.robots.ros2.joint_actions import JointActions
from app.robots.ros2.joint_commands import JointCommands
from app.robots.ros2.messages import TransformOdometry, converters, seconds, set_stamp, stamp_of
from app.robots.ros2.stamps import StampClock, WrongClock

CLASSES: dict[str, Any] = {
    f"{package}/msg/{each.__name__}": each
    for package, classes in (
        ("nav_msgs", (RosOdometry,)),
        ("sensor_msgs", (BatteryState, CameraInfo, CompressedImage, Image, Imu, JointState, LaserScan)),
    )
    for each in classes
}
CLOCK = "clock"
LOOK_S = 0.5
"""How often the graph is asked who publishes and who listens."""
_SPIN_S = 0.05
#: So often, at the end, for an answer to a goal that is to be cancelled.
_LAST_SPINS = 3
_SILENT_S = 5.0
"""How long a topic that is wanted may be without a publisher before that is said."""
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


class RosNode:
    """A node of the robot's graph, with the streams of ``config`` that are ``wanted``.

    ``offset`` (s) makes the robot's clock of ``time.monotonic()``. ``arrived`` gets (stream, message), after which
    ``wake`` is called, from the node's thread. ``void`` says why what was built on the odometry is void, "" while it
    is not; ``cautions`` are sentences for people.
    """

    def __init__(self, config: Ros2Config, model: KinematicModel, offset: float, wake: Callable[[], None]) -> None:
        self._config = config
        self._offset = offset
        self._wake = wake
        self.arrived: deque[tuple[str, object]] = deque(maxlen=256)
        self.cautions: deque[str] = deque(maxlen=64)
        self.void = ""
        self.failure: BaseException | None = None
        places = {name: (sensor.link, model.pose(sensor.link)) for name, sensor in config.fixed_sensors.items()}
        self._joints = JointBuffer()
        cameras = {name: CameraReader(setting(camera), model, self._joints) for name, camera in config.cameras.items()}
        moved = config.streams.odometry
        self._transforms = TransformOdometry(moved.frame, moved.child) if moved.is_transform else None
        self._convert = converters(places, cameras, self._transforms)
        self._model, self._frames = model, Transforms()
        self._clock = StampClock(config.graph.clock, config.graph.clock_tolerance_s)
        self._required = config.limits.required_sensors
        self.wanted: frozenset[str] = frozenset()
        self._readings = {
            name: _Reading(topic, kind, class_of(kind)) for name, (topic, kind) in config.readings.items()
        }
        if config.graph.clock == "sim":
            self._required = (CLOCK, *self._required)
            self._readings[CLOCK] = _Reading("/clock", "rosgraph_msgs/msg/Clock", Clock)
        self._seen = {name: Seen(name, reading.topic) for name, reading in self._readings.items()}
        self._mistyped: dict[str, str] = {}
        self._odometry: Odometry | None = None
        self._commands = Seen("base", config.full_name(config.base.topic))
        self._offered = qos.writer(())
        self._publishing = threading.Lock()
        self._said: set[str] = set()
        self._looked = -math.inf
        self._began = time.monotonic()
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
        """Begin to listen."""
        self._thread.start()

    @property
    def required(self) -> tuple[Seen, ...]:
        """What is known now of what driving requires."""
        return tuple(self._with_type(name) for name in self._required)

    @property
    def commands(self) -> Seen:
        """What is known of the topic for commands."""
        return self._commands

    @property
    def mistake(self) -> ConfigError | None:
        """What the mapping says of a topic's type that is otherwise in the graph; None where nothing is."""
        if self._commands.problem:
            return self._config.mistake(f"{self._commands.topic} {self._commands.problem}", "base", "type")
        for name, problem in self._mistyped.items():
            if problem and name != CLOCK:
                stream, _, part = name.partition(".")
                return self._config.mistake(f"{self._seen[name].topic} {problem}", "streams", stream, part or "topic")
        return None

    @property
    def joints(self) -> Seen:
        """What is known of the topic of the joints, which the mapping has."""
        return self._with_type("joints")

    def topics(self) -> list[str]:
        """The topics that others publish or listen to."""
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
        """Send ``velocity`` to the base."""
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
        """Wait a moment until what was sent has arrived, then leave the graph."""
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
            stream = name.partition(".")[0]
            wanted = stream in self.wanted or stream in self._required or name in ("odometry", "joints")
            if wanted and reading.entity is None:
                self._subscribe(name, reading, reading.asked or qos.reader(()))
            elif not wanted and reading.entity is not None:
                self._node.destroy_subscription(reading.entity)
                reading.entity = None

    def _subscribe(self, name: str, reading: _Reading, asked: qos.Qos) -> None:
        if reading.entity is not None:
            self._node.destroy_subscription(reading.entity)
        reading.asked = asked
        take = self._tick if name == CLOCK else lambda message: self._take(name, message)
        reading.entity = self._node.create_subscription(
            reading.message_class, reading.topic, take, profile(asked, _DEPTH)
        )

    def _look(self) -> None:
        """See who publishes and who listens; ask for and offer what the others can take."""
        for name, reading in self._readings.items():
            infos = self._node.get_publishers_info_by_topic(reading.topic)
            ours = [info for info in infos if info.topic_type == reading.type]
            self._mistyped[name] = _other_type(infos, ours, reading.type)
            self._seen[name] = replace(self._seen[name], others=len(ours))
            asked = qos.reader(offered_by(info) for info in ours)
            if ours and asked != reading.asked and reading.entity is not None:
                self._subscribe(name, reading, asked)
            if not infos and reading.entity is not None and time.monotonic() - self._began > _SILENT_S:
                self._caution(f"{name}: {reading.topic} has no publisher")
        for sentence in (*self.joint_commands.look(), *self.joint_actions.look()):
            self._caution(sentence)
        self._look_at_commands()

    def _look_at_commands(self) -> None:
        topic, kind = self._commands.topic, self._config.base.type
        infos = self._node.get_subscriptions_info_by_topic(topic)
        ours = [info for info in infos if info.topic_type == kind]
        problem = _other_type(infos, ours, kind)
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
        self._node.create_subscription(kind, self._config.full_name("tf_static"), self._take_static, asked)

    def _take_static(self, message: Any) -> None:
        add_transforms(self._frames, message.read(), 0.0, static=True)
        sensors = (*self._config.cameras.values(), *self._config.fixed_sensors.values())
        links = [sensor.link for sensor in sensors]
        for sentence in differences(self._frames, self._model, links):
            self._caution(sentence, sentence.partition(":")[0])

    def _tick(self, message: Any) -> None:
        now = self._now()
        if not self._clock.tick(seconds(message.clock), now):
            self.void = "The robot's simulated time went back: what was built on its odometry is void."
        self._seen[CLOCK] = replace(self._seen[CLOCK], last=now)

    def _take(self, name: str, message: Any) -> None:
        now = self._now()
        if name == "odometry" and self._transforms is not None:
            message = self._transforms.pick(message.read())
            if message is None:
                return
        try:
            # A calibration holds whenever it was made.
            at = now if name.endswith(f".{INFO}") else self._clock.placed(stamp_of(message), now)
            taken = self._convert[name](message, at)
        except (WrongClock, Unreadable) as failure:
            self._seen[name] = replace(self._seen[name], problem=str(failure))
            self._caution(f"{name} ({self._seen[name].topic}): {failure}", f"{name}: {type(failure).__name__}")
            return
        if isinstance(taken, Odometry):
            if began_again(self._odometry, taken, self._config.limits.base()):
                self.void = "The robot's odometry jumped: it began again, and what was built on it is void."
            self._odometry = taken
        elif isinstance(taken, Joints):
            self._joints.add(taken.stamp, dict(zip(taken.names, taken.positions, strict=True)))
        self._seen[name] = replace(self._seen[name], last=now, problem="")
        if taken is not None:
            self.arrived.append((name.partition(".")[0], taken))
            self._wake()

    def _with_type(self, name: str) -> Seen:
        seen = self._seen[name]
        return replace(seen, problem=self._mistyped.get(name) or seen.problem)

    def _caution(self, sentence: str, once: str = "") -> None:
        if (once or sentence) not in self._said:
            self._said.add(once or sentence)
            self.cautions.append(sentence)
            self._wake()

    def _now(self) -> float:
        return time.monotonic() + self._offset


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


def _other_type(infos: Iterable[Any], ours: list[Any], kind: str) -> str:
    """What is wrong where all who are on a topic have another type than ``kind``."""
    others = sorted({info.topic_type for info in infos})
    return f"has the type {', '.join(others)}; the mapping reads or writes {kind}" if others and not ours else ""
