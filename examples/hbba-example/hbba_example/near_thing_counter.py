"""NearThingCounter: how many things are near.

    ┌──────────────────────────────────────────────────────────────┐
    │ NearThingCounter    in   scans   LaserScan, 10 Hz / φ        │
    │                     out  things  NearThings, with each scan  │
    └──────────────────────────────────────────────────────────────┘

A thing is a run of neighbouring rays that end within ``within_m``, a parameter of the desire CountNearThings.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from app.attention.desires import DesireClass
from app.messages import LaserScan
from app.runtime.module import Module, ModuleContext, Settings
from hbba_example.messages import NearThings


class CountNearThingsParameters(BaseModel):
    """Parameters of a desire of class CountNearThings."""

    model_config = ConfigDict(extra="forbid", title="Count near things")

    within_m: float = Field(1.5, gt=0, le=10, title="Near", description="What is nearer than so many metres is near.")


COUNT_NEAR_THINGS = DesireClass(
    "CountNearThings", "Count near things", "Count what the laser sees nearby.", CountNearThingsParameters
)


class NearThingCounterSettings(Settings):
    """Settings of NearThingCounter."""

    within_m: float = Field(1.5, gt=0, description="used while no desire says another")


class NearThingCounter(Module):
    """Counts the things that each scan shows nearby."""

    title = "Near things"
    desire_classes = (COUNT_NEAR_THINGS,)
    Settings = NearThingCounterSettings
    settings: NearThingCounterSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._within_m = self.settings.within_m
        self.scans = self.input("scans", LaserScan)
        self.things = self.output("things", NearThings)
        self.on(self.scans, self._count)

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take ``within_m`` from the intention."""
        self._within_m = float(parameters.get("within_m", self.settings.within_m))

    async def _count(self, scan: LaserScan) -> None:
        self.things.publish(near_things(scan, self._within_m))


def near_things(scan: LaserScan, within_m: float) -> NearThings:
    """Things of ``scan`` nearer than ``within_m`` (m). The first and last ray of a full circle are neighbours."""
    near = scan.ranges < within_m
    is_circle = len(near) * abs(scan.angle_increment) > 2 * math.pi - 1e-3
    starts = near & ~np.concatenate(([is_circle and near[-1]], near[:-1]))
    nearest = float(scan.ranges[near].min()) if near.any() else None
    return NearThings(scan.stamp, int(starts.sum()), nearest)
