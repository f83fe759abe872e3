"""A robot of parts: the models of ``config/robots/serial_base.yaml`` and its like."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, PrivateAttr, field_validator, model_validator

from app.base.errors import ConfigError
from app.base.kinematic_model import KinematicModel, load_model
from app.base.yaml_source import Document, load_yaml, suggestion
from app.robots.actuator_config import ActuatorConfig
from app.robots.config import BodyConfig, load_body_config
from app.robots.config_model import ConfigModel, Positive
from app.robots.devices.config import CameraConfig, SoundInputConfig, SpeakerConfig, with_sources
from app.robots.drivers.gamepad import GamepadSetting
from app.robots.drivers.hokuyo import LaserSetting
from app.robots.drivers.input_events import AXES, BUTTONS
from app.robots.drivers.port import SerialAddress, TcpAddress, address
from app.robots.drivers.serial_base import BaseSetting

STATUS_HZ = 20.0
#: Streams that a base gives.
_OF_BASE = ("odometry", "joints", "battery")


class PortConfig(ConfigModel):
    """Where a device is: a serial line (its name by id stays, whatever is plugged in first), or ``tcp://IP:PORT``."""

    port: str
    baud: int = Field(default=115200, description="bits a second; of no meaning for a device with USB of its own")

    @model_validator(mode="after")
    def _is_an_address(self) -> Self:
        address(self.port, self.baud)
        return self

    @property
    def address(self) -> SerialAddress | TcpAddress:
        """The same, read."""
        return address(self.port, self.baud)


class SerialBaseConfig(PortConfig):
    """A differential base that speaks the protocol of docs/serial-base.md.

    ``timeout_s`` is its watchdog: it goes along with each command, and the base stops by itself when it has had no
    other for so long.
    """

    rate_hz: Annotated[float, Field(ge=20, le=100)] = Field(default=50.0, description="of the guard, and of commands")
    timeout_s: Annotated[float, Field(ge=0.05, le=1)] = 0.2
    odometry_hz: Positive = Field(default=50.0, description="how often the base says its counts")
    ticks_per_m: Positive | None = Field(default=None, description="counts of a metre; null: as the base says")
    track_m: Positive | None = Field(default=None, description="between the wheels; null: as the base says")
    wheel_joints: tuple[str, str] | None = Field(default=None, description="of the model: left, right")
    wheel_radius_m: Positive = 0.1

    @model_validator(mode="after")
    def _outlasts_a_period(self) -> Self:
        if self.timeout_s < 2.0 / self.rate_hz:
            raise ValueError(
                f"timeout_s {self.timeout_s:g} is shorter than two periods of the commands, {2.0 / self.rate_hz:g} s"
            )
        return self

    @property
    def setting(self) -> BaseSetting:
        """As the driver takes it."""
        return BaseSetting(
            self.timeout_s,
            ticks_per_m=self.ticks_per_m,
            track_m=self.track_m,
            wheels=self.wheel_joints,
            wheel_radius_m=self.wheel_radius_m,
        )


class HokuyoPortConfig(PortConfig):
    """Stream ``hokuyo``: a Hokuyo laser of SCIP 2, at ``link`` of the model, fixed to the base."""

    link: str = "hokuyo_link"
    rate_hz: Positive = Field(default=40.0, description="scans a second, by which filters count")
    fov_deg: Annotated[float, Field(gt=1, le=360)] | None = Field(
        default=None, description="about the front; null: all that it sees"
    )
    characters: Literal[2, 3] = Field(default=3, description="of a distance; 2 hold up to 4.095 m")
    intensities: bool = False
    latency_s: Annotated[float, Field(ge=0, le=0.5)] = Field(
        default=0.0, description="from the end of a sweep to its first byte, where it was measured"
    )

    @model_validator(mode="after")
    def _has_room_for_intensities(self) -> Self:
        if self.intensities and self.characters != 3:
            raise ValueError("intensities come with 3 characters alone")
        return self

    @property
    def setting(self) -> LaserSetting:
        """As the driver takes it."""
        return LaserSetting(
            self.link,
            fov_rad=None if self.fov_deg is None else math.radians(self.fov_deg),
            characters=self.characters,
            intensities=self.intensities,
            latency_s=self.latency_s,
        )


def _is_button(name: str) -> str:
    if name not in BUTTONS:
        raise ValueError(f"there is no button {name!r}; {suggestion(name, list(BUTTONS))}")
    return name


def _is_axis(name: str) -> str:
    if name not in AXES:
        raise ValueError(f"there is no axis {name!r}; {suggestion(name, list(AXES))}")
    return name


Button = Annotated[str, AfterValidator(_is_button)]
Axis = Annotated[str, AfterValidator(_is_axis)]


