"""Which topics of a bag become which channels: as a remap file says, or guessed where only one guess is possible."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from app.base.yaml_source import suggestion
from app.logs.importers.remap import FixedSensor, Remap, RemapSource
from app.messages import Image, JointState, LaserScan, Odometry, Twist

COLOR_TYPES = frozenset({"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"})
INFO_TYPE = "sensor_msgs/msg/CameraInfo"
TF_TYPES = frozenset({"tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"})
#: Types that become one message each.
PLAIN: Mapping[str, type[Any]] = {
    "sensor_msgs/msg/LaserScan": LaserScan,
    "sensor_msgs/msg/MultiEchoLaserScan": LaserScan,
    "nav_msgs/msg/Odometry": Odometry,
    "sensor_msgs/msg/JointState": JointState,
    "geometry_msgs/msg/Twist": Twist,
    "geometry_msgs/msg/TwistStamped": Twist,
}
#: The channel that the one topic of a kind becomes. A velocity command is no sensor: it is taken only if asked for.
_CHANNELS: Mapping[type[Any], str] = {LaserScan: "scan", Odometry: "odometry", JointState: "joints"}
_CAMERA = "kinect"
_REGISTERED = ("registered", "aligned", "to_color", "to_rgb")
_DEPTH_ENDINGS = ("/compressedDepth", "/compressed")


@dataclass(frozen=True, slots=True)
class BagTopic:
    """A topic of a bag: ``type`` as ROS 2 writes it; ``holds`` and ``frame`` of an image, from its first message.

    ``holds``: ``color``, ``mono``, ``depth``, or "" for what cannot be read.
    """

    name: str
    type: str
    count: int
    holds: str = ""
    frame: str = ""


@dataclass(frozen=True, slots=True)
class FromTopic:
    """A channel made of one topic's messages; ``X_BL`` where tf does not say it."""

    message_type: type[Any]
    topic: str
    X_BL: FixedSensor | None = None


@dataclass(frozen=True, slots=True)
class FromTf:
    """Odometry out of tf: ``child`` in ``parent``, once for each time that tf says it."""

    parent: str
    child: str


@dataclass(frozen=True, slots=True)
class FromCamera:
    """Images out of a camera's topics; ``X_BC`` where tf does not say it."""

    color: str
    depth: str | None = None
    info: str | None = None
    X_BC: FixedSensor | None = None
    tolerance_s: float | None = None


ChannelSource = FromTopic | FromTf | FromCamera


class Ambiguous(Exception):
    """Several topics could be the channel; ``candidates`` are theirs, ``guess`` what all channels would be with the
    first of them."""

    def __init__(self, channel: str, candidates: tuple[str, ...], guess: Mapping[str, ChannelSource]) -> None:
        super().__init__(channel, candidates, guess)
        self.channel = channel
        self.candidates = candidates
        self.guess = guess

    def __str__(self) -> str:
        """The message for people, with a remap file to paste."""
        return (
            f"{len(self.candidates)} topics could be the channel {self.channel!r}: {', '.join(self.candidates)}. "
            "Choose in a remap file and name it with --remap; this one takes the first:\n\n"
            + as_yaml(self.guess, {self.channel: self.candidates[1:]})
        )


def guessed(topics: Sequence[BagTopic], odometry_in_tf: tuple[str, str] | None) -> dict[str, ChannelSource]:
    """The channels of a bag that says nothing of them; ``odometry_in_tf``: parent and child, if tf has odometry.

    Raises Ambiguous where several topics could be meant.
    """
    channels: dict[str, ChannelSource] = {}
    doubts: list[tuple[str, tuple[str, ...]]] = []
    colors = _cameras(topics)
    if colors:
        color = min(colors, key=lambda color: not _depths(topics, color, beside=len(colors) > 1))
        colors = [color, *(other for other in colors if other is not color)]
        depths = _depths(topics, color, beside=len(colors) > 1)
        channels[_CAMERA] = FromCamera(color.name, depths[0].name if depths else None, _info(topics, color))
        if len(colors) > 1:
            doubts.append((_CAMERA, tuple(topic.name for topic in colors)))
        elif len(depths) > 1:
            doubts.append((_CAMERA, tuple(topic.name for topic in depths)))
    for kind, channel in _CHANNELS.items():
        found = [topic for topic in topics if PLAIN.get(topic.type) is kind and topic.count]
        if found:
            channels[channel] = FromTopic(kind, found[0].name)
        if len(found) > 1 and kind is not JointState:
            doubts.append((channel, tuple(topic.name for topic in found)))
    if "odometry" not in channels and odometry_in_tf is not None:
        channels["odometry"] = FromTf(*odometry_in_tf)
    if doubts:
        raise Ambiguous(*doubts[0], channels)
    return channels


