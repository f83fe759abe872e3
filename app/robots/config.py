"""Configuration of a body: the models of ``config/robots/*.yaml``."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, field_validator, model_validator

from app.base.kinematic_model import KinematicModel, load_model
from app.base.yaml_source import load_yaml
from app.link import ActuatorGroup, ArmDescription, BaseLimits, JointLimits, SafeAction
from app.robots.battery_config import BatteryConfig
from app.robots.guard import GuardLimits

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]

BASE_GROUP = "base"
"""The group of the wheels, as exploitation names it: it takes velocities, and is no group of joints."""


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class LimitsConfig(_Model):
    """Limits of the base (thesis 4.2), and its deceleration when the guard stops it."""

    linear_mps: Positive = 0.40
    angular_radps: Positive = 1.00
    linear_mps2: Positive = 0.40
    angular_radps2: Positive = 4.00
    emergency_mps2: Annotated[float, Field(gt=0, le=5)] = Field(
        default=2.5, description="braking of a safety stop; the drives' torque limit follows from it"
    )
    command_timeout_s: Annotated[float, Field(gt=0, le=1)] = 0.2
    sensor_timeout_s: Positive = 0.5
    required_sensors: tuple[str, ...] = Field(
        default=("odometry",), description="streams without which the base must not drive"
    )
    lateral_mps: NotNegative = Field(default=0.0, description="sideways; 0: the base cannot, as a differential drive")

    def base(self) -> BaseLimits:
        """Speeds and accelerations alone."""
        return BaseLimits(
            self.linear_mps, self.angular_radps, self.linear_mps2, self.angular_radps2, lateral_mps=self.lateral_mps
        )

    def guard(self) -> GuardLimits:
        """The limits as the guard uses them."""
        return GuardLimits(self.base(), self.command_timeout_s, self.sensor_timeout_s)


def check_footprint(corners: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """``corners`` if they are a convex polygon, counter-clockwise, around the base's origin. Raises ValueError."""
    following = (*corners[1:], corners[0])
    edges = [(bx - ax, by - ay) for (ax, ay), (bx, by) in zip(corners, following, strict=True)]
    if any(math.hypot(*edge) < 1e-6 for edge in edges):
        raise ValueError("two corners that follow each other are the same")
    turns = [ax * by - ay * bx for (ax, ay), (bx, by) in zip(edges, (*edges[1:], edges[0]), strict=True)]
    if all(turn < 0 for turn in turns):
        raise ValueError("the corners go clockwise; name them counter-clockwise, as seen from above")
    around = sum(math.atan2(turn, ax * bx + ay * by) for turn, (ax, ay), (bx, by) in zip(
        turns, edges, (*edges[1:], edges[0]), strict=True
    ))  # fmt: skip
    if any(turn < -1e-9 for turn in turns) or abs(around - 2 * math.pi) > 1e-6:
        raise ValueError("the polygon is not convex: going round it, every corner must turn left")
    if any(ex * -ay - ey * -ax <= 0 for (ax, ay), (ex, ey) in zip(corners, edges, strict=True)):
        raise ValueError("base_link, at (0, 0), does not lie inside it")
    return corners


def circle(radius_m: float, corners: int = 16) -> tuple[tuple[float, float], ...]:
    """A regular polygon around a circle of ``radius_m``: a round body's footprint."""
    reach = radius_m / math.cos(math.pi / corners)
    angles = (2 * math.pi * number / corners for number in range(corners))
    return tuple((round(reach * math.cos(a), 4), round(reach * math.sin(a), 4)) for a in angles)