class GamepadConfig(ConfigModel):
    """A gamepad that is plugged in at the robot: it drives while ``dead_man`` is held."""

    port: str = Field(pattern=r"^/", description="its file of events, as /dev/input/by-id/...-event-joystick")
    dead_man: Button = "BTN_TL"
    stop: Button | None = Field(default="BTN_EAST", description="the emergency stop; null: none")
    linear: Axis = "ABS_Y"
    angular: Axis = "ABS_RX"
    lateral: Axis | None = None
    invert: tuple[Axis, ...] = Field(default=(), description="axes that count up or to the left")
    rest: Annotated[float, Field(ge=0, lt=0.9)] = Field(default=0.1, description="share of a stick's way that is none")

    @model_validator(mode="after")
    def _buttons_differ(self) -> Self:
        if self.stop == self.dead_man:
            raise ValueError(f"stop and dead_man are both {self.stop}")
        return self

    @property
    def setting(self) -> GamepadSetting:
        """As the driver takes it."""
        return GamepadSetting(
            self.dead_man,
            self.stop or "",
            linear=self.linear,
            angular=self.angular,
            lateral=self.lateral or "",
            invert=self.invert,
            rest=self.rest,
        )


class DriversConfig(BodyConfig):
    """A robot of parts. :func:`load_drivers_config` takes paths relative to the file."""

    kind: Literal["drivers"]
    footprint: Annotated[tuple[tuple[float, float], ...], Field(min_length=3, max_length=64)] = Field(
        description="corners (m) in base_link, convex, counter-clockwise, of what it covers"
    )
    base: SerialBaseConfig
    hokuyo: HokuyoPortConfig | None = None
    gamepad: GamepadConfig | None = None
    camera: CameraConfig | None = None
    microphones: SoundInputConfig | None = None
    loudspeaker: SpeakerConfig | None = None
    found_within_s: Annotated[float, Field(gt=0, le=600)] = Field(
        default=10.0, description="how long the parts that driving requires may take to answer at the start"
    )

    _document: Document | None = PrivateAttr(default=None)

    @field_validator("actuators")
    @classmethod
    def _joints_are_not_commanded(cls, actuators: dict[str, ActuatorConfig]) -> dict[str, ActuatorConfig]:
        if actuators:
            raise ValueError("a robot of parts has no motors but its wheels; leave the actuators out")
        return actuators

    @model_validator(mode="after")
    def _requires_what_it_has(self) -> Self:
        if self.limits.lateral_mps > 0:
            raise ValueError("limits: lateral_mps is 0: a differential base does not move sideways")
        required = self.limits.required_sensors
        if "odometry" not in required:
            raise ValueError("limits: required_sensors must have odometry, by which it is known whether the base lives")
        has = [*_OF_BASE, *(["hokuyo"] if self.hokuyo is not None else [])]
        for name in required:
            if name not in has:
                raise ValueError(f"limits: required_sensors: there is no {name!r}; {suggestion(name, has)}")
        return self

    @property
    def standing_rates_hz(self) -> tuple[float, float, float]:
        """How often the streams that every body has come: odometry, joints, status."""
        return self.base.odometry_hz, 1.0 if self.base.wheel_joints is None else self.base.odometry_hz, STATUS_HZ

    def mistake(self, message: str, *key_path: str) -> ConfigError:
        """A :class:`ConfigError` (to raise) at ``key_path`` of the file that this was read from."""
        sentence = f"{'.'.join(key_path)}: {message}"
        if self._document is None:
            return ConfigError(sentence, key=".".join(key_path))
        return self._document.error(sentence, key_path)


def load_drivers_config(path: Path | str) -> DriversConfig:
    """Read the file. Raises ConfigError (file, line, key), also for files that are missing, for a part whose link the
    model does not have or a joint moves, and for wheels that it does not have."""
    config = with_sources(load_body_config(path, DriversConfig), path)
    document = load_yaml(path)
    config._document = Document(None, document.file, document.lines)
    model = load_model(config.model)
    for part in ("hokuyo", "camera", "microphones"):
        if (device := getattr(config, part)) is not None:
            _check_link(config, model, part, device.link)
    for joint in config.base.wheel_joints or ():
        if joint not in model.joint_names:
            raise config.mistake(
                f"the model {config.model} has no moving joint {joint!r}; {suggestion(joint, model.joint_names)}",
                *("base", "wheel_joints"),
            )
    return config


def _check_link(config: DriversConfig, model: KinematicModel, part: str, link: str) -> None:
    if link not in model.links:
        raise config.mistake(
            f"the model {config.model} has no link {link!r}; {suggestion(link, model.links)}", part, "link"
        )
    if joints := model.moved_by(link):
        raise config.mistake(
            f"the joint {joints[0]!r} of the model moves {link!r}; it must be fixed to the base", part, "link"
        )
