"""GoToward in a room on virtual time: straight there, around a pillar, and honest where it knows no way."""

from __future__ import annotations

import math

import numpy as np
import pytest

import app.modules.behaviors.go_toward  # noqa: F401  # not on the loop: it brings OpenCV and SciPy
from app.attention.desires import DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.base.geometry import Pose2, wrap_angle
from app.link import BaseLimits
from app.messages import Accomplishment, LaserScan, Localization, NavigationStatus, Odometry, Twist, Zone, Zones
from app.modules.behaviors.go_to import GO_TO
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.modules.behaviors.driven_world import DrivenLink, DrivenWorld, Living, box, until
from tests.modules.fakes import Bench, drain

ROOM = box(0.0, 0.0, 8.0, 5.0)


class Drive:
    """GoToward in a world, sent to a goal: ``async with Drive(...) as drive``."""

    def __init__(
        self,
        world: DrivenWorld,
        zones: tuple[Zone, ...] = (),
        *,
        workspace: IntentionWorkspace | None = None,
        **parameters: object,
    ) -> None:
        self.world = world
        self.statuses: list[NavigationStatus] = []
        self.bench = Bench(
            "app.modules.behaviors.go_toward:GoToward",
            inputs={"scans": LaserScan, "odometry": Odometry, "localization": Localization, "zones": Zones},
            outputs={"twist": Twist, "status": NavigationStatus, "accomplishments": Accomplishment},
            link=DrivenLink(world.limits),
            services={IntentionWorkspace: workspace or IntentionWorkspace(DesireClasses([GO_TO]), VirtualClock().now)},
            attended=("twist",),
        )
        self._zones = zones
        self._parameters = parameters

    async def __aenter__(self) -> Drive:
        await self.bench.__aenter__()
        self._status_inbox = self.bench.listen("status")
        self.bench.graph.filters.apply({"Tested.twist": 1})
        self.bench.graph.configure("Tested", self._parameters)
        if self._zones:
            self.bench.feed("zones", Zones(self.bench.clock.now(), self._zones))
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.bench.__aexit__(*error)

    async def until(self, state: str, limit_s: float) -> bool:
        def reached() -> bool:
            self.statuses.extend(drain(self._status_inbox))
            return bool(self.statuses) and self.statuses[-1].state == state

        async with Living(self.world, self.bench):
            return await until(self.bench, reached, limit_s)


@in_virtual_time
async def test_it_goes_straight_to_a_place_and_turns_to_the_heading_asked_for() -> None:
    world = DrivenWorld(ROOM, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=3.0, y=2.5, heading=math.pi, tolerance_m=0.2, tolerance_rad=0.15) as drive:
        assert await drive.until("arrived", 15)
    assert math.hypot(world.pose.x - 3.0, world.pose.y - 2.5) <= 0.2
    assert abs(wrap_angle(world.pose.theta - math.pi)) <= 0.15
    assert world.linear == pytest.approx(0, abs=0.05)
    assert world.driven_m < 1.15 * math.hypot(2.0, 1.5)
    assert drive.statuses[-1].goal == Pose2(3.0, 2.5, math.pi)


@in_virtual_time
async def test_at_the_goal_every_desire_for_just_it_is_done() -> None:
    workspace = IntentionWorkspace(DesireClasses([GO_TO]), VirtualClock().now)

    def desire(**params: float) -> str:
        return workspace.add("GoTo", intensity=5, utility=1, params=params, source=Source("rest", "test")).id

    mine, same = desire(x=2.0, y=1.0), desire(x=2.0, y=1.0)
    stricter, elsewhere = desire(x=2.0, y=1.0, tolerance_m=0.05), desire(x=3.0, y=1.0)
    async with Drive(DrivenWorld(ROOM, Pose2(1.0, 1.0, 0.0)), workspace=workspace, x=2.0, y=1.0) as drive:
        drive.bench.graph.channel("accomplishments").observe(workspace.accomplish)
        assert await drive.until("arrived", 15)
    assert [desire.id for desire in workspace.desires()] == [stricter, elsewhere]
    for desire_id in (mine, same):
        report = workspace.report(desire_id)
        assert (report.outcome, report.behavior, report.reason) == ("done", "Tested", "arrived at (2.00, 1.00)")


