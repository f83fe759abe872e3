"""The messages of a bag, made into ours one by one while they are read.

A message waits a moment, in the bag's time, before it is made: by then the transforms around its stamp and the depth
of its picture have come too.
"""

from __future__ import annotations

import cmath
import logging
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.base.geometry import Pose3, wrap_angle
from app.logs.importers import ros_messages as ros
from app.logs.importers.remap import FixedSensor
from app.logs.importers.ros_camera import CameraInfo, PinholeCamera, fitted
from app.logs.importers.ros_topics import ChannelSource, FromCamera, FromTf, FromTopic, rectified
from app.logs.importers.transforms import StampedTransform, Transforms
from app.logs.log import Logged
from app.messages import Image, JointState, LaserScan, Odometry, Twist, read_only

#: How long (s, the bag's time) a message waits for its other parts, and how long a depth is kept.
AHEAD_S = 0.5
_DEPTH_KEPT_S = 1.5
#: Limit (bytes, approximate) of messages that wait; beyond it the oldest waits no longer.
_WAITING_BYTES = 96 * 1024 * 1024

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, eq=False)
class Received:
    """A message of a bag as rosbags reads it: ``at`` (s) of its arrival, ``bytes`` it takes."""

    at: float
    topic: str
    message: Any
    bytes: int


@dataclass(frozen=True, slots=True)
class Setting:
    """Facts of a bag for reading its messages.

    ``base``: frame of the base; ``tf``: topics of transforms; ``placements``: of sensors by channel, where the bag
    has none; ``calibrations``: of cameras, by channel; ``tolerances``: seconds between colour and depth, by channel.
    """

    base: str
    tf: frozenset[str]
    placements: Mapping[str, FixedSensor]
    calibrations: Mapping[str, CameraInfo | None]
    tolerances: Mapping[str, float]


@dataclass(slots=True)
class _CameraStream:
    """State for a camera's pictures: its recent depths, and its calibrations by the pictures' size."""

    depths: deque[tuple[float, Received]] = field(default_factory=deque)
    cameras: dict[tuple[int, int], PinholeCamera] = field(default_factory=dict)


