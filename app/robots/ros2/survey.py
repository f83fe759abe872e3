"""What a live graph, or a bag, has: its topics, what comes on them and how often."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

from app.logs.importers.ros_messages import encoding_of, frame_of
from app.logs.importers.ros_open import DAMAGE, opened, words
from app.logs.importers.ros_stream import add_transforms, is_static
from app.logs.importers.ros_topics import TF_TYPES
from app.logs.importers.transforms import Transforms
from app.logs.log import LogError
from app.logs.mcap.decompression import TooMuch
from app.robots.ros2.config import COMPRESSED_IMAGE, IMAGE, TRANSFORMS, TWIST, TWIST_STAMPED, TYPES
from app.robots.ros2.messages import stamp_of
from app.robots.ros2.proposal import Topic

_LOOK_S = 0.25
"""How often the graph is looked at for topics that were not there before."""
_LONGEST = 4.0
"""So many times as long as asked for is listened while nothing has come of a stream, or no stream has appeared."""
_TRANSFORMS = 5000
"""So many messages of transforms are read of a bag: all frames are there by then."""
_LOOKED_INTO = frozenset((*TYPES.values(), IMAGE, COMPRESSED_IMAGE))


@dataclass(slots=True)
class _Heard:
    """What came on a topic: times of arrival (s), frame, and by how much the stamps were later."""

    arrivals: list[float] = field(default_factory=list)
    frame: str = ""
    holds: str = ""
    ahead_s: list[float] = field(default_factory=list)

    def take(self, message: Any) -> None:
        """Note a message with a header."""
        self.arrivals.append(time.monotonic())
        self.frame = frame_of(message)
        self.holds = self.holds or _holds(message)
        if (stamp := stamp_of(message)) is not None:
            self.ahead_s.append(stamp - time.time())

    @property
    def rate_hz(self) -> float | None:
        """Messages a second, None where there were fewer than two."""
        if len(self.arrivals) < 2:
            return None
        return (len(self.arrivals) - 1) / max(self.arrivals[-1] - self.arrivals[0], 1e-3)


@dataclass(frozen=True, slots=True)
class Found:
    """What a graph or a bag has: its topics, and the tree of its frames."""

    topics: list[Topic]
    frames: Transforms


def live(listen_s: float, domain: int | None) -> Found:
    """What the graph of ``domain`` (None: the environment's) has, listened to for ``listen_s`` seconds.

    While none of its topics has appeared that may be a stream of a robot, or nothing has come on one that has, it is
    listened to for longer, four times as long at most: a slow computer finds a graph late. Raises ImportError where
    there is no rclpy.
    """
    os.environ.setdefault("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    rclpy.init(args=["--ros-args", "--disable-external-lib-logs"], domain_id=domain)
    node = rclpy.create_node("hbba_survey", enable_rosout=False, start_parameter_services=False)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    ears = _Ears(node)
    try:
        began = time.monotonic()
        while (elapsed := time.monotonic() - began) < listen_s or not (ears.complete or elapsed > _LONGEST * listen_s):
            ears.find()
            _spin(executor, _LOOK_S)
        return ears.found()
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.shutdown()


class _Ears:
    """The subscriptions of ``node`` to all that it can read."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self._heard: dict[tuple[str, str], _Heard] = {}
        self._frames = Transforms()

    @property
    def complete(self) -> bool:
        """Whether there are streams, and something came on each."""
        streams = [came for (_, kind), came in self._heard.items() if kind in _LOOKED_INTO]
        return bool(streams) and all(came.arrivals for came in streams)

    def find(self) -> None:
        """Subscribe to the published topics that were not there before."""
        from app.robots.ros2.node import CLASSES, class_of, offered_by, profile
        from app.robots.ros2.qos import reader

        for name, kinds in self._node.get_topic_names_and_types():
            for kind in kinds:
                if (name, kind) in self._heard or (kind != TRANSFORMS and kind not in CLASSES):
                    continue
                publishers = self._node.get_publishers_info_by_topic(name)
                if kind not in [info.topic_type for info in publishers]:
                    continue
                came = self._heard[name, kind] = _Heard()
                take, depth = (_taker_of_frames(self._frames, name), 100) if kind == TRANSFORMS else (came.take, 10)
                asked = profile(reader(offered_by(info) for info in publishers), depth)
                self._node.create_subscription(class_of(kind), name, take, asked)

    def found(self) -> Found:
        """What there is by now."""
        topics, own = [], self._node.get_name()
        for name, kinds in self._node.get_topic_names_and_types():
            publishers = [info.topic_type for info in self._node.get_publishers_info_by_topic(name)]
            subscribers = [i.topic_type for i in self._node.get_subscriptions_info_by_topic(name) if i.node_name != own]
            for kind in kinds:
                topic = Topic(name, kind, publishers.count(kind), subscribers.count(kind))
                if (came := self._heard.get((name, kind), _Heard())).arrivals:
                    ahead_s = statistics.median(came.ahead_s) if came.ahead_s else None
                    topic = replace(topic, rate_hz=came.rate_hz, frame=came.frame, ahead_s=ahead_s, holds=came.holds)
                topics.append(topic)
        return Found([topic for topic in topics if topic.publishers or topic.subscribers], self._frames)


def _taker_of_frames(frames: Transforms, topic: str) -> Callable[[Any], None]:
    return lambda message: _take_frames(frames, message.read(), topic)


def _take_frames(frames: Transforms, message: Any, topic: str) -> None:
    add_transforms(frames, message, time.time(), static=is_static(topic))


def _holds(message: Any) -> str:
    """What a picture holds, "" for what is none."""
    return encoding_of(message) if hasattr(message, "encoding") or hasattr(message, "format") else ""


def _spin(executor: Any, seconds: float) -> None:
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0:
        executor.spin_once(timeout_sec=left)


def bag(path: Path) -> Found:
    """The topics of a bag, with their mean rates, and its frames.

    Of commands it only says that they were given: what it has is taken for listened to. Raises LogError where it
    cannot be read.
    """
    reader, others, unpacked = opened(path)
    try:
        seconds = max(reader.duration / 1e9, 1e-3)
        topics = []
        for name, info in sorted(reader.topics.items()):
            connections = [connection for connection in reader.connections if connection.topic == name]
            kind = info.msgtype or connections[0].msgtype
            frame = holds = ""
            if kind in _LOOKED_INTO and info.msgcount and (sample := next(reader.messages(connections), None)):
                message = reader.deserialize(sample[2], kind)
                frame, holds = frame_of(message), _holds(message)
            rate = None if info.msgcount < 2 else (info.msgcount - 1) / seconds
            listened = int(kind in (TWIST, TWIST_STAMPED))
            topics.append(Topic(name, kind, int(not listened), listened, rate_hz=rate, frame=frame, holds=holds))
        frames = Transforms()
        transforms = [connection for connection in reader.connections if connection.msgtype in TF_TYPES]
        for connection, _, data in islice(reader.messages(transforms), _TRANSFORMS) if transforms else ():
            _take_frames(frames, reader.deserialize(data, connection.msgtype), connection.topic)
        return Found(topics + [Topic(other.topic, other.msgtype) for other in others], frames)
    except TooMuch as refusal:
        raise LogError(f"{path}: a message, or a chunk of them, {refusal}") from None
    except DAMAGE as failure:
        raise LogError(f"{path}: is damaged: {words(failure)}") from None
    finally:
        reader.close()
        if unpacked is not None:
            unpacked.cleanup()
