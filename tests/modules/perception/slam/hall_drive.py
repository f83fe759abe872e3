"""SLAM2D on the bench, in a hall that a test draws: a body that is wherever the test puts it, and its odometry."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

import numpy as np

from app.base.geometry import Pose2
from app.maps.library import MapLibrary
from app.maps.map_service import MapService
from app.messages import Keyframes, LandmarkPose, LaserScan, Localization, OccupancyGrid, Odometry, Zone, Zones
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench
from tests.modules.perception.slam.places import HALL, Segment, scan, way

ROUND = way(
    (1.5, 3.0), (8.0, 3.0), (8.0, 6.5), (10.5, 6.5), (10.5, 4.5), (8.0, 4.0), (1.5, 3.0), (3.6, 4.0), (3.6, 6.5)
)
STAIRS = Zone("stairs", "keep_out", np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), 1.0)
Script = Callable[["Body"], Awaitable[None]]


class Body:
    """A body that is wherever the test puts it, its odometry, and the module."""

    def __init__(self, library: MapLibrary, walls: Sequence[Segment] = HALL, **settings: Any) -> None:
        self.control = MapService()
        self.library = library
        self.walls = walls
        self.bench = Bench(
            "app.modules.perception.slam_2d:SLAM2D",
            inputs={"scans": LaserScan, "odometry": Odometry, "landmark_poses": LandmarkPose},
            outputs={"localization": Localization, "map": OccupancyGrid, "zones": Zones, "keyframes": Keyframes},
            services={MapLibrary: library, MapService: self.control},
            settings=settings,
        )
        self.X_WB = ROUND[0]
        self.X_OB = Pose2(4.0, -2.0, 1.0)
        self._scans = 0
        self.explained_each: list[Localization] = []
        self.maps: list[OccupancyGrid] = []
        self.keyframes: list[Keyframes] = []
        for port, kept in (
            ("localization", self.explained_each), ("map", self.maps), ("keyframes", self.keyframes)
        ):  # fmt: skip
            self.bench.graph.channel(port).observe(kept.append)
        self.zones = self.bench.listen("zones")

    async def go(self, poses: Sequence[Pose2], every: int = 1, slip: float = 0.01) -> None:
        """Drive along ``poses``, one in 0.1 s, the wheels slipping; scans at each, or one in ``every``."""
        for number, pose in enumerate(poses):
            step = self.X_WB.inverse() @ pose
            self.X_OB = self.X_OB @ Pose2(step.x * (1 + slip), step.y, step.theta * (1 + slip))
            self.X_WB = pose
            now = self.bench.clock.now()
            self.bench.feed("odometry", Odometry(now, self.X_OB, 0.0, 0.0))
            if number % every == 0:
                self._scans += 1
                self.bench.feed("scans", scan(self.walls, pose, now, seed=self._scans))
            await self.bench.clock.sleep(0.1)

    def suggest(self, X_WB: Pose2) -> None:
        """A landmark says that the robot is at ``X_WB``."""
        X_MO = ROUND[0].inverse() @ X_WB @ self.X_OB.inverse()
        self.bench.feed("landmark_poses", LandmarkPose(self.bench.clock.now(), X_MO, np.eye(3), 1, "door"))

    async def stand(self, seconds: float) -> None:
        await self.go([self.X_WB] * round(seconds * 10))

    def is_within(self, metres: float, radians: float, start: Pose2 = ROUND[0]) -> bool:
        """Whether the last published pose is so near to the true one, the map's origin being at ``start``."""
        off = (start @ self.explained_each[-1].X_MB).inverse() @ self.X_WB
        return math.hypot(off.x, off.y) < metres and abs(off.theta) < radians

    @property
    def state(self) -> str:
        return self.explained_each[-1].state

    def states(self, since: int = 0) -> list[str]:
        """The published states, consecutive equal ones once."""
        found = [place.state for place in self.explained_each[since:]]
        return [state for state, before in zip(found, ["", *found], strict=False) if state != before]


def live(script: Script, library: MapLibrary, fails: str = "", **settings: Any) -> Body:
    body = Body(library, **settings)

    async def main() -> None:
        async with body.bench:
            await body.bench.supervisor.started()
            await script(body)

    run_virtual(main())
    assert fails in body.bench.problem
    assert bool(fails) == bool(body.bench.problem)
    return body
