"""LanternPointer: turns a lantern to the nearest thing.

    ┌────────────────────────────────────────────────────────────────────────────────┐
    │ LanternPointer  in   scans    LaserScan, 10 Hz / φ                             │
    │                 out  command  JointCommand (rad) of the group, with each scan  │
    └────────────────────────────────────────────────────────────────────────────────┘

An output of type JointCommand can move the body: it stays closed until a strategy of the desire class opens it.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field

from app.attention.desires import DesireClass
from app.messages import JointCommand, LaserScan
from app.runtime.module import Module, ModuleContext, Settings

POINT_LANTERN = DesireClass("PointLantern", "Point the lantern", "Point the lantern at the nearest thing.")


class LanternPointerSettings(Settings):
    """Settings of LanternPointer."""

    group: str = Field("lantern", min_length=1, description="the actuator group of the lantern")
    joint: str = Field("lantern_joint", min_length=1, description="its joint, which turns about the vertical")


class LanternPointer(Module):
    """Commands the lantern's joint with each scan that shows a thing."""

    title = "Lantern"
    desire_classes = (POINT_LANTERN,)
    Settings = LanternPointerSettings
    settings: LanternPointerSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.scans = self.input("scans", LaserScan)
        self.command = self.output("command", JointCommand)
        self.on(self.scans, self._point)

    async def _point(self, scan: LaserScan) -> None:
        bearing = nearest_bearing(scan)
        if bearing is not None:
            now = self.clock.now()
            self.command.publish(JointCommand(now, self.settings.group, (self.settings.joint,), (bearing,)))


def nearest_bearing(scan: LaserScan) -> float | None:
    """Bearing (rad, left positive, in the laser's frame, -pi to pi) of the middle of the nearest thing; None without.

    The middle is that of all rays within 5 cm of the shortest.
    """
    nearest = float(scan.ranges.min(initial=np.inf))
    if not math.isfinite(nearest):
        return None
    angles = scan.angle_min + scan.angle_increment * np.flatnonzero(scan.ranges < nearest + 0.05)
    return math.atan2(float(np.sin(angles).sum()), float(np.cos(angles).sum()))