class ActuatorConfig(_Model):
    """One actuator group of joints: what is commanded together, and what the guard does with it.

    Positions are limited by the model (URDF), speeds by the lower of ``velocity`` and the model's.
    """

    joints: Annotated[tuple[str, ...], Field(min_length=1)] = Field(description="names of movable joints of the model")
    velocity: Positive = Field(default=1.0, description="greatest speed (rad/s, m/s where prismatic)")
    acceleration: Positive = Field(default=5.0, description="greatest acceleration (rad/s^2, m/s^2)")
    stale: SafeAction = Field(default=SafeAction.HOLD, description="without a fresh command: hold, yield or rest")
    stop: SafeAction = Field(default=SafeAction.HOLD, description="in an emergency stop: hold, yield or rest")
    rest: tuple[float, ...] = Field(
        default=(), description="positions (rad) of the action rest, in the order of the joints; none: all 0"
    )
    timeout_s: Annotated[float, Field(gt=0, le=1)] = Field(default=0.25, description="an older command is stale")
    compliant: bool = Field(default=False, description="commands may set stiffness and damping")
    stiffness: NotNegative = Field(default=60.0, description="N m/rad, of a compliant group without a value given")
    damping: NotNegative = Field(default=6.0, description="N m s/rad, likewise")
    stiffness_range: tuple[NotNegative, Positive] = Field(default=(0.0, 300.0), description="that commands may set")
    damping_range: tuple[NotNegative, Positive] = Field(default=(0.5, 40.0), description="that commands may set")
    contact: tuple[Positive, ...] = Field(
        default=(), description="efforts from outside (N m), one for each joint, beyond which the group yields"
    )
    contact_s: Positive = Field(default=0.1, description="how long they must last")
    contact_rest_s: Positive = Field(default=1.0, description="how long it yields, at least")
    kinematic: bool = Field(
        default=False, description="in the simulated world its joints are where the guard sets them, without physics"
    )

    @model_validator(mode="after")
    def _is_within_its_ranges(self) -> Self:
        if self.contact and len(self.contact) != len(self.joints):
            raise ValueError(f"contact has {len(self.contact)} efforts for {len(self.joints)} joints")
        if not self.compliant:
            return self
        ranges = {"stiffness": (self.stiffness, self.stiffness_range), "damping": (self.damping, self.damping_range)}
        for what, (value, (least, most)) in ranges.items():
            if not least <= value <= most:
                raise ValueError(f"{what} {value:g} lies outside its {what}_range, {least:g} to {most:g}")
        return self

    @model_validator(mode="after")
    def _compliance_is_of_physics(self) -> Self:
        if self.kinematic and self.compliant:
            raise ValueError("a kinematic group has no forces, so it cannot be compliant")
        return self

    @model_validator(mode="after")
    def _rests_where_it_does_no_harm(self) -> Self:
        if self.rest and len(self.rest) != len(self.joints):
            raise ValueError(f"rest has {len(self.rest)} positions for {len(self.joints)} joints")
        if SafeAction.REST in (self.stale, self.stop) and not self.kinematic:
            raise ValueError(
                "rest moves joints in an emergency stop: only a kinematic group may, whose parts touch nothing"
            )
        return self

    def group(self, name: str, model: KinematicModel) -> ActuatorGroup:
        """The group's description. Raises ValueError for a joint that the model does not have or that cannot move, and
        for a rest beyond its limits."""
        limits: list[JointLimits] = []
        contacts = self.contact or (math.inf,) * len(self.joints)
        for joint_name, contact in zip(self.joints, contacts, strict=True):
            joint = model.joints.get(joint_name)
            if joint is None or not joint.moves:
                allowed = ", ".join(model.joint_names)
                raise ValueError(f"the model has no movable joint {joint_name!r}; it has {allowed}")
            if joint.velocity <= 0:
                raise ValueError(f"the model's greatest velocity of {joint_name} is 0: it cannot move")
            speed = min(self.velocity, joint.velocity)
            limits.append(
                JointLimits(
                    joint.name, joint.lower, joint.upper, velocity=speed, acceleration=self.acceleration,
                    effort=joint.effort, contact=contact,
                )
            )  # fmt: skip
        for position, joint_limits in zip(self.rest, limits, strict=False):
            if not joint_limits.lower <= position <= joint_limits.upper:
                raise ValueError(
                    f"rest {position:g} of {joint_limits.name} lies outside its limits, {joint_limits.lower:g} to "
                    f"{joint_limits.upper:g}"
                )
        return ActuatorGroup(
            name, tuple(limits), stale=self.stale, stop=self.stop, rest=self.rest, timeout_s=self.timeout_s,
            compliant=self.compliant, stiffness=self.stiffness, damping=self.damping,
            stiffness_range=self.stiffness_range, damping_range=self.damping_range,
            contact_s=self.contact_s, contact_rest_s=self.contact_rest_s,
        )  # fmt: skip


