"""Configuration of a body of devices: the models of ``config/robots/webcam.yaml`` and its like."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from app.robots.actuator_config import ActuatorConfig, LimitsConfig
from app.robots.config import BodyConfig, BodyT, load_body_config
from app.robots.config_model import ConfigModel, Positive

#: Rate (Hz) of the odometry of bodies without wheels.
ODOMETRY_HZ, JOINTS_HZ, STATUS_HZ = 20.0, 5.0, 20.0


def _number(source: Any, whose: str) -> Any:
    """``source`` as a device number where it is one. Raises ValueError for an impossible number."""
    text = str(source)
    if text.startswith("-") and text[1:].isdecimal():
        raise ValueError(f"{whose} number is from 0")
    return int(text) if isinstance(source, str) and text.isdecimal() else source


class CameraConfig(ConfigModel):
    """Stream ``camera``: colour without depth.

    ``source``: a camera's number (0 is the first) or device, a video file, an image, or a folder of images. Files are
    read at ``rate_hz`` (none: a video's own rate, 15 Hz for images), repeatedly unless ``loop`` is off; each image is
    shown for ``seconds_each``, so that a decimated subscriber gets all of them. ``width`` and ``height`` are requested
    of a camera, which may use others.
    """

    source: int | str = 0
    rate_hz: Positive | None = None
    seconds_each: Annotated[float, Field(gt=0, le=3600)] = 1.5
    width: Annotated[int, Field(ge=16, le=7680)] = 640
    height: Annotated[int, Field(ge=16, le=4320)] = 480
    horizontal_fov_deg: Annotated[float, Field(gt=1, lt=170)] = 60.0
    link: str = "camera_optical_frame"
    loop: bool = True

    @field_validator("source", mode="before")
    @classmethod
    def _of_device(cls, source: Any) -> Any:
        return _number(source, "a camera's")


class SoundInputConfig(ConfigModel):
    """Stream ``microphones``: frames of samples of all channels, 16 bit.

    ``source`` is ``default``, the name or number of an input of this computer, or a sound file (1 to 8 channels; at its
    own rate, over again when it is through unless ``loop`` is off). ``positions`` (m) are the microphones' in ``link``;
    none: all at its origin, which is enough to hear but not to locate.
    """

    source: int | str = "default"
    rate: Annotated[int, Field(ge=8000, le=192000)] = 48000
    frame_samples: Annotated[int, Field(ge=64, le=8192)] = 512
    channels: Annotated[int, Field(ge=1, le=32)] = 1
    positions: tuple[tuple[float, float, float], ...] | None = None
    link: str = "microphone_link"
    loop: bool = True

    @field_validator("source", mode="before")
    @classmethod
    def _of_device(cls, source: Any) -> Any:
        return _number(source, "an input's")


class SpeakerConfig(ConfigModel):
    """The loudspeaker: ``default``, or the name or number of an output of this computer."""

    source: int | str = "default"


class DevicesConfig(BodyConfig):
    """One body of devices. :func:`load_devices_config` takes ``model``, ``program`` and files relative to its file."""

    kind: Literal["devices"]
    name: str = "This computer"
    camera: CameraConfig | None = None
    microphones: SoundInputConfig | None = None
    loudspeaker: SpeakerConfig | None = None
    #: Nothing moves; limits are positive by contract.
    limits: LimitsConfig = LimitsConfig(linear_mps=1e-3, angular_radps=1e-3, linear_mps2=1e-3, angular_radps2=1e-3)

    @field_validator("actuators")
    @classmethod
    def _nothing_moves(cls, actuators: dict[str, ActuatorConfig]) -> dict[str, ActuatorConfig]:
        if actuators:
            raise ValueError("a body of devices has no motors; leave its actuators out, or write a body (extending.md)")
        return actuators

    @property
    def standing_rates_hz(self) -> tuple[float, float, float]:
        """Rates (Hz) of the streams that every body has: odometry, joints, status."""
        return ODOMETRY_HZ, JOINTS_HZ, STATUS_HZ


def load_devices_config(path: Path | str) -> DevicesConfig:
    """Read the file; raises ConfigError (file, line, key), also for a model or a program that is missing.

    Source files are relative to the configuration file; missing ones are reported on opening.
    """
    return with_sources(load_body_config(path, DevicesConfig), path)


def with_sources(config: BodyT, path: Path | str) -> BodyT:
    """``config`` with the files that camera and microphones name, where they exist, relative to its file ``path``."""
    here = Path(path).resolve().parent
    update: dict[str, Any] = {}
    for key in ("camera", "microphones"):
        device = getattr(config, key)
        if device is not None and isinstance(device.source, str) and (here / device.source).exists():
            update[key] = device.model_copy(update={"source": str((here / device.source).resolve())})
    return config.model_copy(update=update)
