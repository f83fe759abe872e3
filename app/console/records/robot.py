"""The robot: what it is, its guard, where it is and what it has found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from app.link import BaseLimits
from app.messages import BatteryState
from app.messages.base import Stamp, doc
from app.runtime.module import Caution


@dataclass(frozen=True, slots=True)
class RobotFacts:
    """The body and its limits."""

    name: str
    called: Annotated[str, doc("What this robot is called among others (`console.name`); its `name` without one.")]
    simulated: bool
    replayed: Annotated[bool, doc("Whether it is the body of a replay: it can neither be driven nor stopped.")]
    limits: BaseLimits
    footprint: Annotated[
        tuple[tuple[float, float], ...],
        doc("Corners of its outline (m, in base_link), counter-clockwise; empty for one that does not move."),
    ]
    cautions: tuple[Caution, ...]


@dataclass(frozen=True, slots=True)
class Velocity:
    """Forward m/s, turn rad/s and sideways m/s (left positive)."""

    linear_mps: float
    angular_radps: float
    lateral_mps: float = 0.0


@dataclass(frozen=True, slots=True)
class Guard:
    """State of the guard."""

    state: Annotated[str, doc("idle, driving, stale_command, e_stopped, sensor_failure, waiting or silent.")]
    reason: str
    e_stopped: bool
    command_age_ms: float | None
    applied: Velocity


@dataclass(frozen=True, slots=True)
class GroupReport:
    """State of the guard of one group of joints."""

    group: Annotated[str, doc("Its name in the body's file, such as head.")]
    state: Annotated[str, doc("idle, moving, holding, yielding, refused or silent.")]
    reason: Annotated[str, doc("The same in words, where there is more to say.")]
    exploited: Annotated[str | None, doc("The behavior that moves it; null: none.")]
    speed_radps: Annotated[float, doc("The fastest of its joints, as measured.")]


@dataclass(frozen=True, slots=True)
class OdometryReport:
    """Pose in `odom` (m, rad) and measured velocity (m/s, rad/s)."""

    x: float
    y: float
    theta: float
    linear_mps: float
    angular_radps: float
    lateral_mps: float = 0.0


@dataclass(frozen=True, slots=True)
class LandmarkReport:
    """A QR code found: where its centre is in `frame` (m)."""

    text: str
    x: float
    y: float
    z: float
    sigma_m: Annotated[float, doc("Standard deviation along each axis.")]
    sightings: int
    first_seen: Stamp
    last_seen: Stamp
    heading: Annotated[float | None, doc("Direction in `frame` (rad) of its outward normal; null: unknown.")]
    heading_sigma: Annotated[float | None, doc("Standard deviation of `heading` (rad).")]
    id: Annotated[int, doc("A number that it keeps on its map: one text may hang in several places.")]
    frame: Annotated[str, doc("`map` once the robot was localized on it, else `odom`.")]


@dataclass(frozen=True, slots=True)
class RobotReport:
    """The robot's state."""

    stamp: Stamp
    robot: RobotFacts
    guard: Guard
    world_rate: float
    odometry: OdometryReport | None
    driver: Annotated[str | None, doc("The operator who drives.")]
    exploited: Annotated[str | None, doc("The behavior that drives the base.")]
    landmarks: tuple[LandmarkReport, ...]
    battery: Annotated[BatteryState | None, doc("null: the body has none, or has not reported it yet.")]


@dataclass(frozen=True, slots=True)
class EStop:
    """The request to the guard; GET /api/v1/robot shows within 50 ms what it did."""

    e_stop: Literal["latched", "released"]
    stamp: Annotated[float, doc("The robot's clock then (s): what a release names by `seen`.")]