def remapped(topics: Sequence[BagTopic], remap: Remap) -> dict[str, ChannelSource]:
    """The channels a remap file says. Raises ConfigError where it names what the bag has not."""
    by_name = {topic.name: topic for topic in topics}

    def named(channel: str, key: str, name: str, wanted: Callable[[BagTopic], bool], what: str) -> BagTopic:
        topic = by_name.get(name if name.startswith("/") else f"/{name.strip('/')}")
        key_path = ("channels", channel, key)
        if topic is None:
            fitting = [t.name for t in topics if wanted(t)] or list(by_name)
            raise remap.error(f"the bag has no topic {name!r}; {suggestion(name, fitting)}", key_path)
        if not wanted(topic):
            raise remap.error(f"{name} ({topic.type}{topic.holds and f', {topic.holds}'}) is {what}", key_path)
        return topic

    channels: dict[str, ChannelSource] = {}
    for channel, source in remap.channels.items():
        if source.topic is not None:
            topic = named(
                channel, "topic", source.topic, lambda t: t.type in PLAIN, "of no type that becomes a channel"
            )
            channels[channel] = _plain(channel, source, topic, remap)
        elif source.tf is not None:
            channels[channel] = FromTf(*(name.lstrip("/") for name in source.frames))
        elif source.color is not None:
            color = named(channel, "color", source.color, _shows_color, "no colour image that can be read")
            depth = source.depth and named(
                channel, "depth", source.depth, _shows_depth, "no depth image that can be read"
            )
            info = source.info and named(channel, "info", source.info, lambda t: t.type == INFO_TYPE, "no CameraInfo")
            channels[channel] = FromCamera(
                color.name,
                depth.name if depth else None,
                info.name if info else _info(topics, color),
                source.X_BC.fixed() if source.X_BC else None,
                source.tolerance_s,
            )
    return channels


def _plain(channel: str, source: RemapSource, topic: BagTopic, remap: Remap) -> FromTopic:
    kind = PLAIN[topic.type]
    if source.X_BL is not None and kind is not LaserScan:
        raise remap.error(f"X_BL places a laser; {topic.name} is {topic.type}", ("channels", channel, "X_BL"))
    return FromTopic(kind, topic.name, source.X_BL.fixed() if source.X_BL else None)


def described(topic: BagTopic) -> str:
    """The content of a topic, for people."""
    what = {"color": ", in color", "mono": ", grey", "depth": ", depth"}.get(topic.holds, "")
    frame = f", in {topic.frame}" if topic.frame else ""
    return f"{topic.type}{what}{frame}, {topic.count} message{'s' * (topic.count != 1)}"


def ignored(topics: Iterable[BagTopic], channels: Mapping[str, ChannelSource], chosen: bool) -> dict[str, str]:
    """Topic -> why it is read by no channel; ``chosen``: a remap file says which are."""
    used = {name for source in channels.values() for name in used_by(source)}
    has_camera = any(isinstance(source, FromCamera) for source in channels.values())
    reasons = {}
    for topic in topics:
        if topic.name in used or topic.type in TF_TYPES:
            continue
        if not topic.count:
            reasons[topic.name] = "has no message"
        elif topic.type in COLOR_TYPES and not topic.holds:
            reasons[topic.name] = f"{topic.type} in an encoding that is not read"
        elif topic.type in COLOR_TYPES | {INFO_TYPE} or topic.type in PLAIN:
            reasons[topic.name] = f"{topic.type}{_unused(topic, chosen, has_camera)}"
        else:
            reasons[topic.name] = f"{topic.type}: no message of this program says this"
    return reasons


def _unused(topic: BagTopic, chosen: bool, has_camera: bool) -> str:
    if chosen:
        return ", which no channel of the remap file names"
    if topic.type in COLOR_TYPES | {INFO_TYPE} and not has_camera:
        return ": there is no colour picture that it goes with"
    if PLAIN.get(topic.type) is Twist:
        return ": a command is no sensor; a remap file may make it a channel"
    return ": another topic serves; a remap file may make it a channel"


def used_by(source: ChannelSource) -> tuple[str, ...]:
    """The topics a channel is made of, tf aside."""
    if isinstance(source, FromTopic):
        return (source.topic,)
    if isinstance(source, FromTf):
        return ()
    return tuple(name for name in (source.color, source.depth, source.info) if name)


