"""The battery, and the dock that charges it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from app.base.geometry import Pose2
from app.messages.base import Stamp, doc

DockingState = Literal["idle", "going", "searching", "approaching", "docked", "backing", "undocking", "failed"]


@dataclass(frozen=True, slots=True)
class BatteryState:
    """State of the body's battery."""

    stamp: Stamp
    charge: Annotated[float, doc("Share of the capacity that is left, 0 to 1.")]
    voltage_v: Annotated[float, doc("At its terminals, V.")]
    current_a: Annotated[float, doc("Into the battery, A: negative while it discharges.")]
    charging: Annotated[bool, doc("Whether a charger supplies power, also once the battery is full.")]
    remaining_s: Annotated[
        float | None,
        doc("Time until it is empty, or full while it charges, at the mean power of the last minute; null: neither."),
    ]


@dataclass(frozen=True, slots=True)
class DockSighting:
    """A dock seen by the laser: two upright plates that meet in a V, open towards the robot.

    ``X_OD`` is its pose in ``odom`` at ``stamp`` (s): origin where the plates meet, x out of the dock along its axis.
    ``plate_m`` is the length of each plate, ``opening_rad`` the angle between them.
    """

    stamp: float
    X_OD: Pose2
    plate_m: float
    opening_rad: float

    @property
    def corners(self) -> tuple[complex, complex, complex]:
        """The V's tip, origin and other tip, x + iy (m) in ``odom``."""
        origin = complex(self.X_OD.x, self.X_OD.y)
        half = self.opening_rad / 2
        left, right = (
            origin + self.plate_m * complex(math.cos(angle), math.sin(angle))
            for angle in (self.X_OD.theta + half, self.X_OD.theta - half)
        )
        return left, origin, right


@dataclass(frozen=True, slots=True)
class DockingStatus:
    """What docking does now, published with each change.

    ``state``: ``going`` to the place in front of the dock; ``searching`` for it with the laser; ``approaching``;
    ``docked``: the charger supplies power; ``backing`` off for another ``attempt`` (from 1); ``undocking``; ``failed``,
    for the ``reason`` in words. ``desire``: id of the desire served, "" for none.
    """

    stamp: float
    state: DockingState
    reason: str
    desire: str
    attempt: int
