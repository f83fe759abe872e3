"""PlanAndFollowPath in a small house on virtual time: through doors, around what no map knows, and never blind."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from app.attention.desires import DesireClasses, Source
from app.attention.workspace import IntentionWorkspace
from app.base import paths
from app.base.geometry import CameraModel, Pose2, Pose3, wrap_angle
from app.base.kinematic_model import load_model
from app.maps.map_service import MapUnavailable
from app.maps.route_service import RouteService
from app.messages import (
    Accomplishment,
    Image,
    JointState,
    LaserScan,
    Localization,
    NavigationStatus,
    OccupancyGrid,
    Odometry,
    PlannedPath,
    Twist,
    Zone,
    Zones,
    read_only,
)
from app.modules.behaviors.go_to import GO_TO
from app.modules.behaviors.plan_and_follow_path import PlanAndFollowPath
from app.robots.config import load_robot_config
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.modules.behaviors.driven_world import DrivenLink, DrivenWorld, Living, Segment, box, mapped, until
from tests.modules.fakes import Bench, drain

SIZE = (0.0, 0.0, 8.0, 5.0)
#: Two rooms and a door of 0.9 m between them.
HOUSE: list[Segment] = [*box(0.1, 0.1, 7.9, 4.9), (4.0, 0.1, 4.0, 2.0), (4.0, 2.9, 4.0, 4.9)]
INPUTS = {
    "scans": LaserScan,
    "odometry": Odometry,
    "localization": Localization,
    "map": OccupancyGrid,
    "zones": Zones,
}


IRL1 = load_robot_config(paths.config_dir() / "robots" / "irl1_tr.yaml")
IRL1_MODEL = load_model(IRL1.model)


class Drive:
    """The module in a world and on a map of ``known`` walls, sent to a goal."""

    def __init__(
        self,
        world: DrivenWorld,
        known: list[Segment] | None = None,
        zones: tuple[Zone, ...] = (),
        settings: dict[str, object] | None = None,
        camera: bool = False,
        arms: bool = False,
        **parameters: object,
    ) -> None:
        self.world = world
        self.statuses: list[NavigationStatus] = []
        self.workspace = IntentionWorkspace(DesireClasses([GO_TO]), VirtualClock().now)
        self.paths: list[PlannedPath] = []
        self.routes = RouteService()
        link = DrivenLink()
        if arms:
            link.description = replace(link.description, groups=dict(IRL1.groups), model_path=IRL1.model)
        self.bench = Bench(
            "app.modules.behaviors.plan_and_follow_path:PlanAndFollowPath",
            inputs=INPUTS | ({"images": Image} if camera else {}) | ({"joints": JointState} if arms else {}),
            outputs={
                "twist": Twist, "path": PlannedPath, "status": NavigationStatus, "costmap": OccupancyGrid,
                "accomplishments": Accomplishment,
            },
            settings=settings,
            link=link,
            services={IntentionWorkspace: self.workspace, RouteService: self.routes},
            attended=("twist",),
        )  # fmt: skip
        self.bench.graph.channel("accomplishments").observe(self.workspace.accomplish)
        self.known = HOUSE if known is None else known
        self._zones = zones
        self.parameters = parameters

    @property
    def module(self) -> PlanAndFollowPath:
        module = self.bench.slot.module
        assert isinstance(module, PlanAndFollowPath)
        return module

    async def __aenter__(self) -> Drive:
        await self.bench.__aenter__()
        self._status_inbox, self._ways = self.bench.listen("status"), self.bench.listen("path")
        self.twists = self.bench.listen("twist", 10_000)
        self.bench.feed("map", mapped(self.known, SIZE))
        if self._zones:
            self.bench.feed("zones", Zones(self.bench.clock.now(), self._zones))
        self.bench.graph.filters.apply({"Tested.twist": 1})
        self.go(**self.parameters)
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.bench.__aexit__(*error)

    def go(self, **parameters: object) -> None:
        self.bench.graph.configure("Tested", parameters)

    @property
    def status(self) -> NavigationStatus:
        self.statuses.extend(drain(self._status_inbox))
        self.paths.extend(drain(self._ways))
        return self.statuses[-1] if self.statuses else NavigationStatus(0.0, "", "nothing said", "")

    async def until(self, state: str, limit_s: float) -> bool:
        async with Living(self.world, self.bench):
            return await until(self.bench, lambda: self.status.state == state, limit_s)


@in_virtual_time
async def test_it_goes_into_another_room_and_stands_there_as_asked() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=6.5, y=1.2, heading=math.pi / 2) as drive:
        assert await drive.until("arrived", 40)
        assert math.hypot(world.pose.x - 6.5, world.pose.y - 1.2) <= 0.25
        assert abs(world.pose.theta - math.pi / 2) <= 0.2
        assert abs(world.linear) < 0.03
        assert world.nearest_m > 0.02
        assert drive.status.goal == Pose2(6.5, 1.2, math.pi / 2)
        assert drive.status.recoveries == 0
        assert [len(path.poses) > 10 for path in drive.paths] == [True] * len(drive.paths)
        states = [status.state for status in drive.statuses]
        assert states.index("planning") < states.index("following") < states.index("arrived")
        remaining = [s.remaining_m for s in drive.statuses if s.state == "following" and s.remaining_m is not None]
        assert remaining[0] > 5
        assert remaining == sorted(remaining, reverse=True)
        commands = drain(drive.twists)
        for before, after in pairwise(commands):
            assert abs(after.linear_mps - before.linear_mps) <= 0.8 * 0.1 + 1e-6 or after.linear_mps == 0.0
            assert abs(after.angular_radps - before.angular_radps) <= 4.0 * 0.1 + 1e-6 or after.angular_radps == 0.0


@in_virtual_time
async def test_without_a_heading_it_stands_as_it_came() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=2.5, y=1.0) as drive:
        assert await drive.until("arrived", 15)
        assert math.isnan(drive.status.goal.theta)
    assert abs(world.pose.theta) < 0.5


@in_virtual_time
async def test_it_gets_round_what_the_map_does_not_know() -> None:
    world = DrivenWorld([*HOUSE, *box(2.4, 1.6, 2.8, 2.8)], Pose2(1.0, 2.2, 0.0))
    async with Drive(world, x=6.0, y=2.4) as drive:
        assert await drive.until("arrived", 40)
    assert world.nearest_m > 0.0


@in_virtual_time
async def test_it_waits_for_room_where_something_stands_in_its_goal_and_watches_it() -> None:
    world = DrivenWorld([*HOUSE, *box(2.75, 2.25, 2.85, 2.35)], Pose2(1.5, 2.2, 0.0))
    async with Drive(world, x=2.8, y=2.3, heading=0.0) as drive:
        assert await drive.until("waiting", 40)
        away_m = math.hypot(world.pose.x - 2.8, world.pose.y - 2.3)
        assert away_m > 0.4
        assert "waits for room" in drive.status.reason
        async with Living(world, drive.bench):
            await until(drive.bench, lambda: False, 3.0)
        assert drive.status.state == "waiting"
        aside = math.atan2(2.3 - world.pose.y, 2.8 - world.pose.x) - world.pose.theta
        assert abs(wrap_angle(aside)) < 0.3, "it watches the place: the laser sees only ahead"
        assert drive.bench.clock.now() - (drive.status.progress_stamp or 0.0) < 1.0, "and is in no distress"
        world.segments = list(HOUSE)
        assert await drive.until("arrived", 20)
        assert math.hypot(world.pose.x - 2.8, world.pose.y - 2.3) <= 0.25
        assert abs(world.pose.theta) <= 0.2


@in_virtual_time
async def test_a_goal_that_stays_taken_is_reached_as_near_as_can_be() -> None:
    world = DrivenWorld([*HOUSE, *box(2.75, 2.25, 2.85, 2.35)], Pose2(1.5, 2.2, 0.0))
    async with Drive(world, settings={"taken_s": 4.0}, x=2.8, y=2.3, heading=math.pi) as drive:
        assert await drive.until("waiting", 40)
        began = drive.bench.clock.now()
        assert await drive.until("arrived", 20)
        assert drive.bench.clock.now() - began > 4.0
        assert "too near to something that is not on the map" in drive.status.reason
        assert abs(abs(world.pose.theta) - math.pi) <= 0.2


@in_virtual_time
async def test_beside_what_leaves_little_room_it_stops_within_the_tolerance_of_the_goal_itself() -> None:
    world = DrivenWorld([*HOUSE, *box(2.85, 2.1, 2.95, 2.5)], Pose2(1.5, 2.3, 0.0))
    async with Drive(world, x=2.8, y=2.3, tolerance_m=0.3) as drive:
        assert await drive.until("arrived", 20)
        assert drive.status.target is not None
        assert 0.1 < 2.8 - drive.status.target.x < 0.3
        assert math.hypot(world.pose.x - 2.8, world.pose.y - 2.3) <= 0.3


@in_virtual_time
async def test_another_goal_replaces_the_first_and_none_ends_with_a_stop() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=6.5, y=1.2) as drive:
        await drive.until("never", 3.0)
        drive.go(x=1.0, y=3.5)
        assert await drive.until("arrived", 25)
        assert math.hypot(world.pose.x - 1.0, world.pose.y - 3.5) <= 0.25
        drive.go(x=3.0, y=1.0)
        await drive.until("never", 2.0)
        assert drive.status.state == "following"
        drive.go()
        assert await drive.until("idle", 1.0)
        assert drive.paths[-1].poses.shape == (0, 3)
        assert drain(drive.twists)[-1].linear_mps == 0.0
        await drive.until("never", 1.0)
        assert not drain(drive.twists), "an idle behavior does not keep the wheel"


@in_virtual_time
async def test_a_door_that_is_shut_is_called_by_its_name_and_a_goal_in_a_wall_is_not_far() -> None:
    shut = [*HOUSE, (4.0, 2.0, 4.0, 2.9)]
    world = DrivenWorld(shut, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, known=shut, x=6.5, y=1.2) as drive:
        assert await drive.until("unreachable", 3)
        assert drive.status.reason
        assert world.driven_m == 0.0
        place = {"x": 2.0, "y": 0.15}
        desire = drive.workspace.add("GoTo", intensity=8, utility=1, params=place, source=Source("rest", "test"))
        drive.go(**place)
        assert await drive.until("arrived", 20)
        report = drive.workspace.report(desire.id)
        assert (report.outcome, report.behavior) == ("done", "Tested")
        assert report.reason == f"arrived; {drive.status.reason}"
        assert drive.status.target.y > 0.3
        assert "nearest place" in drive.status.reason


@in_virtual_time
async def test_it_does_not_drive_without_a_pose_a_scan_or_a_map_and_says_so() -> None:
    for missing, said in (("localize", "where it is"), ("scans", "laser"), ("map", "map")):
        world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
        drive = Drive(world, x=3.0, y=1.0)
        if missing == "map":
            feed = drive.bench.feed

            def without_maps(port: str, message: Any, feed: Callable[[str, Any], None] = feed) -> None:
                if port != "map":
                    feed(port, message)

            drive.bench.feed = without_maps
        async with drive, Living(world, drive.bench, **({missing: False} if missing != "map" else {})):
            await drive.bench.clock.sleep(1.5)
            assert drive.status.state == "waiting"
            assert said in drive.status.reason
            assert world.driven_m == 0.0


@in_virtual_time
async def test_scans_that_stop_coming_stop_it() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=3.5, y=1.0) as drive:
        await drive.until("never", 2.0)
        assert world.linear > 0.3
        async with Living(world, drive.bench, scans=False):
            await drive.bench.clock.sleep(1.5)
        assert drive.status.state == "waiting"
        assert "laser scan is too old" in drive.status.reason
        assert abs(world.linear) < 0.01


@in_virtual_time
async def test_stops_for_want_of_odometry_are_commands_given_in_time() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=3.5, y=1.0) as drive:
        await drive.bench.clock.sleep(1.5)
        assert len(drain(drive.twists)) > 10
        assert drive.status.state == "waiting"
        assert drive.status.period_s == pytest.approx(0.1, abs=0.02)


@in_virtual_time
async def test_while_another_drives_it_is_idle_and_makes_no_excuses() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=3.5, y=1.0) as drive:
        await drive.until("never", 1.5)
        assert drive.status.state == "following"
        drive.bench.graph.filters.apply({"Tested.twist": math.inf})
        before = len(drive.statuses)
        async with Living(world, drive.bench, scans=False):
            await drive.bench.clock.sleep(2.0)
        assert (drive.status.state, drive.status.goal) == ("idle", None)
        assert {s.state for s in drive.statuses[before:]} <= {"following", "idle"}
        assert drive.paths[-1].poses.shape == (0, 3)
        drive.bench.graph.filters.apply({"Tested.twist": 1})
        assert await drive.until("arrived", 15.0)


def lost(world: DrivenWorld) -> None:
    """What localizes ``world``'s body says that it is lost, from now on."""
    tracking = world.localization
    world.localization = lambda stamp, state="lost": tracking(stamp, state)


