"""Configuration of a body: the models of ``config/robots/*.yaml``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, Self, TypeVar

from pydantic import Field, PrivateAttr, field_validator, model_validator

from app.base.kinematic_model import load_model
from app.base.yaml_source import load_yaml
from app.link import ActuatorGroup, ArmDescription
from app.robots.actuator_config import BASE_GROUP, ActuatorConfig, ArmConfig, LimitsConfig, check_footprint, circle
from app.robots.battery_config import BatteryConfig
from app.robots.config_model import ConfigModel, Positive
from app.robots.stream_config import (
    BaseConfig,
    LoudspeakerConfig,
    StreamsConfig,
)


class BodyConfig(ConfigModel):
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


class StartPose(ConfigModel):
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