class ArmConfig(_Model):
    """One arm: which groups it is made of, and how it hangs at rest."""

    group: str = Field(description="actuator group of its joints")
    hand: str = Field(description="link of the model that it reaches with")
    gripper: str = Field(
        default="", description="actuator group of its gripper: one joint, closed at its least position"
    )
    rest: tuple[float, ...] = Field(
        default=(), description="positions (rad) at rest, in the group's order; none: all 0"
    )

    def described(self, groups: Mapping[str, ActuatorGroup], model: KinematicModel) -> ArmDescription:
        """The arm's description. Raises ValueError for a group or a link that there is not, and for a rest beyond the
        joints' limits."""
        for group in filter(None, (self.group, self.gripper)):
            if group not in groups:
                raise ValueError(f"there is no actuator group {group!r}; there are {', '.join(groups) or 'none'}")
        joints = groups[self.group].joints
        if self.hand not in model.links:
            raise ValueError(f"the model has no link {self.hand!r}; it has {', '.join(model.links)}")
        if self.gripper and len(groups[self.gripper].joints) != 1:
            raise ValueError(f"{self.gripper} has {len(groups[self.gripper].joints)} joints; a gripper has one")
        rest = self.rest or (0.0,) * len(joints)
        if len(rest) != len(joints):
            raise ValueError(f"rest has {len(rest)} positions for the {len(joints)} joints of {self.group}")
        for joint, position in zip(joints, rest, strict=True):
            if not joint.lower <= position <= joint.upper:
                raise ValueError(f"rest: {position:g} of {joint.name} is not within {joint.lower:g} to {joint.upper:g}")
        return ArmDescription(self.group, self.hand, self.gripper, rest)


