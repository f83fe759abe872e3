"""A small world of walls on virtual time, and a body in it that drives as commanded: no physics, no noise, no drift."""

from __future__ import annotations

import asyncio
import cmath
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3
from app.link import BaseLimits, RobotDescription
from app.messages import LaserScan, Localization, OccupancyGrid, Odometry, Twist, read_only
from tests.modules.fakes import STREAMS, Bench, FakeLink

LIMITS = BaseLimits(0.80, 1.50, 0.80, 4.00)
#: A tick of the world, s; with each comes odometry, with every fifth a scan and a localization.
TICK_S = 0.02
FOOTPRINT = ((0.25, -0.25), (0.25, 0.25), (-0.25, 0.25), (-0.25, -0.25))
RESOLUTION = 0.05

Segment = tuple[float, float, float, float]


def box(x0: float, y0: float, x1: float, y1: float) -> list[Segment]:
    """The four walls of a rectangle."""
    return [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]


class DrivenLink(FakeLink):
    """A fake body that has a footprint and limits."""

    def __init__(self, limits: BaseLimits = LIMITS, footprint: tuple[tuple[float, float], ...] = FOOTPRINT) -> None:
        super().__init__()
        self.description = RobotDescription(
            "a test body", Path("none.urdf"), limits, STREAMS, simulated=True, footprint=footprint, height_m=1.4
        )


class DrivenWorld:
    """Walls (``segments``) and a body at ``pose``; ``command`` is what it drives after, within ``limits``."""

    def __init__(self, segments: list[Segment], pose: Pose2, limits: BaseLimits = LIMITS) -> None:
        self.segments = list(segments)
        self.pose = pose
        self.limits = limits
        self.linear = self.angular = self.lateral = 0.0
        self.command = Twist(0.0, 0.0, 0.0)
        #: Of the body's edge to the walls, the least so far (m).
        self.nearest_m = math.inf
        self.driven_m = 0.0

    def move(self, time_s: float) -> None:
        """Drive on for ``time_s``."""
        wanted = (self.command.linear_mps, self.command.lateral_mps)
        self.linear, self.lateral = self.limits.ramped((self.linear, self.lateral), wanted, time_s)
        self.angular += _towards(self.command.angular_radps - self.angular, self.limits.angular_radps2 * time_s)
        middle = self.pose.theta + 0.5 * self.angular * time_s
        step = complex(self.linear, self.lateral) * time_s * cmath.rect(1.0, middle)
        self.pose = Pose2(self.pose.x + step.real, self.pose.y + step.imag, self.pose.theta + self.angular * time_s)
        self.driven_m += abs(step)
        self.nearest_m = min(self.nearest_m, self.clearance_m())

    def clearance_m(self) -> float:
        """From the body's edge to the nearest wall now."""
        points = np.concatenate([_along(segment, 0.02) for segment in self.segments])
        c, s = math.cos(self.pose.theta), math.sin(self.pose.theta)
        dx, dy = points[:, 0] - self.pose.x, points[:, 1] - self.pose.y
        ahead, aside = np.abs(c * dx + s * dy) - FOOTPRINT[0][0], np.abs(c * dy - s * dx) - FOOTPRINT[1][1]
        outside = np.hypot(np.maximum(ahead, 0), np.maximum(aside, 0))
        return float(np.where(outside > 0, outside, np.maximum(ahead, aside)).min())

    def odometry(self, stamp: float) -> Odometry:
        """Perfect: ``odom`` is the world."""
        return Odometry(stamp, self.pose, self.linear, self.angular, self.lateral)

    def scan(self, stamp: float, fov: float = math.pi, rays: int = 181) -> LaserScan:
        """What a laser in the body's middle sees."""
        angles = np.linspace(-fov / 2, fov / 2, rays)
        ranges = ray_ranges(self.segments, self.pose.x, self.pose.y, angles + self.pose.theta)
        seen = np.where(ranges < 10.0, ranges, np.inf).astype(np.float32)
        return LaserScan(
            stamp, "laser", read_only(seen), read_only(np.ones_like(seen)), float(angles[0]),
            float(angles[1] - angles[0]), 0.05, 10.0, 0.0, Pose3.identity(),
        )  # fmt: skip

    def localization(self, stamp: float, state: str = "tracking") -> Localization:
        """Perfect: the map is the world."""
        return Localization(stamp, Pose2(), self.pose, read_only(np.eye(3) * 1e-6), state, 1.0, "test")

    async def live(self, bench: Bench, *, scans: bool = True, localize: bool = True) -> None:
        """Feed the module under test, and drive after its newest twist, until cancelled."""
        twists = bench.listen("twist")
        tick = 0
        while True:
            while twists.statistics().depth:
                self.command = twists.receive_nowait()
            self.move(TICK_S)
            now = bench.clock.now()
            bench.feed("odometry", self.odometry(now))
            if tick % 5 == 0 and scans:
                bench.feed("scans", self.scan(now))
            if tick % 5 == 0 and localize:
                bench.feed("localization", self.localization(now))
            tick += 1
            await bench.clock.sleep(TICK_S)


