"""TrueLocalization: stands in for SLAM2D on a body whose world is the map.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ TrueLocalization  in   scans         LaserScan, 40 Hz / φ: one localization for each      │
    │                   in   odometry      Odometry, X_OB in odom; never filtered              │
    │                   out  localization  Localization: the true pose                         │
    │                   out  map           OccupancyGrid in map: the kept one, once             │
    │                   out  zones         Zones in map, once                                  │
    │                   is the MapServer: the map has its name, and stays as it is              │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

It has SLAM2D's ports, class of desires and strategies, so attention decides as it would: without scans it publishes
nothing. The truth is the body's stream ``ground_truth``.
"""

from __future__ import annotations

import math
from contextlib import ExitStack
from dataclasses import replace

import numpy as np
from pydantic import Field

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.pose_buffer import PoseBuffer
from app.maps.library import MapLibrary
from app.maps.map_service import Files, MapService, MapUnavailable
from app.messages import GroundTruth, LaserScan, Localization, OccupancyGrid, Odometry, Zone, Zones, read_only
from app.modules.perception.pose_at import PoseAt
from app.modules.perception.slam_2d import MAP_AND_LOCALIZE
from app.modules.stream_module import attach, robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings

_TRUTH = "ground_truth"
#: Standard deviations (m, m, rad) that are published of a pose without error.
_SIGMAS = (0.01, 0.01, 0.005)
#: A scan's stamp may be so far from the next truth (s).
_TOLERANCE_S = 0.06


class TrueLocalizationSettings(Settings):
    map: str = Field(min_length=1, description="the kept map that is the world")


class TrueLocalization(Module):
    title = "True localization"
    desire_classes = (MAP_AND_LOCALIZE,)
    Settings = TrueLocalizationSettings
    settings: TrueLocalizationSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._odometry = PoseAt(self.clock, self.log, "scans are of no use", "the stamps of scans")
        self._truth = PoseBuffer(tolerance_s=_TOLERANCE_S)
        self._covariance = read_only(np.diag(np.square(_SIGMAS)))
        self._stack = ExitStack()
        self.scans = self.input("scans", LaserScan)
        self.odometry = self.input("odometry", Odometry, capacity=200, always_open=True)
        self.localization = self.output("localization", Localization)
        self.map = self.output("map", OccupancyGrid)
        self.zones = self.output("zones", Zones)
        self.on(self.scans, self._locate)
        self.on(self.odometry, self._odometry.add)

    async def start(self) -> None:
        """Publish the map. Raises ModuleFailed for a body without ground truth, and for a map that cannot be read."""
        self._stack.callback(attach(self, _TRUTH, GroundTruth, self._see))
        # Not withdrawn: another stand-in may go on with it, and it costs nothing.
        robot_link(self).demand(_TRUTH, math.inf)
        name, library, maps = self.settings.map, self.service(MapLibrary), self.service(MapService)
        try:
            grid = await self.compute_background(library.grid, name)
            zones = await self.compute_background(library.zones, name)
        except (MapUnavailable, ConfigError, ValueError, OSError) as failure:
            raise ModuleFailed(f"the map {name!r} cannot be used: {failure}") from None
        now = self.clock.now()
        self.map.publish(replace(grid, stamp=now))
        self.zones.publish(Zones(now, zones))
        await maps.resume(name, same=False)
        self._stack.callback(maps.attach(_KeptMap(name)))

    async def stop(self) -> None:
        """Leave the map and the truth."""
        self._stack.close()

    def _see(self, truth: GroundTruth) -> None:
        self._truth.add(truth.stamp, truth.X_WB)

    async def _locate(self, scan: LaserScan) -> None:
        X_OB, X_MB = await self._odometry.logged_at(scan.stamp), self._truth.at(scan.stamp)
        if X_OB is None or X_MB is None:
            return
        where = Localization(
            scan.stamp,
            X_MB @ X_OB.inverse(),
            X_MB=X_MB,
            covariance=self._covariance,
            state="tracking",
            overlap=1.0,
            map=self.settings.map,
        )
        self.localization.publish(where)


class _KeptMap:
    """Implements :class:`app.maps.map_service.MapServer` for a map that stays as it is."""

    def __init__(self, name: str) -> None:
        self._name = name

    @property
    def name(self) -> str:
        return self._name

    async def save(self, name: str, others: Files | None = None) -> None:
        raise self._refusal()

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        raise self._refusal()

    async def begin(self) -> None:
        raise self._refusal()

    async def place(self, X_MB: Pose2) -> None:
        raise self._refusal()

    async def search(self) -> None:
        raise self._refusal()

    async def mark(self, zones: tuple[Zone, ...]) -> None:
        raise self._refusal()

    def _refusal(self) -> MapUnavailable:
        return MapUnavailable(f"the map {self._name} is the world of this body: it stays as it is")
