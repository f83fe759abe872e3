"""Follow in a room on virtual time: the distance is kept, and nothing moves without fresh persons."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from typing import Any

import pytest

from app.attention.desires import DesireClasses, InvalidDesire, Source
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2
from app.messages import (
    Accomplishment,
    LaserScan,
    Localization,
    NavigationStatus,
    OccupancyGrid,
    Odometry,
    Persons,
    Twist,
    Zones,
)
from app.modules.behaviors.follow.follow import FOLLOW
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.modules.behaviors.driven_world import DrivenLink, DrivenWorld, Living, box, mapped, until
from tests.modules.behaviors.follow.people import person, persons
from tests.modules.fakes import Bench

SIZE = (0.0, 0.0, 10.0, 5.0)
ROOM = box(0.1, 0.1, 9.9, 4.9)
START = Pose2(1.0, 2.5, 0.0)
DISTANCE_M = 1.2


class Walk:
    """The module in the room, and a person at ``x``, ``y`` who goes with ``v`` (m/s); ``seen``: whether they are."""

    def __init__(self, x: float = 3.0, y: float = 2.5, **params: Any) -> None:
        self.world = DrivenWorld(ROOM, START)
        self.x, self.y = x, y
        self.v = (0.0, 0.0)
        self.seen = self.tracked = True
        self.nearest_m = math.inf
        self.workspace = IntentionWorkspace(DesireClasses([FOLLOW]), VirtualClock().now)
        self.bench = Bench(
            "app.modules.behaviors.follow.follow:Follow",
            inputs={
                "persons": Persons, "scans": LaserScan, "odometry": Odometry, "localization": Localization,
                "map": OccupancyGrid, "zones": Zones,
            },
            outputs={"twist": Twist, "status": NavigationStatus, "accomplishments": Accomplishment},
            settings={"hidden_s": 2.0, "search_s": 4.0},
            link=DrivenLink(),
            services={IntentionWorkspace: self.workspace},
            attended=("twist",),
        )  # fmt: skip
        self.bench.graph.channel("accomplishments").observe(self.workspace.accomplish)
        self.params = params
        self.desire = ""

    async def __aenter__(self) -> Walk:
        await self.bench.__aenter__()
        self.bench.feed("map", mapped(ROOM, SIZE))
        self.bench.graph.filters.apply({"Tested.twist": 1})
        self.want(**self.params)
        self._walking = asyncio.create_task(self._walk())
        return self

    async def __aexit__(self, *error: object) -> None:
        self._walking.cancel()
        await asyncio.wait({self._walking})
        await self.bench.__aexit__(*error)

    def want(self, **params: Any) -> None:
        """Another desire, in place of the present one."""
        if self.desire:
            self.workspace.remove(self.desire)
        self.desire = self.workspace.add(
            "Follow", intensity=1, utility=1, params=params, source=Source("operator", "ada")
        ).id
        self.bench.graph.configure("Tested", dict(self.workspace.get(self.desire).params))

    @property
    def distance_m(self) -> float:
        return math.dist((self.world.pose.x, self.world.pose.y), (self.x, self.y))

    @property
    def turned_rad(self) -> float:
        to = math.atan2(self.y - self.world.pose.y, self.x - self.world.pose.x)
        return abs(math.remainder(to - self.world.pose.theta, 2 * math.pi))

    @property
    def outcome(self) -> str | None:
        return self.workspace.report(self.desire).outcome

    async def until(self, condition: Callable[[], bool], limit_s: float) -> bool:
        async with Living(self.world, self.bench):
            return await until(self.bench, condition, limit_s)

    async def live(self, seconds: float) -> None:
        await self.until(lambda: False, seconds)

    async def _walk(self) -> None:
        while True:
            self.x, self.y = self.x + 0.1 * self.v[0], self.y + 0.1 * self.v[1]
            self.nearest_m = min(self.nearest_m, self.distance_m)
            now = self.bench.clock.now()
            if self.tracked:
                seen = (person(self.x, self.y, v=self.v, seen=now),) if self.seen else ()
                self.bench.feed("persons", persons(now, *seen))
            await self.bench.clock.sleep(0.1)


@in_virtual_time
async def test_it_comes_to_the_distance_follows_and_turns_to_a_person_who_stops() -> None:
    async with Walk() as walk:
        assert await walk.until(lambda: walk.outcome == "done", 12)
        assert walk.distance_m == pytest.approx(DISTANCE_M, abs=0.1)
        walk.v = (0.4, 0.0)
        await walk.live(8)
        assert walk.distance_m < DISTANCE_M + 0.4
        walk.v = (0.0, 0.4)
        await walk.live(3)
        walk.v = (0.0, 0.0)
        assert await walk.until(lambda: abs(walk.world.linear) < 0.02 and walk.turned_rad < 0.2, 8)
        assert walk.distance_m == pytest.approx(DISTANCE_M, abs=0.15)
        assert walk.nearest_m > DISTANCE_M - 0.05
        assert walk.world.driven_m > 3


@in_virtual_time
async def test_it_stands_without_fresh_persons_and_without_scans() -> None:
    async with Walk(x=8.0) as walk:
        assert await walk.until(lambda: walk.world.linear > 0.3, 5)
        walk.tracked = False
        assert await walk.until(lambda: walk.world.linear < 0.01, 2)
        stood = walk.world.driven_m
        await walk.live(1)
        assert walk.world.driven_m == pytest.approx(stood, abs=0.01)
        walk.tracked = True
        assert await walk.until(lambda: walk.world.linear > 0.3, 5)
        async with Living(walk.world, walk.bench, scans=False):
            assert await until(walk.bench, lambda: walk.world.linear < 0.01, 3)


@in_virtual_time
async def test_a_lost_person_is_looked_for_on_the_spot_and_given_up_until_another_desire_asks() -> None:
    async with Walk(x=4.0) as walk:
        assert await walk.until(lambda: walk.outcome == "done", 12)
        walk.seen = False
        stood = walk.world.pose
        turned = 0.0

        def failed() -> bool:
            nonlocal turned
            turned = max(turned, abs(walk.world.pose.theta))
            return walk.outcome == "failed"

        assert await walk.until(failed, 10)
        assert "Person 1 was lost" in walk.workspace.report(walk.desire).reason
        assert turned > math.radians(40)
        assert math.dist((stood.x, stood.y), (walk.world.pose.x, walk.world.pose.y)) < 0.1
        walk.seen, walk.x = True, 7.0
        await walk.live(2)
        assert walk.world.linear == 0
        walk.want()
        assert await walk.until(lambda: walk.world.linear > 0.3, 6)


@in_virtual_time
async def test_it_goes_round_a_person_who_walks_towards_the_wall_to_stand_before_them() -> None:
    async with Walk(x=3.5, side="front") as walk:
        walk.v = (0.3, 0.0)
        await walk.live(1)
        walk.v = (0.0, 0.0)
        assert await walk.until(lambda: walk.outcome == "done", 40)
        assert walk.world.pose.x > walk.x + 0.9
        assert abs(walk.world.pose.y - walk.y) < 0.5
        assert walk.turned_rad < 0.2
        assert walk.nearest_m > DISTANCE_M - 0.05


@pytest.mark.parametrize(
    ("params", "field"),
    [({"distance_m": 0.3}, "params.distance_m"), ({"side": "left"}, "params.side"), ({"whom": 1}, "params.whom")],
)
def test_what_it_cannot_keep_is_refused_by_name(params: dict[str, Any], field: str) -> None:
    with pytest.raises(InvalidDesire) as refusal:
        FOLLOW.validated(params)
    assert refusal.value.field == field
