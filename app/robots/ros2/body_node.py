"""What every node of a robot's graph shares, whatever it hears the robot by: what was seen, when, and what it was made
into. There are two: :class:`app.robots.ros2.node.RosNode` and :class:`app.robots.ros2.rosbridge.node.RosbridgeNode`.

A node listens in a thread of its own, so that the guard waits for no message. What that thread gives are whole values;
nothing else of it is read from outside.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol

from app.base.errors import ConfigError
from app.base.joint_buffer import JointBuffer
from app.base.kinematic_model import KinematicModel
from app.logs.importers.ros_messages import Unreadable
from app.logs.importers.ros_stream import add_transforms
from app.logs.importers.transforms import Transforms
from app.messages import JointState, Odometry
from app.robots.guard import BaseVelocity
from app.robots.ros2.camera import CameraReader, setting
from app.robots.ros2.config import CLOCK, INFO, Ros2Config
from app.robots.ros2.frame_tree import differences
from app.robots.ros2.health import Seen, began_again
from app.robots.ros2.messages import TransformOdometry, converters, seconds, stamp_of
from app.robots.ros2.stamps import StampClock, WrongClock

LOOK_S = 0.5
"""How often the graph is asked who publishes and who listens."""
SILENT_S = 5.0
"""How long a topic that is wanted may be without a publisher before that is said."""
_SENTENCES = 256
"""So many different ones are said at most: what they quote may come from the robot."""


class JointWriters(Protocol):
    """The topics for set-points of the groups that have one."""

    @property
    def faults(self) -> dict[str, str]:
        """Why commands do not reach a group, by its name; "" where they do, as far as can be known."""

    def publish(self, name: str, positions: tuple[float, ...]) -> None:
        """Send the joints of the group ``name`` to ``positions`` (rad, m), in its order."""


class JointGoals(Protocol):
    """The actions of the groups that have one; names are those of groups."""

    @property
    def faults(self) -> dict[str, str]:
        """As of :class:`JointWriters`."""

    @property
    def refusals(self) -> dict[str, str]:
        """Why the last goal of a group was not taken, or ended badly; "" where it was not."""

    def __contains__(self, name: str) -> bool: ...

    def ready(self, name: str) -> bool:
        """Whether the group can be sent its next goal."""

    def publish(self, name: str, positions: tuple[float, ...]) -> None:
        """Send the joints of the group, which is ready, to ``positions`` (rad, m), in its order."""

    def halt(self, name: str) -> None:
        """Cancel what the group was sent."""


class BodyNode(ABC):
    """A node of the robot's graph, with the streams of ``config`` that are ``wanted``.

    ``offset`` (s) makes the robot's clock of ``time.monotonic()``. ``arrived`` gets (stream, message), after which
    ``wake`` is called, from the node's thread. ``void`` says why what was built on the odometry is void, "" while it
    is not; ``cautions`` are sentences for people; ``failure`` is an error of the node's thread, which the guard's
    raises.
    """

    joint_commands: JointWriters
    joint_actions: JointGoals

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
        if config.graph.clock == "sim":
            self._required = (CLOCK, *self._required)
        self.wanted: frozenset[str] = frozenset()
        self._seen = {name: Seen(name, topic) for name, (topic, _) in config.subscriptions.items()}
        self._mistyped: dict[str, str] = {}
        self._odometry: Odometry | None = None
        self._commands = Seen("base", config.full_name(config.base.topic))
        self._said: set[str] = set()
        self._began = time.monotonic()

    # The guard's side

    @abstractmethod
    def start(self) -> None:
        """Begin to listen."""

    @abstractmethod
    def topics(self) -> list[str]:
        """The topics that others publish or listen to, as far as is known."""

    @abstractmethod
    def publish(self, velocity: BaseVelocity, now: float) -> None:
        """Send ``velocity`` to the base."""

    @abstractmethod
    def close(self) -> None:
        """Wait a moment until what was sent has arrived, then leave the graph."""

    def want(self, streams: frozenset[str]) -> None:
        """Listen to what ``streams`` need, and to nothing else that is not needed anyway."""
        self.wanted = streams

    @property
    def required(self) -> tuple[Seen, ...]:
        """What is known now of what driving requires."""
        return tuple(self._with_type(name) for name in self._required)

    @property
    def commands(self) -> Seen:
        """What is known of the topic for commands."""
        return self._commands

    @property
    def joints(self) -> Seen:
        """What is known of the topic of the joints, which the mapping has."""
        return self._with_type("joints")

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

    # The node's thread

    def _is_wanted(self, name: str) -> bool:
        stream = name.partition(".")[0]
        return stream in self.wanted or stream in self._required or name in ("odometry", "joints")

    def _tick(self, message: Any) -> None:
        """Take a rosgraph_msgs/Clock."""
        now = self._now()
        if not self._clock.tick(seconds(message.clock), now):
            self.void = "The robot's simulated time went back: what was built on its odometry is void."
        self._seen[CLOCK] = replace(self._seen[CLOCK], last=now)

    def _take(self, name: str, message: Any) -> None:
        """Take what came by the subscription ``name``: a message of rclpy, or an object of rosbags."""
        if name == CLOCK:
            self._tick(message)
            return
        now = self._now()
        if name == "odometry" and self._transforms is not None:
            message = self._transforms.pick(message)
            if message is None:
                return
        try:
            # A calibration holds whenever it was made.
            at = now if name.endswith(f".{INFO}") else self._clock.placed(stamp_of(message), now)
            taken = self._convert[name](message, at)
        except (WrongClock, Unreadable) as failure:
            self._unusable(name, failure)
            return
        if isinstance(taken, Odometry):
            if began_again(self._odometry, taken, self._config.limits.base()):
                self.void = "The robot's odometry jumped: it began again, and what was built on it is void."
            self._odometry = taken
        elif isinstance(taken, JointState):
            self._joints.add(taken.stamp, dict(zip(taken.names, taken.positions, strict=True)))
        self._seen[name] = replace(self._seen[name], last=now, problem="")
        if taken is not None:
            self.arrived.append((name.partition(".")[0], taken))
            self._wake()

    def _unusable(self, name: str, failure: Exception) -> None:
        """Note why the newest message of ``name`` is not usable."""
        self._seen[name] = replace(self._seen[name], problem=str(failure))
        self._caution(f"{name} ({self._seen[name].topic}): {failure}", f"{name}: {type(failure).__name__}")

    def _take_static(self, message: Any) -> None:
        """Hold the model against what the robot says of its sensors' places, a tf2_msgs/TFMessage."""
        add_transforms(self._frames, message, 0.0, static=True)
        sensors = (*self._config.cameras.values(), *self._config.fixed_sensors.values())
        links = [sensor.link for sensor in sensors]
        for sentence in differences(self._frames, self._model, links):
            self._caution(sentence, sentence.partition(":")[0])

    def _with_type(self, name: str) -> Seen:
        seen = self._seen[name]
        return replace(seen, problem=self._mistyped.get(name) or seen.problem)

    def _caution(self, sentence: str, once: str = "") -> None:
        if (once or sentence) not in self._said and len(self._said) < _SENTENCES:
            self._said.add(once or sentence)
            self.cautions.append(sentence)
            self._wake()

    def _now(self) -> float:
        return time.monotonic() + self._offset


def other_type(kinds: list[str], wanted: str, same: Callable[[str, str], bool] = str.__eq__) -> str:
    """What is wrong where all of ``kinds``, the types on a topic, are others than ``wanted``; "" if nothing is."""
    if not kinds or any(same(kind, wanted) for kind in kinds):
        return ""
    return f"has the type {', '.join(sorted(set(kinds)))}; the mapping reads or writes {wanted}"