@in_virtual_time
async def test_a_robot_that_is_lost_turns_on_the_spot_to_find_itself_and_goes_on() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=3.5, y=1.0) as drive:
        await drive.until("never", 2.0)
        tracking = world.localization
        lost(world)
        assert await drive.until("waiting", 1.0)
        assert "lost" in drive.status.reason
        assert await drive.until("recovering", 3.0)
        assert drive.status.reason == "it is lost on the map: turning to find itself"
        at, heading = world.pose, world.pose.theta
        await drive.until("never", 3.0)
        assert abs(world.pose.theta - heading) > 1.5
        assert math.dist((world.pose.x, world.pose.y), (at.x, at.y)) < 0.02
        world.localization = tracking
        assert await drive.until("arrived", 15.0)


@in_virtual_time
async def test_a_robot_that_turning_does_not_find_stands_and_asks_until_it_is_placed() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=3.5, y=1.0) as drive:
        tracking = world.localization
        lost(world)
        assert await drive.until("recovering", 5.0)
        assert await drive.until("waiting", 25.0)
        assert "say where it is" in drive.status.reason
        assert 4 * math.pi - 0.5 < world.pose.theta < 4 * math.pi + 1.0
        await drive.until("never", 5.0)
        assert world.angular == world.linear == 0.0
        world.localization = tracking
        assert await drive.until("arrived", 15.0)