def mapped(segments: list[Segment], size: tuple[float, float, float, float], version: int = 1) -> OccupancyGrid:
    """A finished map of the walls, free within ``size`` (x0, y0, x1, y1)."""
    x0, y0, x1, y1 = size
    columns, rows = round((x1 - x0) / RESOLUTION), round((y1 - y0) / RESOLUTION)
    cells = np.zeros((rows, columns), dtype=np.int8)
    for segment in segments:
        points = _along(segment, RESOLUTION / 4)
        j = np.clip(((points[:, 0] - x0) / RESOLUTION).astype(int), 0, columns - 1)
        i = np.clip(((points[:, 1] - y0) / RESOLUTION).astype(int), 0, rows - 1)
        cells[i, j] = 100
    return OccupancyGrid(0.0, "map", read_only(cells), RESOLUTION, (x0, y0), version)


def ray_ranges(segments: list[Segment], x: float, y: float, angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance along each of ``angles`` to the nearest of ``segments``, inf where none is met."""
    nearest = np.full(len(angles), np.inf)
    dx, dy = np.cos(angles), np.sin(angles)
    for x0, y0, x1, y1 in segments:
        ex, ey = x1 - x0, y1 - y0
        cross = dx * ey - dy * ex
        with np.errstate(divide="ignore", invalid="ignore"):
            t = ((x0 - x) * ey - (y0 - y) * ex) / cross
            u = ((x0 - x) * dy - (y0 - y) * dx) / cross
        hit = (np.abs(cross) > 1e-12) & (t > 1e-6) & (u >= 0) & (u <= 1)
        nearest = np.where(hit, np.minimum(nearest, np.where(hit, t, np.inf)), nearest)
    return nearest


async def until(bench: Bench, condition: Callable[[], bool], limit_s: float) -> bool:
    """Wait in virtual time until ``condition()``, at most ``limit_s``."""
    end = bench.clock.now() + limit_s
    while bench.clock.now() < end:
        if condition():
            return True
        await bench.clock.sleep(0.1)
    return False


class Living:
    """``async with Living(world, bench):`` the world runs for the block."""

    def __init__(self, world: DrivenWorld, bench: Bench, **what: bool) -> None:
        self._coroutine = world.live(bench, **what)

    async def __aenter__(self) -> None:
        # Where each future was made is of no use here, and would be most of the time of a drive.
        asyncio.get_running_loop().set_debug(False)
        self._task = asyncio.create_task(self._coroutine)

    async def __aexit__(self, *error: object) -> None:
        self._task.cancel()
        await asyncio.wait({self._task})


def _along(segment: Segment, spacing_m: float) -> NDArray[np.float64]:
    x0, y0, x1, y1 = segment
    count = max(2, math.ceil(math.hypot(x1 - x0, y1 - y0) / spacing_m) + 1)
    return np.stack((np.linspace(x0, x1, count), np.linspace(y0, y1, count)), axis=1)


def _towards(change: float, most: float) -> float:
    return max(-most, min(most, change))