def message_type(source: ChannelSource) -> type[Any]:
    """The class of a channel's messages."""
    if isinstance(source, FromTopic):
        return source.message_type
    return Odometry if isinstance(source, FromTf) else Image


def as_yaml(channels: Mapping[str, ChannelSource], others: Mapping[str, Sequence[str]] | None = None) -> str:
    """A remap file that says ``channels``; ``others`` are said beside theirs as what could stand there too."""
    lines = ["channels:"]
    for channel, source in channels.items():
        if isinstance(source, FromTopic):
            text = f"topic: {source.topic}"
        elif isinstance(source, FromTf):
            text = f"tf: {source.parent} -> {source.child}"
        else:
            parts = {"color": source.color, "depth": source.depth, "info": source.info}
            text = ", ".join(f"{key}: {name}" for key, name in parts.items() if name)
        other = (others or {}).get(channel)
        lines.append(f"  {channel}: {{{text}}}" + (f"  # or {', '.join(other)}" if other else ""))
    return "\n".join(lines) + "\n"


def rectified(topic: str) -> bool:
    """Whether a picture of this topic is one without distortion, as image_proc names them."""
    return "rect" in _place(topic).rsplit("/", 1)[-1]


def registered(depth: BagTopic, color: BagTopic) -> bool:
    """Whether depth is given for the colour camera's pixels."""
    return any(word in depth.name for word in _REGISTERED) or bool(depth.frame and depth.frame == color.frame)


def _cameras(topics: Sequence[BagTopic]) -> list[BagTopic]:
    """The pictures that could be meant, one of each camera, the best first; one, where only one camera has colour."""
    best: dict[str, BagTopic] = {}
    for topic in topics:
        if not topic.count or not _shows_color(topic):
            continue
        camera = _camera(topic.name)
        if camera not in best or _rank(topic) < _rank(best[camera]):
            best[camera] = topic
    found = sorted(best.values(), key=_rank)
    colored = [topic for topic in found if topic.holds == "color"]
    return colored or found


def _rank(topic: BagTopic) -> tuple[bool, bool, bool, str]:
    return topic.holds != "color", not rectified(topic.name), "compressed" in topic.name, topic.name


def _depths(topics: Sequence[BagTopic], color: BagTopic, *, beside: bool) -> list[BagTopic]:
    """The depths that could be meant, one of each place: registered ones first, else those nearest by name.

    ``beside``: only those of the same camera, by its frame or by what their names begin with.
    """
    best: dict[str, BagTopic] = {}
    for topic in topics:
        if not topic.count or not _shows_depth(topic) or (beside and not _of_one_camera(topic, color)):
            continue
        place = _camera(topic.name)
        if place not in best or _rank(topic) < _rank(best[place]):
            best[place] = topic
    found = sorted(best.values(), key=lambda topic: topic.name)
    fitting = [topic for topic in found if registered(topic, color)]
    return fitting or found


def _of_one_camera(one: BagTopic, other: BagTopic) -> bool:
    if one.frame and one.frame == other.frame:
        return True
    first, second = (topic.name.strip("/").split("/")[0] for topic in (one, other))
    return first == second


def _info(topics: Sequence[BagTopic], color: BagTopic) -> str | None:
    infos = [topic.name for topic in topics if topic.type == INFO_TYPE and topic.count]
    beside = f"{_camera(color.name)}/camera_info"
    if beside in infos:
        return beside
    near = [name for name in infos if name.startswith(_camera(_camera(color.name)) + "/") and "depth" not in name]
    if len(near) == 1:
        return near[0]
    return infos[0] if len(infos) == 1 else None


def _place(topic: str) -> str:
    """The picture's name without its transport: ``/camera/rgb/image_raw`` of ``/camera/rgb/image_raw/compressed``."""
    for ending in _DEPTH_ENDINGS:
        topic = topic.removesuffix(ending)
    return topic


def _camera(topic: str) -> str:
    """The name space of a picture: ``/camera/rgb`` of ``/camera/rgb/image_raw/compressed``."""
    return _place(topic).rpartition("/")[0]


def _shows_color(topic: BagTopic) -> bool:
    return topic.type in COLOR_TYPES and topic.holds in ("color", "mono")


def _shows_depth(topic: BagTopic) -> bool:
    return topic.type in COLOR_TYPES and topic.holds == "depth"