@in_virtual_time
async def test_lost_without_room_without_sight_or_without_a_goal_it_stands() -> None:
    tight = DrivenWorld([*HOUSE, *box(0.7, 0.7, 1.3, 1.3)], Pose2(1.0, 1.0, 0.0))
    lost(tight)
    async with Drive(tight, x=3.5, y=1.0) as drive:
        await drive.until("never", 5.0)
        assert drive.status.state == "waiting"
        assert tight.nearest_m > 0.015
    blind = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    lost(blind)
    async with Drive(blind, x=3.5, y=1.0) as drive:
        assert await drive.until("recovering", 5.0)
        async with Living(blind, drive.bench, scans=False):
            assert await until(drive.bench, lambda: drive.status.state == "waiting", 2.0)
            await drive.bench.clock.sleep(1.0)
            assert blind.angular == 0.0
        drive.go()
        assert await drive.until("idle", 1.0)
        heading = blind.pose.theta
        await drive.until("never", 5.0)
        assert blind.pose.theta == pytest.approx(heading, abs=1e-6)


def picture(stamp: float, depth: np.ndarray | None = None) -> Image:
    if depth is None:
        # No two pictures of a living camera are the same.
        noise = np.random.default_rng(round(stamp * 100)).integers(0, 20, (48, 64))
        depth = (4000 + noise).astype(np.uint16)
    rotation = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    X_BC = Pose3(rotation, np.array([0.1, 0.0, 1.2]))
    color = np.zeros((48, 64, 3), dtype=np.uint8)
    return Image(stamp, "kinect", read_only(color), read_only(depth), CameraModel.from_vertical_fov(64, 48, 0.75), X_BC)


