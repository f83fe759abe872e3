"""ROS 1 bags and ROS 2 bags (sqlite3, MCAP) as logs: read by rosbags, so that no ROS need be installed."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from rosbags.interfaces import Connection

from app.base.geometry import Pose3
from app.logs.importers import ros_messages as ros
from app.logs.importers.remap import FixedSensor, Remap, RemapError, Undecided
from app.logs.importers.ros_camera import CameraInfo, PinholeCamera
from app.logs.importers.ros_open import DAMAGE, opened, words
from app.logs.importers.ros_stream import Received, RosStream, Setting, add_transforms, is_static
from app.logs.importers.ros_topics import (
    COLOR_TYPES,
    INFO_TYPE,
    PLAIN,
    TF_TYPES,
    Ambiguous,
    BagTopic,
    ChannelSource,
    FromCamera,
    FromTf,
    FromTopic,
    described,
    guessed,
    ignored,
    message_type,
    rectified,
    registered,
    remapped,
    used_by,
)
from app.logs.importers.transforms import Transforms
from app.logs.log import LogError, Logged, LoggedChannel, LogInfo
from app.logs.manifest import Manifest
from app.logs.mcap.decompression import TooMuch
from app.logs.stamps import SECOND, from_ns, to_ns
from app.messages import Image, JointState, LaserScan, Odometry

#: Before the time that is asked for, so much (s) is read for transforms and depths.
_BEFORE_S = 2.0
#: Amount of moving transforms (s, messages) that is read to find the frames.
_SAMPLE_S = 5.0
_SAMPLE_MESSAGES = 5000
#: Limit for static transforms: a bag has few; a bag that repeats them is read no longer than this.
_STATIC_MESSAGES = 20000
_BASES = ("base_link", "base_footprint")
#: The camera's optical frame where nothing is known: in the base's origin, looking ahead.
_AHEAD = Pose3.from_translation_rpy((0.0, 0.0, 0.0), (-1.5707963267948966, 0.0, -1.5707963267948966))
#: Streams of a body, and the channels they are found on.
_STREAMS: Mapping[str, tuple[str, type[Any]]] = {
    "stream.kinect": ("kinect", Image),
    "stream.hokuyo": ("scan", LaserScan),
    "stream.odometry": ("odometry", Odometry),
    "stream.joints": ("joints", JointState),
}


class RosBag:
    """A bag that another robot wrote."""

    def __init__(self, path: Path, remap: Remap | None = None) -> None:
        """Open the bag at ``path``, a file or a ROS 2 bag's folder. Reads its index, its static transforms, the first
        seconds of the others and one message of each sensor.

        Raises LogError for a bag that cannot be read or whose topics are ambiguous, ConfigError where ``remap`` does
        not fit it.
        """
        self._path = path
        self._reader, self._others, self._named = opened(path)
        try:
            self._connections: dict[str, list[Connection]] = {}
            for connection in self._reader.connections:
                self._connections.setdefault(connection.topic, []).append(connection)
            self._first: dict[str, Received] = {}
            topics = self._topics()
            self._tf = [topic.name for topic in topics if topic.type in TF_TYPES and topic.count]
            self._tree = self._sampled_tree()
            self._base, odom = self._frames(remap)
            found = (
                (odom, self._base) if self._tree.connected(odom, self._base) and odom in self._tree.frames() else None
            )
            try:
                self._channels = remapped(topics, remap) if remap and remap.channels else guessed(topics, found)
            except Ambiguous as doubt:
                described_topics = {topic.name: described(topic) for topic in topics}
                raise Undecided(f"{path}: {doubt}", self._log_info(topics, {}, described_topics, ())) from None
            if not self._channels:
                kinds = sorted({topic.type for topic in topics}) or ["nothing"]
                raise LogError(f"{path}: has no topic that becomes a channel; it holds {', '.join(kinds)}")
            notes: list[str] = []
            self._setting = self._settled(topics, notes)
            #: Odometry out of tf counts the messages of transforms, each of which may contain it.
            self.info = self._described(topics, notes, chosen=bool(remap and remap.channels))
        except DAMAGE as failure:
            self.close()
            raise LogError(f"{path}: is damaged: {words(failure)}") from None
        except BaseException:
            self.close()
            raise
        self.manifest = Manifest(facts=_facts(self._channels))

    def messages(self, begin: float | None = None, channels: Collection[str] | None = None) -> Iterator[Logged]:
        """Messages in order of arrival; a picture comes with its depth. Messages without a known pose, or unreadable
        ones, are skipped and logged. Raises LogError if the bag is damaged."""
        wanted = {name: s for name, s in self._channels.items() if channels is None or name in channels}
        # CameraInfo was read when the bag was opened.
        topics = {
            name for s in wanted.values() for name in used_by(s) if not isinstance(s, FromCamera) or name != s.info
        }
        if any(self._needs_tf(name, source) for name, source in wanted.items()):
            topics.update(name for name in self._tf if not is_static(name))
        connections = [connection for name in topics for connection in self._connections.get(name, ())]
        if not connections:
            return
        stream = RosStream(wanted, self._setting, self._tree.standing())
        yield from stream.read(self._received(connections, begin), begin)

    def close(self) -> None:
        if self._reader.stack is not None:
            self._reader.close()
        if self._named is not None:
            self._named.cleanup()
            self._named = None

    def _needs_tf(self, name: str, source: ChannelSource) -> bool:
        if isinstance(source, FromTf):
            return True
        return message_type(source) in (Image, LaserScan) and (
            name not in self._setting.placements or bool(self._setting.placements[name].frame)
        )

    def _received(self, connections: list[Connection], begin: float | None) -> Iterator[Received]:
        start = None if begin is None else to_ns(begin - _BEFORE_S)
        try:
            for connection, at, data in self._reader.messages(connections, start=start):
                message = self._reader.deserialize(data, connection.msgtype)
                yield Received(from_ns(at), connection.topic, message, len(data))
        except TooMuch as refusal:
            raise LogError(f"{self._path}: a message, or a chunk of them, {refusal}") from None
        except DAMAGE as failure:
            raise LogError(f"{self._path}: is damaged: {words(failure)}") from None

    def _topics(self) -> list[BagTopic]:
        topics = []
        for name, info in sorted(self._reader.topics.items()):
            # Several publishers may say different things of a topic's type; the first is taken.
            kind = info.msgtype or self._connections[name][0].msgtype
            topic = BagTopic(name, kind, info.msgcount)
            if info.msgcount and (kind in COLOR_TYPES or kind == INFO_TYPE or kind in PLAIN):
                first = self._peek(name)
                holds = ros.encoding_of(first.message) if kind in COLOR_TYPES else ""
                frame = ros.frame_of(first.message) if hasattr(first.message, "header") else ""
                topic = BagTopic(name, kind, info.msgcount, holds, frame)
            topics.append(topic)
        others: dict[str, BagTopic] = {}
        for connection in self._others:
            before = others.get(connection.topic)
            count = connection.msgcount + (before.count if before else 0)
            others[connection.topic] = BagTopic(connection.topic, connection.msgtype, count)
        return topics + sorted(others.values(), key=lambda topic: topic.name)

    def _peek(self, topic: str) -> Received:
        """The first message of a topic that has one. Raises LogError where its index only says so."""
        if topic not in self._first:
            first = next(self._received(self._connections[topic], None), None)
            if first is None:
                raise LogError(f"{self._path}: is damaged: its index promises messages on {topic} that are not there")
            self._first[topic] = first
        return self._first[topic]

    def _sampled_tree(self) -> Transforms:
        tree = Transforms()
        for standing in (True, False):
            connections = [c for name in self._tf if is_static(name) is standing for c in self._connections[name]]
            if not connections:
                continue
            begin: float | None = None
            for number, item in enumerate(self._received(connections, None)):
                begin = item.at if begin is None else begin
                if number >= _STATIC_MESSAGES or (
                    not standing and (number >= _SAMPLE_MESSAGES or item.at > begin + _SAMPLE_S)
                ):
                    break
                add_transforms(tree, item.message, item.at, static=standing)
        return tree

    def _frames(self, remap: Remap | None) -> tuple[str, str]:
        frames = self._tree.frames()
        chosen = remap.frames if remap else None
        base = (chosen and chosen.base) or next((name for name in _BASES if name in frames), _BASES[0])
        odom = (chosen and chosen.odom) or "odom"
        return base.lstrip("/"), odom.lstrip("/")

    def _settled(self, topics: list[BagTopic], notes: list[str]) -> Setting:
        by_name = {topic.name: topic for topic in topics}
        placements: dict[str, FixedSensor] = {}
        calibrations: dict[str, CameraInfo | None] = {}
        tolerances: dict[str, float] = {}
        for channel, source in self._channels.items():
            if isinstance(source, FromCamera):
                color = by_name[source.color]
                fixed, key, otherwise = source.X_BC, "X_BC", FixedSensor(_AHEAD)
                calibrations[channel] = self._calibration(channel, source, notes)
                period = self._duration_s / max(color.count - 1, 1)
                tolerances[channel] = source.tolerance_s or 0.5 * period
                depth = by_name[source.depth] if source.depth else None
                if depth is not None and not registered(depth, color):
                    notes.append(
                        f"{channel}: the depth of {depth.name} is taken as it is, though it seems not to be registered "
                        f"to the pixels of {color.name}"
                    )
            elif isinstance(source, FromTopic) and source.message_type is LaserScan:
                color = by_name[source.topic]
                fixed, key, otherwise = source.X_BL, "X_BL", FixedSensor(Pose3.identity())
            else:
                continue
            if fixed is not None and fixed.frame and not self._tree.connected(self._base, fixed.frame):
                frames = ", ".join(sorted(self._tree.frames())) or "none"
                raise RemapError(
                    f"{self._path}: tf does not say where {fixed.frame!r} is in {self._base!r}, and {key} of the "
                    f"channel {channel!r} places a sensor on it; frames of tf: {frames}"
                )
            if self._tree.connected(self._base, color.frame):
                if fixed is not None:
                    notes.append(f"{channel}: {key} of the remap file replaces the transform (tf) of {color.frame!r}")
                    placements[channel] = fixed
                continue
            placements[channel] = otherwise if fixed is None else fixed
            if fixed is None:
                notes.append(
                    f"{channel}: tf does not say where {color.frame!r} is in {self._base!r}: taken as its origin, "
                    f"looking ahead; {key} in a remap file says better"
                )
        return Setting(self._base, frozenset(self._tf), placements, calibrations, tolerances)

    def _calibration(self, channel: str, source: FromCamera, notes: list[str]) -> CameraInfo | None:
        calibration = CameraInfo.of(self._peek(source.info).message) if source.info else None
        if calibration is None:
            notes.append(
                f"{channel}: no CameraInfo with a calibration: taken for a camera of 57 degrees without distortion"
            )
            return None
        picture = ros.color_image(self._peek(source.color).message)
        camera = PinholeCamera(calibration, picture.shape[1], picture.shape[0], rectified=rectified(source.color))
        if camera.undistorts:
            notes.append(f"{channel}: the lens's distortion ({calibration.model}) is taken out of its pictures")
        return calibration

    @property
    def _duration_s(self) -> float:
        return max(self._reader.end_time - 1 - self._reader.start_time, 0) / SECOND

    def _described(self, topics: list[BagTopic], notes: list[str], *, chosen: bool) -> LogInfo:
        channels = {}
        counts = {topic.name: topic.count for topic in topics}
        for name, source in self._channels.items():
            of = used_by(source)[:1] or [topic for topic in self._tf if not is_static(topic)]
            count = sum(counts[topic] for topic in of)
            rate = (count - 1) / self._duration_s if count > 1 and self._duration_s > 0 else None
            channels[name] = LoggedChannel(name, message_type(source), count, rate)
        return self._log_info(topics, channels, ignored(topics, self._channels, chosen), tuple(notes))

    def _log_info(
        self,
        topics: list[BagTopic],
        channels: dict[str, LoggedChannel],
        reasons: Mapping[str, str],
        notes: tuple[str, ...],
    ) -> LogInfo:
        empty = not any(topic.count for topic in topics)
        return LogInfo(
            self._path,
            "ROS 2 bag" if self._reader.is2 else "ROS 1 bag",
            begin=0.0 if empty else from_ns(self._reader.start_time),
            end=0.0 if empty else from_ns(self._reader.end_time - 1),
            channels=channels,
            bytes=_size(self._path),
            ignored=reasons,
            notes=notes,
        )


def _facts(channels: Mapping[str, ChannelSource]) -> dict[str, str]:
    """Which channel is which stream of a body."""
    facts = {}
    for stream, (channel, kind) in _STREAMS.items():
        if channel in channels and message_type(channels[channel]) is kind:
            facts[stream] = channel
    return facts


def _size(path: Path) -> int:
    if path.is_dir():
        return sum(file.stat().st_size for file in path.iterdir() if file.is_file())
    return path.stat().st_size