class BodyConfig(_Model):
    """Members of every body's file; each kind of body adds its own. Paths are relative to the file."""

    kind: str
    name: str
    model: Path
    program: Path | None = Field(default=None, description="what `hbba run --robot` runs on it")
    footprint: Annotated[tuple[tuple[float, float], ...], Field(max_length=64)] = Field(
        default=(), description="corners (m) in base_link, convex, counter-clockwise; none: it does not move"
    )
    height_m: Positive = Field(default=1.5, description="what hangs higher is not in its way")
    limits: LimitsConfig = LimitsConfig()
    actuators: dict[str, ActuatorConfig] = Field(
        default={}, description="groups of joints that behaviors command, by name (docs/bodies.md)"
    )

    arms: dict[Literal["left", "right"], ArmConfig] = Field(default={}, description="its arms, by side (docs/arms.md)")

    _groups: dict[str, ActuatorGroup] = PrivateAttr(default_factory=dict)
    _arms: dict[str, ArmDescription] = PrivateAttr(default_factory=dict)

    @field_validator("footprint")
    @classmethod
    def _footprint_is_sound(cls, corners: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
        return check_footprint(corners) if corners else corners

    @model_validator(mode="after")
    def _joints_have_one_group(self) -> Self:
        if BASE_GROUP in self.actuators:
            raise ValueError(f"actuators: {BASE_GROUP} is the group of the wheels; name another so")
        owner: dict[str, str] = {}
        for group, actuator in self.actuators.items():
            for joint in actuator.joints:
                if joint in owner:
                    raise ValueError(f"actuators: {joint} is in {owner[joint]} already; it cannot be in {group}, too")
                owner[joint] = group
        return self

    @property
    def groups(self) -> Mapping[str, ActuatorGroup]:
        """The actuator groups of joints with the model's limits, by name, as :func:`load_body_config` found them."""
        return self._groups

    @property
    def arm_descriptions(self) -> Mapping[str, ArmDescription]:
        """The arms by side, as :func:`load_body_config` found them."""
        return self._arms

    @property
    def standing_rates_hz(self) -> tuple[float, float, float]:
        """How often the streams that every body has come: odometry, joints, status."""
        return 100.0, 30.0, 20.0

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that its own names and a recording must have to be understood."""
        return (self.model,)


class BaseConfig(_Model):
    """Drive of the base, and its errors.

    A ``differential`` drive turns its two wheels. A ``holonomic`` one moves at any velocity in the plane, by forces at
    the floor; its wheels are those of the model, and roll freely. It measures its motion in ``odometry`` with the
    errors of radius and track as those of length and turn.

    ``wheel_radius_m`` and ``track_m`` are the nominal values that odometry computes with. The errors are fractions of
    them (1-sigma, drawn once per start from the seed); ``slip`` is the 1-sigma fraction by which each wheel slips,
    wandering with the distance it rolls; ``encoder_ticks`` counts one turn of a wheel.
    """

    drive: Literal["differential", "holonomic"] = "differential"
    left_wheel_joint: str = "left_wheel_joint"
    right_wheel_joint: str = "right_wheel_joint"
    wheel_radius_m: Positive = 0.10
    track_m: Positive = 0.44
    radius_error: NotNegative = 0.003
    track_error: NotNegative = 0.006
    slip: NotNegative = 0.004
    encoder_ticks: Annotated[int, Field(ge=16)] = 8192


class OdometryConfig(_Model):
    """Stream ``odometry``."""

    rate_hz: Positive = 100.0


class JointsConfig(_Model):
    """Stream ``joints``: measured with ``noise_rad`` and ``noise_nm`` (1-sigma; m and N where prismatic)."""

    rate_hz: Positive = 30.0
    noise_rad: NotNegative = 0.0005
    noise_nm: NotNegative = 0.05


class HokuyoConfig(_Model):
    """Stream ``hokuyo``: a UTM-30LX read over its forward 180 degrees (thesis 4.2)."""

    rate_hz: Positive = 40.0
    link: str = "hokuyo_link"
    rays: Annotated[int, Field(ge=2)] = 720
    fov_deg: Annotated[float, Field(gt=0, le=360)] = 180.0
    range_min_m: NotNegative = 0.1
    range_max_m: Positive = 30.0
    noise_m: NotNegative = 0.01
    sweep_s: NotNegative = Field(default=0.0125, description="time from the first ray to the last")


class KinectConfig(_Model):
    """Stream ``kinect``: colour with registered depth (thesis 4.2).

    Depth noise is ``noise_floor_m + noise_slope * (z - 0.4)^2`` (1-sigma, m; Nguyen, Izadi and Lovell 2012);
    depths are quantised as the sensor's disparity is, ``quantum_m`` at 1 m and growing with z^2 (Khoshelham and
    Elberink 2012); ``baseline_m`` between projector and camera makes the shadows beside near things.
    """

    rate_hz: Positive = 15.0
    link: str = "kinect_optical_frame"
    width: Annotated[int, Field(ge=16, le=1920)] = 640
    height: Annotated[int, Field(ge=16, le=1080)] = 480
    fov_deg: tuple[float, float] = (57.0, 43.0)
    range_min_m: Positive = 0.4
    range_max_m: Positive = 5.0
    noise_floor_m: NotNegative = 0.0012
    noise_slope: NotNegative = 0.0019
    quantum_m: Positive = 0.00285
    baseline_m: NotNegative = 0.075
    color_noise: NotNegative = Field(default=2.0, description="1-sigma, grey levels")


class PanoramicCameraConfig(_Model):
    """Stream ``panorama``: colour of the full hemisphere in front, through an equidistant fisheye (thesis 4.2).

    The lens stretches the circle to fill the sensor, as panomorph lenses do: ``fov_deg`` are the full horizontal and
    vertical fields of view along the image's middle lines.
    """

    rate_hz: Positive = 10.0
    link: str = "panorama_optical_frame"
    width: Annotated[int, Field(ge=16, le=4096)] = 1024
    height: Annotated[int, Field(ge=16, le=4096)] = 768
    fov_deg: tuple[Annotated[float, Field(gt=0, le=180)], Annotated[float, Field(gt=0, le=180)]] = (180.0, 180.0)
    color_noise: NotNegative = Field(default=2.0, description="1-sigma, grey levels")


class MicrophonesConfig(_Model):
    """Stream ``microphones``: frames of samples taken together (thesis 4.2).

    ``positions`` (m) are in ``link``. ``noise_db`` is a microphone's own noise, ``sensitivity_db`` the level at 1 m of
    a talker of ordinary loudness (65 dB SPL there), both in dB of full scale. ``fans_db`` and ``wheels_db`` are the
    levels there of the robot's fans, and of its wheels at 0.4 m/s. ``shadow``: whether the torso is modelled as a rigid
    sphere with the microphones on its surface; without it they are in a free field.
    """

    rate: Annotated[int, Field(ge=8000, le=192000)] = 48000
    frame_samples: Annotated[int, Field(ge=64, le=8192)] = 512
    link: str = "torso_link"
    positions: Annotated[tuple[tuple[float, float, float], ...], Field(min_length=1, max_length=32)] = (
        (0.085, 0.11, 0.46), (0.085, -0.11, 0.46), (-0.085, -0.11, 0.46), (-0.085, 0.11, 0.46),
        (0.085, 0.11, 0.25), (0.085, -0.11, 0.25), (-0.085, -0.11, 0.25), (-0.085, 0.11, 0.25),
    )  # fmt: skip
    noise_db: float = -75.0
    fans_db: float = -62.0
    wheels_db: float = -52.0
    sensitivity_db: float = -32.0
    shadow: bool = True


class LoudspeakerConfig(_Model):
    """The robot's loudspeaker, ``position`` (m) in ``link``; ``gain_db`` is its level at 1 m for a full-scale sound."""

    link: str = "torso_link"
    position: tuple[float, float, float] = (0.1, 0.0, 0.36)
    gain_db: float = -20.0


class StatusConfig(_Model):
    """Streams ``status`` and, where configuration turns it on, ``ground_truth``."""

    rate_hz: Positive = 20.0


