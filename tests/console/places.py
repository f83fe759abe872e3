"""A place, a map and a way, as modules would publish them; and a map server that does as the test says."""

from __future__ import annotations

import asyncio
import math

import numpy as np

from app.base.geometry import Pose2
from app.maps.library import MapLibrary
from app.maps.map_service import Files, MapUnavailable
from app.maps.route_service import RouteLeg
from app.messages import (
    Localization,
    NavigationStatus,
    OccupancyGrid,
    PlannedPath,
    Zone,
    Zones,
    read_only,
)


def localization(stamp: float, X_MO: Pose2 | None = None, *, state: str = "mapping", name: str = "lab") -> Localization:
    """The robot 2 m ahead of odometry's origin, known to 3 cm, 4 cm and 0.01 rad."""
    X_MO = X_MO or Pose2(1.0, 0.5, 0.0)
    covariance = read_only(np.diag([0.03**2, 0.04**2, 0.01**2]))
    return Localization(stamp, X_MO, X_MO @ Pose2(2.0, 0.0, 0.0), covariance, state, 0.875, name)


def grid(stamp: float, *, frame: str = "map", size: int = 40, version: int = 1, corner: int = 100) -> OccupancyGrid:
    """Unknown but for cells [10:30, 5:35], which are free; of them the one of the least x and y is ``corner``."""
    cells = np.full((size, size), -1, np.int8)
    cells[10:30, 5:35] = 0
    cells[10, 5] = corner
    return OccupancyGrid(stamp, frame, read_only(cells), 0.05, (-1.0, -2.0), version)


def zone(name: str = "stairs", kind: str = "keep_out", speed: float = 1.0) -> Zone:
    """A triangle."""
    return Zone(name, kind, read_only(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])), speed)


def zones(stamp: float, *marked: Zone) -> Zones:
    """``marked``, or the stairs."""
    return Zones(stamp, marked or (zone(),))


def status(stamp: float, state: str = "following", behavior: str = "PlanAndFollowPath") -> NavigationStatus:
    """On the way to a goal without a heading."""
    goal = Pose2(3.0, 1.0, float("nan"))
    return NavigationStatus(stamp, behavior, state, "on the way", goal, goal, 2.344, stamp, 1)


def path(stamp: float, points: int = 3, *, frame: str = "map") -> PlannedPath:
    """Straight ahead, ``points`` of them, 0.1 m apart."""
    poses = np.zeros((points, 3))
    poses[:, 0] = 0.1 * np.arange(points)
    return PlannedPath(stamp, frame, read_only(poses))


class FakeMapServer:
    """A MapServer that keeps an empty room in ``library`` and remembers what it was asked."""

    def __init__(self, library: MapLibrary) -> None:
        self._library = library
        self._name = ""
        self.asked: list[tuple[object, ...]] = []
        #: Why it refuses whatever it is asked, "" if it does not.
        self.refusal = ""

    @property
    def name(self) -> str:
        return self._name

    async def save(self, name: str, others: Files | None = None) -> None:
        self._ask("save", name)
        await asyncio.to_thread(self._library.keep, name, grid(0.0), (), others)
        self._name = name

    async def load(self, name: str, X_MB: Pose2 | None = None, extend: bool = False) -> None:
        self._ask("load", name, X_MB, extend)
        self._name = name

    async def begin(self) -> None:
        self._ask("begin")
        self._name = ""

    async def place(self, X_MB: Pose2) -> None:
        self._ask("place", X_MB)

    async def search(self) -> None:
        self._ask("search")

    async def mark(self, zones: tuple[Zone, ...]) -> None:
        self._ask("mark", *(zone.name for zone in zones))

    def _ask(self, *what: object) -> None:
        if self.refusal:
            raise MapUnavailable(self.refusal)
        self.asked.append(what)


class StraightPlanner:
    """Plans straight lines at 0.5 m/s; nothing leads to where x is negative."""

    def __init__(self) -> None:
        self.asked: list[tuple[Pose2, Pose2, float]] = []
        self.may_answer = asyncio.Event()
        self.may_answer.set()
        self.lack: MapUnavailable | None = None

    async def leg(self, start: Pose2, goal: Pose2, speed: float) -> RouteLeg:
        self.asked.append((start, goal, speed))
        await self.may_answer.wait()
        if self.lack is not None:
            raise self.lack
        if goal.x < 0:
            return RouteLeg("none", "obstacles on the map wall the goal off", np.empty((0, 2)), 0.0, 0.0)
        length = math.hypot(goal.x - start.x, goal.y - start.y)
        path = np.linspace((start.x, start.y), (goal.x, goal.y), 100)
        return RouteLeg("way", "", path, length, length / 0.5)
