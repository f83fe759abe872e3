"""The mapping of a robot that speaks ROS 2: the models of ``config/robots/turtlebot4.yaml`` and its like."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Final, Literal, Self
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field, PrivateAttr, field_validator, model_validator

from app.base.errors import ConfigError
from app.base.kinematic_model import KinematicModel, load_model
from app.base.yaml_source import Document, load_yaml, suggestion
from app.link import SafeAction
from app.logs.importers.ros_topics import rectified
from app.logs.ros.live.joint_trajectory_action import FOLLOW
from app.robots.actuator_config import ActuatorConfig
from app.robots.config import BodyConfig, load_body_config
from app.robots.config_model import ConfigModel, Positive

TWIST, TWIST_STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"
#: The ROS type that each stream is read from.
TYPES = {
    "odometry": "nav_msgs/msg/Odometry",
    "joints": "sensor_msgs/msg/JointState",
    "hokuyo": "sensor_msgs/msg/LaserScan",
    "battery": "sensor_msgs/msg/BatteryState",
    "imu": "sensor_msgs/msg/Imu",
}
IMAGE, COMPRESSED_IMAGE = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
TRAJECTORY: Final = "trajectory_msgs/msg/JointTrajectory"
POSITIONS: Final = "std_msgs/msg/Float64MultiArray"
#: What set-points of joints are sent as.
JOINT_TYPES = (TRAJECTORY, POSITIONS)
TRANSFORMS = "tf2_msgs/msg/TFMessage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
#: The name of the subscription to simulated time.
CLOCK = "clock"
#: The streams of pictures, and the topics beside theirs: names are ``stream.part``.
CAMERAS = ("camera", "kinect")
INFO, DEPTH = "info", "depth"
STATUS_HZ = 20.0
_TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")


def _is_topic(name: str) -> str:
    if not _TOPIC.fullmatch(name):
        raise ValueError(
            "a topic's name is of letters, digits and _, in parts joined by /, none beginning with a digit"
        )
    return name


Topic = Annotated[str, AfterValidator(_is_topic)]


def _is_rosbridge(url: str) -> str:
    try:
        parts = urlsplit(url)
        host = (parts.hostname or "").encode("idna")  # as it is when its address is looked up
        complete = parts.scheme in ("ws", "wss") and bool(host) and parts.port is not None
    except ValueError:  # of the port, or the name
        complete = False
    if not complete or parts.username is not None or parts.query or parts.fragment or not url.isascii():
        raise ValueError(f"{url!r} is no ws://HOST:PORT or wss://HOST:PORT, with a path where it has one")
    return url


class GraphConfig(ConfigModel):
    """Where the robot is found, and how its clock is taken.

    ``clock``: ``header`` takes the stamps of its messages as they are, and refuses those that are farther than
    ``clock_tolerance_s`` from this computer's clock; ``sim`` takes them as times of ``/clock`` (the robot's nodes run
    with ``use_sim_time``), with the same tolerance; ``arrival`` ignores them and takes the time of arrival.
    """

    domain: Annotated[int, Field(ge=0, le=232)] | None = Field(
        default=None, description="ROS_DOMAIN_ID; null: that of the environment, else 0"
    )
    discovery: Literal["localhost", "subnet", "environment"] = Field(
        default="environment", description="how far it looks; environment: as the variables of ROS say"
    )
    rosbridge: Annotated[str, AfterValidator(_is_rosbridge)] | None = Field(
        default=None, description="address of the robot's rosbridge, by which it is then reached, without ROS 2 here"
    )
    namespace: Topic | Literal[""] = Field(default="", description="before every topic that does not begin with /")
    clock: Literal["header", "sim", "arrival"] = "header"
    clock_tolerance_s: Annotated[float, Field(gt=0, le=10)] = 0.5
    found_within_s: Annotated[float, Field(gt=0, le=600)] = Field(
        default=15.0, description="how long the robot may take to appear when the program starts"
    )

    @model_validator(mode="after")
    def _is_found_one_way(self) -> Self:
        if self.rosbridge is not None and (self.domain is not None or self.discovery != "environment"):
            raise ValueError("domain and discovery are of ROS 2's own middleware, which rosbridge takes the place of")
        return self


class TopicConfig(ConfigModel):
    """One stream: its topic, and the rate (Hz) at which the robot gives it."""

    topic: Topic
    rate_hz: Positive = 20.0


class OdometryTopicConfig(TopicConfig):
    """Stream ``odometry``: an Odometry, or where the topic's last part is ``tf``, the transform of ``child`` in
    ``frame``."""

    frame: str = Field(default="odom", description="of a topic tf: the frame where odometry began")
    child: str = Field(default="base_link", description="of a topic tf: the robot's frame")

    @property
    def is_transform(self) -> bool:
        """Whether it is read from transforms."""
        return self.topic.rpartition("/")[2] == "tf"


class LaserTopicConfig(TopicConfig):
    """Stream ``hokuyo``: scans of a planar laser at ``link`` of the model, fixed to the base."""

    link: str
    rate_hz: Positive = 10.0


class BatteryTopicConfig(TopicConfig):
    """Stream ``battery``."""

    rate_hz: Positive = 1.0


class ImuTopicConfig(TopicConfig):
    """Stream ``imu``: an inertial sensor at ``link`` of the model, fixed to the base, along whose axes it measures."""

    link: str
    rate_hz: Positive = 50.0


class CameraTopicConfig(TopicConfig):
    """Stream ``camera``: pictures, raw or compressed, of a camera at ``link`` of the model.

    ``link`` is the camera's optical frame: z ahead, x to the right in its pictures (REP 103). Joints may move it.
    Of a camera that lies on its side, pictures and frame are turned by ``turned_deg``.
    """

    rate_hz: Positive = 15.0
    link: str
    info: Topic | None = Field(default=None, description="its CameraInfo; null: camera_info beside the pictures")
    horizontal_fov_deg: Annotated[float, Field(gt=0, lt=170)] | None = Field(
        default=None, description="of a camera without distortion that has no CameraInfo: none is read then"
    )
    turned_deg: Literal[0, 90, 180, 270] = Field(
        default=0, description="by how much pictures are turned clockwise until they stand upright"
    )
    rectified: bool | None = Field(
        default=None, description="whether the pictures have no distortion any more; null: as their topic's name says"
    )

    @property
    def info_topic(self) -> str | None:
        """The topic of the calibration; None where the mapping has the field of view."""
        if self.horizontal_fov_deg is not None:
            return None
        parts = self.topic.removesuffix("/compressed").split("/")
        return self.info or "/".join((*parts[:-1], "camera_info"))

    @property
    def is_rectified(self) -> bool:
        """Whether pictures have no distortion."""
        return rectified(self.topic) if self.rectified is None else self.rectified


class DepthCameraTopicConfig(CameraTopicConfig):
    """Stream ``kinect``: pictures with ``depth``, which is registered: a pixel of both is the same point."""

    depth: Topic


class TopicsConfig(ConfigModel):
    """The streams of the body; null for one that the robot does not have."""

    odometry: OdometryTopicConfig = OdometryTopicConfig(topic="odom")
    joints: TopicConfig | None = None
    hokuyo: LaserTopicConfig | None = None
    battery: BatteryTopicConfig | None = None
    imu: ImuTopicConfig | None = None
    camera: CameraTopicConfig | None = None
    kinect: DepthCameraTopicConfig | None = None


class BaseTopicConfig(ConfigModel):
    """The topic that the base takes velocities on.

    ``watchdog_s`` is what the robot's own computer does when commands end: after so long (s) it stops the base. It has
    to be stated; null says that there is none, and that the robot drives on where this computer or the network fails.
    """

    topic: Topic = "cmd_vel"
    type: Literal["geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"]
    frame: str = Field(default="base_link", description="frame_id of a TwistStamped")
    rate_hz: Annotated[float, Field(ge=10, le=100)] = Field(default=50.0, description="of the guard, and of commands")
    watchdog_s: Positive | None


class JointTopicConfig(ConfigModel):
    """Where a group of joints takes set-points: a ``topic`` of a controller of ros2_control, or an ``action``.

    A ``JointTrajectory`` is the topic ``joint_trajectory`` of a joint_trajectory_controller: one point, to be reached
    two periods later. A ``Float64MultiArray`` is the topic ``commands`` of a forward_command_controller of positions:
    one number for each joint, in the group's order. An action is a ``control_msgs/action/FollowJointTrajectory``, whose
    goals are such trajectories of one point: each replaces the one before.
    """

    topic: Topic | None = None
    action: Topic | None = None
    type: Literal["trajectory_msgs/msg/JointTrajectory", "std_msgs/msg/Float64MultiArray"] = TRAJECTORY
    rate_hz: Annotated[float, Field(ge=1, le=100)] | None = Field(
        default=None, description="of set-points while they move; null: 20 of a topic, 4 of an action"
    )

    @model_validator(mode="after")
    def _is_one_of_both(self) -> Self:
        if (self.topic is None) == (self.action is None):
            raise ValueError("set-points go to a topic or to an action: name one of them")
        if self.action is not None and "type" in self.model_fields_set:
            raise ValueError(f"type is a topic's; the action {self.action} is a {FOLLOW}")
        return self

    @property
    def hz(self) -> float:
        """How often set-points are sent while they move."""
        return self.rate_hz or (20.0 if self.action is None else 4.0)


class Ros2Config(BodyConfig):
    """A robot that speaks ROS 2. :func:`load_ros2_config` takes paths relative to the file."""

    kind: Literal["ros2"]
    footprint: Annotated[tuple[tuple[float, float], ...], Field(min_length=3, max_length=64)] = Field(
        description="corners (m) in base_link, convex, counter-clockwise, of what it covers"
    )
    graph: GraphConfig = GraphConfig()
    streams: TopicsConfig = TopicsConfig()
    base: BaseTopicConfig
    joint_commands: dict[str, JointTopicConfig] = Field(
        default={}, description="topics and actions by group of actuators"
    )

    _document: Document | None = PrivateAttr(default=None)

    @field_validator("actuators")
    @classmethod
    def _joints_take_positions(cls, actuators: dict[str, ActuatorConfig]) -> dict[str, ActuatorConfig]:
        for name, actuator in actuators.items():
            if {actuator.stale, actuator.stop} != {SafeAction.HOLD}:
                raise ValueError(f"{name}: over ROS 2 joints take positions alone: stale and stop are hold")
            if actuator.compliant or actuator.contact:
                raise ValueError(f"{name}: over ROS 2 joints take positions alone: no compliance, and no contact")
        return actuators

    @model_validator(mode="after")
    def _each_group_has_a_topic(self) -> Self:
        for name in self.joint_commands:
            if name not in self.actuators:
                raise ValueError(f"joint_commands: there is no group {name!r}; {suggestion(name, [*self.actuators])}")
        for name in self.actuators:
            if name not in self.joint_commands:
                raise ValueError(f"actuators: {name} has no topic or action in joint_commands")
        if self.actuators and self.streams.joints is None:
            raise ValueError("actuators: their joints are to be measured: map streams.joints")
        return self

    @model_validator(mode="after")
    def _requires_what_it_has(self) -> Self:
        required = self.limits.required_sensors
        if "odometry" not in required:
            raise ValueError(
                "limits: required_sensors must have odometry, by which it is known whether the robot lives"
            )
        for name in required:
            if name not in self.mapped:
                raise ValueError(f"limits: required_sensors: {name!r} has no topic; {suggestion(name, [*self.mapped])}")
        if self.base.watchdog_s is not None and self.base.watchdog_s <= 1.0 / self.base.rate_hz:
            raise ValueError(
                f"base: watchdog_s {self.base.watchdog_s:g} is no longer than the time between two commands, "
                f"{1.0 / self.base.rate_hz:g} s"
            )
        return self

    @property
    def mapped(self) -> dict[str, TopicConfig]:
        """The streams that have a topic, by name."""
        topics = {name: getattr(self.streams, name) for name in (*TYPES, *CAMERAS)}
        return {name: topic for name, topic in topics.items() if topic is not None}

    @property
    def cameras(self) -> dict[str, CameraTopicConfig]:
        """The streams of pictures, by name."""
        return {name: topic for name, topic in self.mapped.items() if isinstance(topic, CameraTopicConfig)}

    @property
    def fixed_sensors(self) -> dict[str, LaserTopicConfig | ImuTopicConfig]:
        """The streams of sensors whose link is fixed to the base, by name."""
        sensors = {"hokuyo": self.streams.hokuyo, "imu": self.streams.imu}
        return {name: sensor for name, sensor in sensors.items() if sensor is not None}

    @property
    def readings(self) -> dict[str, tuple[str, str]]:
        """Every topic that is read, with its namespace, and its ROS type, by stream; those beside a camera's pictures
        by ``stream.part``."""
        read = {name: (topic.topic, TYPES[name]) for name, topic in self.mapped.items() if name in TYPES}
        if self.streams.odometry.is_transform:
            read["odometry"] = (self.streams.odometry.topic, TRANSFORMS)
        for name, camera in self.cameras.items():
            read[name] = (camera.topic, COMPRESSED_IMAGE if camera.topic.endswith("/compressed") else IMAGE)
            if camera.info_topic is not None:
                read[f"{name}.{INFO}"] = (camera.info_topic, CAMERA_INFO)
            if isinstance(camera, DepthCameraTopicConfig):
                packed = camera.depth.endswith(("/compressed", "/compressedDepth"))
                read[f"{name}.{DEPTH}"] = (camera.depth, COMPRESSED_IMAGE if packed else IMAGE)
        return {name: (self.full_name(topic), kind) for name, (topic, kind) in read.items()}

    @property
    def subscriptions(self) -> dict[str, tuple[str, str]]:
        """:attr:`readings`, and that to ``/clock`` where times are its."""
        clock = {CLOCK: ("/clock", "rosgraph_msgs/msg/Clock")} if self.graph.clock == "sim" else {}
        return self.readings | clock

    @property
    def standing_rates_hz(self) -> tuple[float, float, float]:
        """How often the streams that every body has come: odometry, joints, status."""
        joints = self.streams.joints
        return self.streams.odometry.rate_hz, 1.0 if joints is None else joints.rate_hz, STATUS_HZ

    def full_name(self, topic: str) -> str:
        """``topic`` with the namespace, beginning with /."""
        if topic.startswith("/"):
            return topic
        namespace = self.graph.namespace.strip("/")
        return f"/{namespace}/{topic}" if namespace else f"/{topic}"

    def mistake(self, message: str, *key_path: str) -> ConfigError:
        """A :class:`ConfigError` (to raise) at ``key_path`` of the file that this was read from."""
        sentence = f"{'.'.join(key_path)}: {message}"
        if self._document is None:
            return ConfigError(sentence, key=".".join(key_path))
        return self._document.error(sentence, key_path)


def load_ros2_config(path: Path | str) -> Ros2Config:
    """Read the mapping. Raises ConfigError (file, line, key), also for files that are missing, for a sensor whose link
    the model does not have, for a laser or an inertial sensor that a joint moves, for a camera that one moves whose
    joints are not mapped, and for an action over rosbridge."""
    config = load_body_config(path, Ros2Config)
    document = load_yaml(path)
    config._document = Document(None, document.file, document.lines)
    model = load_model(config.model)
    for name, sensor in config.fixed_sensors.items():
        if joints := _moving(config, model, name, sensor.link):
            what = "laser" if name == "hokuyo" else "inertial sensor"
            raise config.mistake(
                f"the joint {joints[0]!r} of the model moves {sensor.link!r}; the {what} must be fixed to the base",
                *("streams", name, "link"),
            )
    for name, camera in config.cameras.items():
        joints = _moving(config, model, name, camera.link)
        if joints and config.streams.joints is None:
            raise config.mistake(
                f"the joint {joints[0]!r} of the model moves {camera.link!r}; its position is needed: map joints",
                *("streams", name, "link"),
            )
    for name, commands in config.joint_commands.items():
        if config.graph.rosbridge is not None and commands.action is not None:
            raise config.mistake(
                "over rosbridge set-points go to topics alone: name a topic", "joint_commands", name, "action"
            )
    return config


def _moving(config: Ros2Config, model: KinematicModel, stream: str, link: str) -> tuple[str, ...]:
    """The joints that move ``link``. Raises ConfigError where the model does not have it."""
    if link not in model.links:
        raise config.mistake(
            f"the model {config.model} has no link {link!r}; {suggestion(link, model.links)}", "streams", stream, "link"
        )
    return model.moved_by(link)