class StreamsConfig(_Model):
    """Every stream of the body; null for a missing sensor."""

    odometry: OdometryConfig = OdometryConfig()
    joints: JointsConfig = JointsConfig()
    status: StatusConfig = StatusConfig()
    kinect: KinectConfig | None = KinectConfig()
    hokuyo: HokuyoConfig | None = HokuyoConfig()
    panorama: PanoramicCameraConfig | None = None
    microphones: MicrophonesConfig | None = None


class StartPose(_Model):
    """Start pose of the body: metres and degrees in the world."""

    x: float = 0.0
    y: float = 0.0
    heading_deg: float = 0.0


class RobotConfig(BodyConfig):
    """One simulated body. :func:`load_robot_config` takes ``world`` and ``scenario``, too, relative to the file."""

    kind: Literal["simulated"] = "simulated"
    name: str = "IRL-1/TR"
    world: Path
    footprint: Annotated[tuple[tuple[float, float], ...], Field(min_length=3, max_length=64)] = Field(
        default=circle(0.28), description="corners (m) in base_link, convex, counter-clockwise, of what it covers"
    )
    base: BaseConfig = BaseConfig()
    streams: StreamsConfig = StreamsConfig()
    loudspeaker: LoudspeakerConfig | None = None
    battery: BatteryConfig | None = Field(default=None, description="null: a body without stream battery")
    scenario: Path | None = Field(default=None, description="who and what else is in the world (config/scenarios)")
    ground_truth: bool = Field(default=False, description="offer the true pose, for tests and experiments only")
    seed: int = 1
    start: StartPose = StartPose()
    guard_log: Path | None = Field(
        default=None, description="record every step of the guard in this file (guard_log.py)"
    )

    @model_validator(mode="after")
    def _drive_has_its_limits(self) -> Self:
        sideways = self.limits.lateral_mps > 0
        if sideways and self.base.drive == "differential":
            raise ValueError("limits: lateral_mps is 0 for a differential drive; or set base.drive to holonomic")
        if not sideways and self.base.drive == "holonomic":
            raise ValueError("limits: a holonomic drive has a lateral_mps above 0; or set base.drive to differential")
        return self

    @model_validator(mode="after")
    def _wheels_are_the_bases(self) -> Self:
        for group, actuator in self.actuators.items():
            for joint in {self.base.left_wheel_joint, self.base.right_wheel_joint}.intersection(actuator.joints):
                raise ValueError(f"actuators: {joint} is a wheel of the base; it cannot be in {group}")
        return self

    @property
    def standing_rates_hz(self) -> tuple[float, float, float]:
        """How often the streams that every body has come: odometry, joints, status."""
        return self.streams.odometry.rate_hz, self.streams.joints.rate_hz, self.streams.status.rate_hz

    @property
    def kinematic_joints(self) -> tuple[str, ...]:
        """The joints of all groups that take no part in the physics."""
        return tuple(joint for actuator in self.actuators.values() if actuator.kinematic for joint in actuator.joints)

    @property
    def files(self) -> tuple[Path, ...]:
        """Model and world, and the scenario if it has one."""
        return (self.model, self.world, *((self.scenario,) if self.scenario is not None else ()))


BodyT = TypeVar("BodyT", bound=BodyConfig)


def load_body_config(path: Path | str, model: type[BodyT], *files: str) -> BodyT:
    """Read a body's file as a ``model``; ``model``, ``program`` and the keys ``files`` are made absolute.

    Raises ConfigError (file, line, key), also for a file that is missing.
    """
    document = load_yaml(path)
    config = document.validate(model)
    here = Path(path).resolve().parent
    paths: dict[str, Path] = {}
    for key in ("model", "program", *files):
        if (named := getattr(config, key)) is not None:
            paths[key] = (here / named).resolve()
            if not paths[key].is_file():
                raise document.error(f"{key}: there is no file {paths[key]}", (key,))
    config = config.model_copy(update=paths)
    if config.actuators or config.arms:
        kinematics = load_model(config.model)
        for name, actuator in config.actuators.items():
            try:
                config._groups[name] = actuator.group(name, kinematics)
            except ValueError as failure:
                key_path = ("actuators", name, "joints")
                raise document.error(f"{'.'.join(key_path)}: {failure}", key_path) from None
        for side, arm in config.arms.items():
            try:
                config._arms[side] = arm.described(config.groups, kinematics)
            except ValueError as failure:
                raise document.error(f"arms.{side}: {failure}", ("arms", side)) from None
    return config


def load_robot_config(path: Path | str) -> RobotConfig:
    """Read ``config/robots/<name>.yaml``; raises ConfigError (file, line, key), also for files that are missing."""
    return load_body_config(path, RobotConfig, "world", "scenario")
