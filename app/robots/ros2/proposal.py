"""A mapping proposed from what a graph, or a bag, has: a pure function of topics and what was heard on them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from app.logs.importers.ros_topics import Ambiguous, BagTopic, FromCamera, guessed, registered
from app.logs.ros.live.joint_trajectory_action import FOLLOW
from app.robots.ros2.config import CAMERA_INFO, COMPRESSED_IMAGE, IMAGE, JOINT_TYPES, TWIST, TWIST_STAMPED, TYPES

#: Names that robots commonly use, the likeliest first, by stream; the namespace before them does not matter.
_USUAL = {
    "odometry": ("odom", "odometry/filtered", "wheel/odometry", "wheel_odom"),
    "joints": ("joint_states",),
    "hokuyo": ("scan", "scan_filtered", "base_scan", "front/scan"),
    "battery": ("battery_state", "battery"),
    "imu": ("imu", "imu/data", "imu/data_raw", "imu_mobile_base"),
}
_COMMANDS = ("cmd_vel", "cmd_vel_unstamped", "diff_drive_controller/cmd_vel", "stretch/cmd_vel")
_NOT_MAPPED = ("sensor_msgs/msg/PointCloud2", "tf2_msgs/msg/TFMessage")
#: What a server of the action publishes.
_FEEDBACK = f"{FOLLOW}_FeedbackMessage"
_HOLDS = {"hokuyo": "scans", "imu": "messages"}
_OF_CAMERAS = (IMAGE, COMPRESSED_IMAGE, CAMERA_INFO)
_NAMES = {"odometry": "odometry", "joints": "joints", "hokuyo": "laser", "battery": "battery", "imu": "inertial sensor"}


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic of a graph or a bag: its ``name``, ``type``, how many ``publishers`` and ``subscribers`` it has, and its
    rate (Hz, None: nothing was heard). ``frame``: frame_id of its messages; ``ahead_s``: median by which their stamps
    were later than they arrived; ``holds``: ``color``, ``mono`` or ``depth`` of pictures, "" where it is not known."""

    name: str
    type: str
    publishers: int = 1
    subscribers: int = 0
    rate_hz: float | None = None
    frame: str = ""
    ahead_s: float | None = None
    holds: str = ""


@dataclass(frozen=True, slots=True)
class Proposal:
    """A mapping as YAML text, and what it lacks, in sentences. ``drivable``: there is odometry, and something takes
    velocities."""

    text: str
    missing: tuple[str, ...]
    remarks: tuple[str, ...]
    drivable: bool


@dataclass(slots=True)
class _Writing:
    missing: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def propose(topics: Iterable[Topic], links: Mapping[str, bool] | None = None) -> Proposal:
    """The mapping of the robot that has ``topics``.

    ``links``: the links of its model, and whether each is fixed to the base; None where the model is not known.
    """
    known, writing = list(topics), _Writing()
    chosen = {stream: _chosen(known, stream, writing) for stream in TYPES}
    simulated = any(topic.name == "/clock" and topic.publishers for topic in known)
    lines = [
        "# Proposed by `hbba ros map`: every value is to be looked at, those marked ? to be set (docs/ros2.md).",
        "kind: ros2",
        "name: My robot                  # ?",
        "model: robot.urdf               # ? where its sensors are",
        "program: turtlebot4.yaml        # ? for a base with laser, camera and battery: without what it lacks",
        "footprint: [[0.2, -0.2], [0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2]]   # ? its outline, m",
        "limits:                         # ? below the robot's own",
        "  {linear_mps: 0.2, angular_radps: 0.8, linear_mps2: 0.4, angular_radps2: 2.0, required_sensors: [odometry]}",
        f"graph: {{clock: {_clock(chosen.values(), simulated, writing)}}}",
        "streams:" if any(chosen.values()) or any(topic.holds for topic in known) else "streams: {}",
    ]
    lines += [_stream(stream, topic, links, writing) for stream, topic in chosen.items() if topic is not None]
    lines += _camera(known, links, writing)
    lines += _base(known, writing)
    if left := sorted(topic.name for topic in known if topic.publishers and topic.type in _NOT_MAPPED):
        writing.remarks.append(f"Topics of clouds and frames are not mapped yet: {', '.join(left)}.")
    if joints := sorted(topic.name for topic in known if topic.subscribers and topic.type in JOINT_TYPES):
        writing.remarks.append(
            f"joints: set-points are taken on {', '.join(joints)}: name the groups in actuators and joint_commands."
        )
    if actions := sorted(topic.name for topic in known if topic.publishers and topic.type == _FEEDBACK):
        names = ", ".join(name.removesuffix("/_action/feedback") for name in actions)
        writing.remarks.append(
            f"joints: trajectories are taken by the action {names}: name the groups in actuators and joint_commands."
        )
    drivable = chosen["odometry"] is not None and bool(_takers(known))
    return Proposal("\n".join(lines) + "\n", tuple(writing.missing), tuple(writing.remarks), drivable)


def _chosen(topics: list[Topic], stream: str, writing: _Writing) -> Topic | None:
    fitting = [topic for topic in topics if topic.type == TYPES[stream] and topic.publishers]
    if not fitting and stream == "imu":
        return None  # most robots do well without
    if not fitting:
        grave = " The base must not drive without it." if stream == "odometry" else ""
        writing.missing.append(f"{_NAMES[stream]}: no topic of the type {TYPES[stream]} has a publisher.{grave}")
        return None
    fitting.sort(key=lambda topic: (_place(topic.name, _USUAL[stream]), topic.rate_hz is None, topic.name))
    if len(fitting) > 1:
        others = ", ".join(topic.name for topic in fitting[1:])
        writing.remarks.append(f"{_NAMES[stream]}: {fitting[0].name} was chosen; there are also {others}.")
    if fitting[0].rate_hz is None:
        writing.missing.append(f"{_NAMES[stream]}: nothing came on {fitting[0].name}, so that its rate is guessed.")
    return fitting[0]


