"""Maps topics of a bag recorded by others to our channels: a small YAML file.

Example::

    frames: {base: base_link, odom: odom}
    channels:
      kinect: {color: /camera/rgb/image_raw/compressed, depth: /camera/depth_registered/image_raw}
      scan: {topic: /scan, X_BL: {xyz: [0.2, 0, 0.3]}}
      odometry: {tf: odom -> base_link}
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, field_validator, model_validator

from app.base.errors import ConfigError
from app.base.geometry import Pose3
from app.base.yaml_source import Document, load_yaml
from app.logs.log import LogError, LogInfo

_ARROW = re.compile(r"\s*(\S+)\s*->\s*(\S+)\s*")
TopicName = Annotated[str, Field(min_length=1)]


class RemapError(LogError):
    """A sound log, of which it is not said what its channels are, or said though it says so itself."""


class Undecided(RemapError):
    """A bag in which several topics could be one channel. ``info`` is what else is known of it; it has no channels."""

    def __init__(self, message: str, info: LogInfo) -> None:
        super().__init__(message)
        self.info = info


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


@dataclass(frozen=True, slots=True)
class FixedSensor:
    """A sensor at ``pose`` in the tf frame ``frame``, which may move; "" for the base."""

    pose: Pose3
    frame: str = ""


class Placement(_Model):
    """Pose of a sensor in ``frame``, by default the base: metres, and fixed-axis roll, pitch, yaw in degrees. Where tf
    moves ``frame``, as a head does, the sensor moves with it.

    For a camera this is its *optical* frame (x right, y down, z forward): one that looks ahead has ``rpy_deg: [-90, 0,
    -90]``.
    """

    xyz: tuple[float, float, float]
    rpy_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    frame: str = Field(default="", description="the frame of tf that the sensor is fixed to; by default the base")

    def fixed(self) -> FixedSensor:
        """Where the sensor is fixed."""
        roll, pitch, yaw = (math.radians(angle) for angle in self.rpy_deg)
        return FixedSensor(Pose3.from_translation_rpy(self.xyz, (roll, pitch, yaw)), self.frame.lstrip("/"))


class Frames(_Model):
    """Names of frames in the bag; null: ``base_link`` or ``base_footprint``, whichever there is, and ``odom``."""

    base: str | None = None
    odom: str | None = None


class RemapSource(_Model):
    """The origin of a channel: one ``topic``, a transform (``tf: odom -> base_link``), or a camera's topics."""

    topic: TopicName | None = None
    tf: str | None = None
    color: TopicName | None = None
    depth: TopicName | None = None
    info: TopicName | None = None
    X_BC: Placement | None = Field(default=None, description="the camera's optical frame in the base, if tf lacks it")
    X_BL: Placement | None = Field(default=None, description="the laser in the base, if tf lacks it")
    tolerance_s: Annotated[float, Field(gt=0)] | None = Field(
        default=None, description="how far apart colour and depth may be; by default half of the colour's period"
    )

    @field_validator("tf")
    @classmethod
    def _two_frames(cls, value: str | None) -> str | None:
        if value is not None and _ARROW.fullmatch(value) is None:
            raise ValueError("a transform is written as two frames, such as `odom -> base_link`")
        return value

    @model_validator(mode="after")
    def _one_kind(self) -> RemapSource:
        if [self.topic, self.tf, self.color].count(None) != 2:
            raise ValueError("exactly one of `topic`, `tf` and `color` says where a channel comes from")
        for_cameras = {"depth", "info", "X_BC", "tolerance_s"} & self.model_fields_set
        if self.color is None and for_cameras:
            raise ValueError(f"{', '.join(sorted(for_cameras))} only goes with `color`")
        if self.topic is None and self.X_BL is not None:
            raise ValueError("X_BL only goes with `topic`")
        return self

    @property
    def frames(self) -> tuple[str, str]:
        """Parent and child of ``tf``. Raises ValueError without one."""
        found = _ARROW.fullmatch(self.tf or "")
        if found is None:
            raise ValueError("this channel does not come from tf")
        return found[1], found[2]


class Remap(_Model):
    """The whole file. Made in memory it has no lines to name in errors; :func:`load_remap` gives it them."""

    frames: Frames = Frames()
    channels: Mapping[str, RemapSource] = Field(default_factory=dict)
    _document: Document | None = PrivateAttr(default=None)

    def error(self, message: str, key_path: Sequence[str | int]) -> ConfigError:
        """An error (to raise) that points at ``key_path`` of the file."""
        return self._document.error(message, key_path) if self._document is not None else ConfigError(message)


def load_remap(path: Path | str) -> Remap:
    """Read a remap file. Raises ConfigError (file, line, key)."""
    document = load_yaml(path)
    remap = document.validate(Remap)
    remap._document = document
    return remap