@in_virtual_time
async def test_a_dead_depth_camera_stops_it_by_name() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, camera=True, x=3.5, y=1.0) as drive:
        scan = world.scan

        depth: np.ndarray | None = None

        def scan_and_picture(stamp: float, fov: float = math.pi, rays: int = 181) -> LaserScan:
            drive.bench.feed("images", picture(stamp, depth))
            return scan(stamp, fov, rays)

        world.scan = scan_and_picture
        await drive.until("never", 2.0)
        assert world.linear > 0.1
        depth = np.zeros((48, 64), dtype=np.uint16)
        assert await drive.until("waiting", 1.5)
        assert "all zero" in drive.status.reason


@in_virtual_time
async def test_slow_zones_are_driven_slowly_and_half_the_speed_is_asked_for_by_the_desire() -> None:
    zone = Zone("ward", "slow", np.array([[2.0, 0.0], [3.9, 0.0], [3.9, 4.9], [2.0, 4.9]]), 0.25)
    world = DrivenWorld(HOUSE, Pose2(0.8, 1.0, 0.0))
    async with Drive(world, zones=(zone,), x=3.4, y=1.0) as drive:
        assert await drive.until("never", 5.0) is False
        assert world.pose.x > 2.1
        assert world.linear == pytest.approx(0.2, abs=0.03)
        zones = (replace(zone, name="none", polygon=zone.polygon + 100.0),)
        drive.bench.feed("zones", Zones(drive.bench.clock.now(), zones))
        drive.go(x=0.8, y=3.5, speed=0.5)
        speeds = []
        async with Living(world, drive.bench):
            for _ in range(60):
                await drive.bench.clock.sleep(0.1)
                speeds.append(world.linear)
        assert 0.3 < max(speeds) <= 0.4 + 1e-6