def _place(name: str, usual: tuple[str, ...]) -> int:
    """The place among ``usual`` names of the first with which ``name`` ends; behind them if there is none."""
    return next((at for at, end in enumerate(usual) if name == f"/{end}" or name.endswith(f"/{end}")), len(usual))


def _rate(topic: Topic) -> str:
    return "10" if topic.rate_hz is None else f"{float(f'{topic.rate_hz:.2g}'):g}"


def _stream(stream: str, topic: Topic, links: Mapping[str, bool] | None, writing: _Writing) -> str:
    if stream not in ("hokuyo", "imu"):
        return f"  {stream}: {{topic: {topic.name}, rate_hz: {_rate(topic)}}}"
    name = _NAMES[stream]
    if not topic.frame:
        writing.missing.append(f"{name}: its frame is not known; link must name the link of the model where it is.")
    elif links is not None and topic.frame not in links:
        there, who = ", ".join(links), _HOLDS[stream]
        writing.missing.append(f"{name}: the model has no link {topic.frame!r}, which its {who} name; it has {there}.")
    elif links is not None and not links[topic.frame]:
        writing.missing.append(f"{name}: a joint of the model moves {topic.frame!r}; it must be fixed to the base.")
    link = topic.frame or f"{'laser' if stream == 'hokuyo' else 'imu'}_link"
    return f"  {stream}: {{topic: {topic.name}, rate_hz: {_rate(topic)}, link: {link}}}"


def _camera(topics: list[Topic], links: Mapping[str, bool] | None, writing: _Writing) -> list[str]:
    """The line of the camera: as ``kinect`` with a registered depth, else as ``camera``."""
    known = {topic.name: topic for topic in topics if topic.type in _OF_CAMERAS and topic.publishers}
    pictures = [BagTopic(topic.name, topic.type, 1, topic.holds, topic.frame) for topic in known.values()]
    try:
        source = guessed(pictures, None).get("kinect")
    except Ambiguous as doubt:
        source = doubt.guess["kinect"]
        others = ", ".join(doubt.candidates[1:])
        writing.remarks.append(f"camera: {doubt.candidates[0]} was chosen; there are also {others}.")
    if not isinstance(source, FromCamera):
        return []
    color = known[source.color]
    if links is not None and color.frame not in links:
        writing.missing.append(
            f"camera: the model has no link {color.frame!r}, which its pictures name; it has {', '.join(links)}."
        )
    members = {"topic": color.name, "rate_hz": _rate(color), "link": color.frame or "camera_optical_frame"}
    depth = next((picture for picture in pictures if picture.name == source.depth), None)
    stream = "camera"
    if depth is not None and registered(depth, next(each for each in pictures if each.name == color.name)):
        stream, members["depth"] = "kinect", depth.name
    elif depth is not None:
        writing.remarks.append(f"camera: {depth.name} is not mapped: it may not be registered to the pictures.")
    if source.info is not None:
        members["info"] = source.info
    else:
        members["horizontal_fov_deg"] = "60"
        writing.missing.append(f"camera: {color.name} has no CameraInfo: measure its horizontal_fov_deg.")
    return [f"  {stream}: {{{', '.join(f'{key}: {value}' for key, value in members.items())}}}"]


def _clock(chosen: Iterable[Topic | None], simulated: bool, writing: _Writing) -> str:
    if simulated:
        writing.remarks.append("clock: /clock is there, so times are taken as simulated.")
        return "sim"
    ahead = [topic.ahead_s for topic in chosen if topic is not None and topic.ahead_s is not None]
    farthest = max(ahead, key=abs, default=0.0)
    if abs(farthest) > 0.5 or not math.isfinite(farthest):
        side = "ahead of" if farthest > 0 else "behind"
        writing.missing.append(
            f"clock: the robot's is {abs(farthest):.1f} s {side} this computer's: synchronize the two (NTP, chrony), "
            "or set clock to arrival."
        )
    return "header"


def _takers(topics: list[Topic]) -> list[Topic]:
    """The topics on which something takes velocities, the likeliest first."""
    fitting = [topic for topic in topics if topic.type in (TWIST, TWIST_STAMPED) and topic.subscribers]
    return sorted(fitting, key=lambda topic: (_place(topic.name, _COMMANDS), topic.name))


def _base(topics: list[Topic], writing: _Writing) -> list[str]:
    fitting = _takers(topics)
    if not fitting:
        writing.missing.append(f"base: nothing listens to a topic of the type {TWIST} or {TWIST_STAMPED}.")
    topic = fitting[0] if fitting else Topic("/cmd_vel", TWIST_STAMPED)
    if len(fitting) > 1:
        others = ", ".join(f"{other.name} ({other.type})" for other in fitting[1:])
        writing.remarks.append(f"base: {topic.name} was chosen; there are also {others}.")
    if fitting and topic.publishers:
        writing.remarks.append(f"base: something else publishes on {topic.name}, too, past this program's guard.")
    writing.missing.append(
        "watchdog: after how long without a command the robot stops by itself cannot be seen from outside. Measure it."
    )
    return [
        "base:",
        f"  topic: {topic.name}",
        f"  type: {topic.type}",
        "  watchdog_s: null              # ? after how long without a command the robot stops by itself",
    ]
