"""Configuration of a kinematic body."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from app.base.errors import ConfigError
from app.base.kinematic_model import load_model
from app.robots.actuator_config import circle
from app.robots.config import BodyConfig, StartPose, load_body_config
from app.robots.config_model import Positive
from app.robots.stream_config import HokuyoConfig


class KinematicLaserConfig(HokuyoConfig):
    """Stream ``hokuyo``: as the simulated lab's, with as many rays and scans as suffice to drive by.

    ``nominal_hz`` is the rate of the laser that it replaces, by which filters count; ``rate_hz`` is given of it.
    """

    rate_hz: Positive = 10.0
    nominal_hz: Positive = 40.0
    rays: Annotated[int, Field(ge=2)] = 361
    range_max_m: Positive = 12.0
    noise_m: Annotated[float, Field(ge=0)] = 0.0
    sweep_s: Annotated[float, Field(ge=0)] = 0.0


class KinematicConfig(BodyConfig):
    """A kinematic body: it moves as it is commanded, within its limits, and stops before what the map has.

    :func:`load_kinematic_config` takes ``model``, ``map`` and ``scenario`` relative to the file.
    """

    kind: Literal["kinematic"]
    map: Path = Field(description="YAML file of a map that was kept")
    footprint: Annotated[tuple[tuple[float, float], ...], Field(min_length=3, max_length=64)] = Field(
        default=circle(0.28), description="corners (m) in base_link, convex, counter-clockwise, of what it covers"
    )
    start: StartPose = Field(default=StartPose(), description="on the map: m, degrees")
    scenario: Path | None = Field(default=None, description="the people on the map, at places of the map")
    laser: KinematicLaserConfig | None = KinematicLaserConfig()
    rate_hz: Annotated[float, Field(ge=10, le=250)] = Field(
        default=20.0, description="of its steps, and of odometry and ground truth"
    )
    joints_hz: Positive = 10.0
    status_hz: Positive = 5.0

    @property
    def standing_rates_hz(self) -> tuple[float, float, float]:
        """How often the streams that every body has come: odometry, joints, status."""
        return self.rate_hz, min(self.joints_hz, self.rate_hz), min(self.status_hz, self.rate_hz)

    @property
    def files(self) -> tuple[Path, ...]:
        """Model and map, and the scenario if it has one."""
        return (self.model, self.map, *((self.scenario,) if self.scenario is not None else ()))


def load_kinematic_config(path: Path | str) -> KinematicConfig:
    """Read a kinematic body's file. Raises ConfigError (file, line, key), also for files that are missing."""
    config = load_body_config(path, KinematicConfig, "map", "scenario")
    check_laser(config)
    return config


def kinematic_of(body: BodyConfig, map_file: Path, start: StartPose, **more: Any) -> KinematicConfig:
    """The body ``body`` without physics, at ``start`` on the map of ``map_file``; ``more``: further members.

    Its laser is where ``body``'s simulated one is. Raises ConfigError for a body that cannot drive.
    """
    if len(body.footprint) < 3:
        raise ConfigError(f"{body.name} covers no floor: a body without a footprint cannot drive")
    shared: Mapping[str, Any] = {
        name: getattr(body, name) for name in ("name", "model", "footprint", "height_m", "limits", "actuators", "arms")
    }
    if (laser := getattr(getattr(body, "streams", None), "hokuyo", None)) is not None:
        # A robot's mapping does not say how far its laser sees around.
        seen = {"fov_deg": laser.fov_deg} if isinstance(laser, HokuyoConfig) else {}
        more = {"laser": KinematicLaserConfig(link=laser.link, **seen), **more}
    config = KinematicConfig(kind="kinematic", map=map_file, start=start, **shared, **more)
    config._groups.update(body.groups)
    config._arms.update(body.arm_descriptions)
    check_laser(config)
    return config


def check_laser(config: KinematicConfig) -> None:
    """Raise ConfigError unless the model has the laser's link, fixed to the base."""
    if config.laser is None:
        return
    model = load_model(config.model)
    if config.laser.link not in model.links:
        raise ConfigError(f"has no link {config.laser.link!r} for the laser of {config.name}", str(config.model))
    if joints := model.moved_by(config.laser.link):
        raise ConfigError(
            f"moves {config.laser.link!r} by the joint {joints[0]!r}; a laser must be fixed to the base",
            str(config.model),
        )