@in_virtual_time
async def test_its_last_word_is_a_stop() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=3.5, y=1.0) as drive:
        await drive.until("never", 2.0)
        assert drain(drive.twists)[-1].linear_mps > 0.2
        drive.bench.graph.filters.apply({"Tested.twist": math.inf})
        assert [t.linear_mps for t in drain(drive.twists)] == [0.0]


@in_virtual_time
async def test_boxed_in_it_tries_what_it_can_then_asks_for_help_and_goes_on_when_freed() -> None:
    cell = box(0.55, 0.55, 1.5, 1.5)
    world = DrivenWorld([*HOUSE, *cell], Pose2(1.0, 1.0, 0.0))
    async with Drive(world, settings={"stuck_s": 0.5, "wait_s": 0.2, "rounds": 1, "ask_s": 2.0}, x=3.0, y=3.5) as drive:
        async with Living(world, drive.bench):
            asked = await until(drive.bench, lambda: "clear its way" in drive.status.reason, 60)
        assert asked
        assert drive.status.state == "waiting"
        assert drive.status.recoveries >= 3
        assert world.nearest_m > 0.0
        world.segments = list(HOUSE)
        assert await drive.until("arrived", 60)


@in_virtual_time
async def test_the_costmap_is_reported_to_those_who_listen_at_most_five_times_a_second() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    async with Drive(world, x=3.5, y=1.0) as drive:
        heard = drive.bench.listen("costmap")
        await drive.until("never", 2.0)
        costmaps = drain(heard)
        assert 8 <= len(costmaps) <= 11
        assert costmaps[-1].frame == "odom"
        assert costmaps[-1].resolution_m == 0.025
        assert costmaps[-1].cells.shape == (160, 160)
        assert [c.version for c in costmaps] == sorted({c.version for c in costmaps})


@in_virtual_time
async def test_what_the_camera_sees_of_its_own_arm_is_left_out() -> None:
    drive = Drive(DrivenWorld(HOUSE, Pose2(2.0, 2.5, 0.0)), camera=True, arms=True)
    async with drive:
        stamp = drive.bench.clock.now()
        raised = {"left_shoulder_pitch_joint": -1.9, "left_elbow_joint": -0.3}
        hand = IRL1_MODEL.pose("left_hand_link", raised).translation
        # The camera looks at the hand, from half a metre before it: its middle sees the hand, its rim a wall.
        X_BC = Pose3(np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), hand + np.array([0.5, 0.0, 0.0]))
        depth = np.full((48, 64), 3000, dtype=np.uint16)
        depth[22:26, 30:34] = 500
        camera = CameraModel.from_vertical_fov(64, 48, 0.75)
        image = Image(stamp, "kinect", read_only(np.zeros((48, 64, 3), np.uint8)), read_only(depth), camera, X_BC)
        drive.bench.feed("joints", JointState(stamp, tuple(raised), tuple(raised.values())))
        await drive.bench.settle()
        drive.bench.feed("images", image)
        readings = drive.module._readings
        await until(drive.bench, lambda: readings.image is not None, 5.0)
        taken = readings.image
        assert taken is not None
        assert taken.depth is not None
        assert not taken.depth[22:26, 30:34].any()
        assert (taken.depth == 3000).sum() == 48 * 64 - 16


@in_virtual_time
async def test_a_way_is_planned_for_others_as_it_would_be_driven_and_nothing_moves() -> None:
    world = DrivenWorld(HOUSE, Pose2(1.0, 1.0, 0.0))
    stairs = Zone("stairs", "keep_out", read_only(np.array([[6.0, 3.5], [7.9, 3.5], [7.9, 4.9], [6.0, 4.9]])), 1.0)
    async with Drive(world, zones=(stairs,)) as drive:
        leg = await drive.routes.planner.leg(Pose2(1.0, 1.0, 0.0), Pose2(6.5, 1.2, math.nan), 1.0)
        assert leg.state == "way"
        assert 2.0 < float(np.interp(4.0, leg.path[:, 0], leg.path[:, 1])) < 2.9
        shut = await drive.routes.planner.leg(Pose2(1.0, 1.0, 0.0), Pose2(7.2, 4.2, math.nan), 1.0)
        assert "“stairs”" in shut.reason
        assert drain(drive.twists) == []
    with pytest.raises(MapUnavailable, match="plans no ways"):
        _ = drive.routes.planner
