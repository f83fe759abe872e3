"""What the simulated body's process is sent and sends beyond the messages of every body's
(:mod:`app.robots.link_protocol`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from app.base.geometry import Pose3
from app.messages import Audio
from app.robots.config import RobotConfig
from app.robots.link_protocol import (
    ClearEStop,
    Demand,
    DriveRequest,
    EStopRequest,
    FrameReader,
    Ready,
    Sample,
    Socket,
    Stop,
    encode,
    request,
)
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.world_config import WorldConfig

__all__ = [
    "ClearEStop",
    "ComputerLoad",
    "Demand",
    "DriveRequest",
    "EStopRequest",
    "FrameReader",
    "ImageNotice",
    "Play",
    "Ready",
    "Sample",
    "Socket",
    "Start",
    "Stop",
    "encode",
    "request",
]


@dataclass(frozen=True, slots=True)
class Start:
    """Program to link, first: all the link needs. ``clock_offset`` makes the robot's clock of ``monotonic()``;
    ``demanded``: rates (Hz) by stream. ``e_stop`` is the reason of an emergency stop that is latched already, or None.
    """

    robot: RobotConfig
    world: WorldConfig
    clock_offset: float
    demanded: Mapping[str, float]
    e_stop: str | None = None
    scenario: ScenarioConfig | None = None


@dataclass(frozen=True, slots=True)
class ComputerLoad:
    """Program to link: how many ``cores`` of the robot's computer are busy, on average since the last."""

    cores: float


@dataclass(frozen=True, slots=True, eq=False)
class Play:
    """Program to link: sound for the loudspeaker."""

    audio: Audio


@dataclass(frozen=True, slots=True, eq=False)
class ImageNotice:
    """Link to program: an image of ``stream`` is in ``slot`` of the shared ring, written as number ``sequence``.

    It ends so many ``periods`` of the stream: its own, and those that were left out before it.
    """

    stream: str
    slot: int
    sequence: int
    stamp: float
    X_BC: Pose3
    periods: int = 1