class RosStream:
    """One reading of a bag: takes the bag's messages in the order of arrival and gives ours in that order."""

    def __init__(self, channels: Mapping[str, ChannelSource], setting: Setting, transforms: Transforms) -> None:
        """``transforms`` holds the static ones; the stream adds those that move."""
        self._setting = setting
        self._transforms = transforms
        self._waiting: deque[tuple[Received, str | Logged]] = deque()
        self._bytes = 0
        self._channels = channels
        self._topics: dict[str, list[str]] = {}
        self._depth_of: dict[str, list[str]] = {}
        self._cameras: dict[str, _CameraStream] = {}
        self._odometry: dict[str, Odometry | None] = {}
        self._complaints: set[str] = set()
        for name, source in channels.items():
            if isinstance(source, FromTopic):
                self._topics.setdefault(source.topic, []).append(name)
            elif isinstance(source, FromTf):
                self._odometry[name] = None
            else:
                self._topics.setdefault(source.color, []).append(name)
                self._cameras[name] = _CameraStream()
                if source.depth:
                    self._depth_of.setdefault(source.depth, []).append(name)

    def read(self, received: Iterable[Received], begin: float | None) -> Iterator[Logged]:
        """Our messages that arrived at ``begin`` or later (None: all), of ``received`` that began some time before."""
        for item in received:
            self._take(item)
            while self._waiting and (self._waiting[0][0].at < item.at - AHEAD_S or self._bytes > _WAITING_BYTES):
                yield from self._next(begin)
        while self._waiting:
            yield from self._next(begin)

    def _take(self, item: Received) -> None:
        if item.topic in self._setting.tf:
            for channel, message in self._moved(item):
                self._waiting.append((Received(item.at, item.topic, None, 0), Logged(item.at, channel, message)))
        for camera in self._depth_of.get(item.topic, ()):
            depths = self._cameras[camera].depths
            depths.append((ros.stamp_of(item.message, item.at), item))
            while depths[0][1].at < item.at - _DEPTH_KEPT_S:
                depths.popleft()
        for channel in self._topics.get(item.topic, ()):
            self._waiting.append((item, channel))
            self._bytes += item.bytes

    def _next(self, begin: float | None) -> Iterator[Logged]:
        item, what = self._waiting.popleft()
        self._bytes -= item.bytes
        if begin is not None and item.at < begin:
            return
        if isinstance(what, Logged):
            yield what
            return
        try:
            message = self._made(what, self._channels[what], item)
        except ValueError as failure:
            self._complain(f"{item.topic}: a message is left out: {failure}")
            return
        if message is not None:
            yield Logged(item.at, what, message)

    def _made(self, channel: str, source: ChannelSource, item: Received) -> Any:
        """The message of ``channel``; None where its sensor's place is not known. Raises ValueError."""
        if isinstance(source, FromCamera):
            return self._image(channel, source, item)
        assert isinstance(source, FromTopic)
        if source.message_type is LaserScan:
            pose = self._pose(channel, item)
            return None if pose is None else ros.laser_scan(item.message, item.at, pose)
        return _PLAIN[source.message_type](item.message, item.at)

    def _image(self, channel: str, source: FromCamera, item: Received) -> Image | None:
        pose = self._pose(channel, item)
        if pose is None:
            return None
        stamp = ros.stamp_of(item.message, item.at)
        color = ros.color_image(item.message)
        camera = self._camera(channel, color.shape[1], color.shape[0], rectified=rectified(source.color))
        depth = None
        if source.depth is not None:
            found = self._nearest(channel, stamp)
            # A camera that has depth measured none of this picture's.
            depth = np.zeros(color.shape[:2], np.uint16)
            if found is not None:
                measured = fitted(ros.depth_image(found), camera.model)
                if measured is None:
                    raise ValueError("the depth has another shape than the colour")
                depth = measured if rectified(source.depth) else camera.depth(measured)
            depth = read_only(depth)
        return Image(
            stamp,
            ros.frame_of(item.message),
            color=read_only(camera.color(color)),
            depth=depth,
            camera=camera.model,
            X_BC=pose,
        )

    def _camera(self, channel: str, width: int, height: int, *, rectified: bool) -> PinholeCamera:
        cameras = self._cameras[channel].cameras
        camera = cameras.get((width, height))
        if camera is None:
            calibration = self._setting.calibrations.get(channel)
            camera = cameras[width, height] = PinholeCamera(calibration, width, height, rectified=rectified)
        return camera

    def _nearest(self, channel: str, stamp: float) -> Any:
        """The depth message nearest to ``stamp``, None where none is near enough."""
        depths = self._cameras[channel].depths
        if not depths:
            return None
        when, item = min(depths, key=lambda pair: abs(pair[0] - stamp))
        return item.message if abs(when - stamp) <= self._setting.tolerances[channel] else None

    def _pose(self, channel: str, item: Received) -> Pose3 | None:
        """Pose of the sensor in the base at the message's stamp."""
        fixed = self._setting.placements.get(channel)
        if fixed is not None and not fixed.frame:
            return fixed.pose
        frame = ros.frame_of(item.message) if fixed is None else fixed.frame
        pose = self._transforms.lookup(self._setting.base, frame, ros.stamp_of(item.message, item.at))
        if pose is None:
            self._complain(f"{item.topic}: tf does not say where {frame!r} was at some messages: they are left out")
            return None
        return pose if fixed is None else pose @ fixed.pose

    def _moved(self, item: Received) -> Iterator[tuple[str, Odometry]]:
        """Take in a tf message, and give the odometry that it makes."""
        children = add_transforms(self._transforms, item.message, item.at, static=is_static(item.topic))
        for channel, last in self._odometry.items():
            source = self._channels[channel]
            assert isinstance(source, FromTf)
            path = self._transforms.path(source.child, source.parent)
            stamp = max((stamp for child, stamp in children if child in path), default=None)
            if stamp is None or (last is not None and stamp <= last.stamp):
                continue
            pose = self._transforms.lookup(source.parent, source.child, stamp)
            if pose is None:
                continue
            self._odometry[channel] = now = followed(last, stamp, pose)
            yield channel, now

    def _complain(self, sentence: str) -> None:
        if sentence not in self._complaints and len(self._complaints) < 100:
            self._complaints.add(sentence)
            logger.warning("%s", sentence)


_PLAIN: Mapping[type[Any], Callable[[Any, float], Any]] = {
    Odometry: ros.odometry,
    JointState: ros.joint_state,
    Twist: ros.twist,
}


def is_static(topic: str) -> bool:
    """Whether transforms of this topic stand still."""
    return topic.endswith("tf_static")


def add_transforms(transforms: Transforms, message: Any, at: float, *, static: bool) -> list[tuple[str, float]]:
    """Take in a tf2_msgs/TFMessage or tf/tfMessage; returns child frame and stamp (s) of each transform in it."""
    children = []
    for stamped in message.transforms:
        t, q = stamped.transform.translation, stamped.transform.rotation
        child, stamp = str(stamped.child_frame_id).lstrip("/"), ros.stamp_of(stamped, at)
        quaternion = (float(q.x), float(q.y), float(q.z), float(q.w))
        if not sum(value * value for value in quaternion) > 1e-6:
            continue  # no rotation: tf refuses these too
        placed = StampedTransform(stamp, (float(t.x), float(t.y), float(t.z)), quaternion)
        transforms.add(ros.frame_of(stamped), child, placed, static=static)
        children.append((child, stamp))
    return children


def followed(last: Odometry | None, stamp: float, pose: Pose3) -> Odometry:
    """Odometry at ``pose``, its twist being what led there from the last one, which is earlier."""
    X_OB = ros.heading(pose)
    if last is None:
        return Odometry(stamp, X_OB, 0.0, 0.0)
    step = last.X_OB.inverse() @ X_OB
    dt, turn = stamp - last.stamp, wrap_angle(step.theta)
    # The chord of an arc leads off half its turn: without a sideways motion, none is made of it.
    velocity = complex(step.x, step.y) * cmath.rect(1.0, -turn / 2) / dt
    return Odometry(stamp, X_OB, velocity.real, turn / dt, lateral_mps=velocity.imag)