@in_virtual_time
async def test_it_gets_round_a_pillar_in_the_open() -> None:
    world = DrivenWorld([*ROOM, *box(2.5, 2.4, 2.7, 2.6)], Pose2(1.0, 2.5, 0.0))
    async with Drive(world, x=4.0, y=2.55) as drive:
        assert await drive.until("arrived", 15)
    assert world.nearest_m > 0.0


@in_virtual_time
async def test_before_a_wall_it_stands_and_says_that_it_knows_no_way() -> None:
    world = DrivenWorld([*ROOM, (3.0, 0.0, 3.0, 4.9)], Pose2(1.0, 2.0, 0.0))
    async with Drive(world, x=5.0, y=2.0) as drive:
        assert not await drive.until("arrived", 12)
    assert drive.statuses[-1].state == "waiting"
    assert "knows no way around" in drive.statuses[-1].reason
    assert world.nearest_m > 0.0
    assert abs(world.linear) < 0.02


@in_virtual_time
async def test_it_keeps_out_of_a_zone() -> None:
    zone = Zone("stairs", "keep_out", np.array([[3.0, 0.0], [4.0, 0.0], [4.0, 5.0], [3.0, 5.0]]), 1.0)
    world = DrivenWorld(ROOM, Pose2(1.0, 2.5, 0.0))
    async with Drive(world, (zone,), x=6.0, y=2.5) as drive:
        assert not await drive.until("arrived", 8)
    assert 2.0 < world.pose.x + 0.25 < 3.05


@in_virtual_time
async def test_it_is_slow_in_a_slow_zone() -> None:
    zone = Zone("ward", "slow", np.array([[2.0, 0.0], [7.0, 0.0], [7.0, 5.0], [2.0, 5.0]]), 0.25)
    world = DrivenWorld(ROOM, Pose2(1.0, 2.5, 0.0))
    async with Drive(world, (zone,), x=6.0, y=2.5) as drive:
        await drive.until("arrived", 5)
        assert world.pose.x > 2.0
        assert world.linear == pytest.approx(0.2, abs=0.04)


@in_virtual_time
async def test_without_scans_or_a_pose_it_does_not_move_and_says_why() -> None:
    world = DrivenWorld(ROOM, Pose2(1.0, 2.5, 0.0))
    for missing, said in (("scans", "laser"), ("localize", "where it is")):
        async with Drive(world, x=6.0, y=2.5) as drive, Living(world, drive.bench, **{missing: False}):
            statuses = drive.bench.listen("status")
            await drive.bench.clock.sleep(1.0)
            status = drain(statuses)[-1]
        assert status.state == "waiting"
        assert said in status.reason
        assert world.driven_m == 0.0


@in_virtual_time
async def test_its_last_word_is_a_stop() -> None:
    world = DrivenWorld(ROOM, Pose2(1.0, 2.5, 0.0))
    async with Drive(world, x=6.0, y=2.5) as drive:
        twists = drive.bench.listen("twist")
        await drive.until("never", 2.0)
        assert drain(twists)[-1].linear_mps > 0.2
        drive.bench.graph.filters.apply({"Tested.twist": math.inf})
        assert [t.linear_mps for t in drain(twists)] == [0.0]


@in_virtual_time
async def test_a_base_that_can_moves_sideways_to_a_place_beside_it() -> None:
    limits = BaseLimits(0.80, 1.50, 0.80, 4.00, lateral_mps=0.60)
    world = DrivenWorld(ROOM, Pose2(3.0, 1.0, 0.0), limits)
    async with Drive(world, x=3.0, y=3.0) as drive:
        assert not await drive.until("arrived", 1.0)
        assert world.lateral > 0.2, "it sets out at once, before it has turned"
        assert await drive.until("arrived", 15)
    assert math.hypot(world.pose.x - 3.0, world.pose.y - 3.0) <= 0.25
    assert world.nearest_m > 0.0
