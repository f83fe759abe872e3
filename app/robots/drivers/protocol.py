"""What the process of a robot of parts is sent beyond what every body's is (:mod:`app.robots.link_protocol`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from app.robots.drivers.config import DriversConfig


@dataclass(frozen=True, slots=True)
class Start:
    """Program to link, first. ``clock_offset`` makes the robot's clock of ``monotonic()``; ``demanded``: rates (Hz) by
    stream; ``e_stop``: reason of an emergency stop that is latched already, or None."""

    config: DriversConfig
    clock_offset: float
    demanded: Mapping[str, float]
    e_stop: str | None = None
