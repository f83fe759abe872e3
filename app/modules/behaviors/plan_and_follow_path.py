"""PlanAndFollowPath: goes to a place on the map, around what stands in the way (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────────┐
    │ PlanAndFollowPath  in   scans         LaserScan, 40 Hz / φ                                   │
    │                    in   images        Image with depth, 15 Hz / φ; not wired: no such camera │
    │                    in   odometry      Odometry, 100 Hz, X_OB in odom; never filtered         │
    │                    in   localization  Localization, with each scan that SLAM takes           │
    │                    in   map           OccupancyGrid of the map, when it changes              │
    │                    in   zones         Zones of the map, when one changes                     │
    │                    in   base          Exploitation, 10 Hz: what its command became; or none  │
    │                    out  twist         Twist, each period while there is a goal               │
    │                    out  path          PlannedPath (map), when another way is taken           │
    │                    out  status        NavigationStatus, when it changes, or every 0.5 s      │
    │                    out  costmap       OccupancyGrid (odom), at most 5 Hz, if anybody listens  │
    └─────────────────────────────────────────────────────────────────────────────────────────────┘

Every ``period_s`` (10 Hz as in the thesis), in the module's thread: the newest scan and picture enter the costmap, and
the controller chooses velocities along the way (``navigation/follower.py``). Ways are planned in the second thread
(``navigation/wayfinder.py``): once a second, and at once where something is in the way or localization jumped.

It does not drive, and says so, without a pose it can trust, with a scan or picture older than ``fresh_s``, or with
depth pictures that are dead. What the camera sees and the laser does not is remembered on the map and kept with it
(``navigation/memory.py``), while others drive as well, if the inputs are open. The goal is the parameters of the desire
GoTo; which controller follows is one of the strategy: ``mppi``, ``pursuit``, ``dwa`` or ``dwa_published`` (the baseline
of the BARN challenge).
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from pydantic import Field

from app.base.geometry import Pose2
from app.maps.control import MapControl
from app.maps.library import MapLibrary
from app.messages import (
    Exploitation,
    Image,
    LaserScan,
    Localization,
    NavigationStatus,
    OccupancyGrid,
    Odometry,
    PlannedPath,
    Twist,
    Zones,
    read_only,
)
from app.modules.behaviors.go_to import GO_TO
from app.modules.behaviors.navigation.costmap.inflation import CostSettings
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapSettings
from app.modules.behaviors.navigation.costmap.persistent_obstacle_layer import ThingsMemory
from app.modules.behaviors.navigation.costmap.persistent_obstacle_store import ThingsKept
from app.modules.behaviors.navigation.kernels import load_kernels
from app.modules.behaviors.navigation.planning.global_planner import Answer, Request, Wayfinder
from app.modules.behaviors.navigation.planning.goal_planning import Plan
from app.modules.behaviors.navigation.recovery.recovery_behaviors import RecoverySettings
from app.modules.behaviors.navigation.tracking.command_jitter import Periods
from app.modules.behaviors.navigation.tracking.control_cycle import CONTROLLERS, Pilot, PilotSettings, Senses, Told
from app.modules.behaviors.navigation.tracking.desired_goal import goal_of
from app.modules.behaviors.navigation.tracking.localization_monitor import PoseWatch
from app.modules.behaviors.navigation.tracking.path_tracker import FollowerSettings, Goal
from app.modules.behaviors.navigation.tracking.status_publisher import Teller
from app.modules.body import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Module, ModuleContext, Settings
from app.runtime.realtime import go_first

#: Between two costmaps published, s.
_COSTMAP_S = 0.2
#: Localization that moved the robot further than that (m, rad) calls for another way at once.
_JUMP = (0.15, 0.1)


class PlanAndFollowPathSettings(Settings):
    """Settings of PlanAndFollowPath; what a body's speed asks for is set here, its sizes and limits come from it."""

    period_s: float = Field(0.1, gt=0, le=0.2, description="one control cycle")
    controller: str = Field(
        "mppi", pattern=f"^({'|'.join(CONTROLLERS)})$", description="while no strategy says another"
    )
    fresh_s: float = Field(0.3, gt=0, le=1, description="an older scan or picture is not driven by")
    replan_s: float = Field(1.0, gt=0, le=10, description="a better way is looked for this often")
    blocked_replan_s: float = Field(0.3, gt=0, le=10, description="... and this often where something is in the way")
    costmap_m: float = Field(4.0, ge=2, le=20, description="side of the costmap around the robot")
    costmap_resolution_m: float = Field(0.025, ge=0.01, le=0.1)
    keep_s: float = Field(45.0, gt=0, description="what stood still is remembered so long where nothing looks")
    unknown: str = Field("costly", pattern="^(free|costly|blocked)$", description="ways through unknown space")
    closeness: float = Field(
        6.0, ge=0, description="what a metre of way beside an obstacle costs more than in the open"
    )
    reach_m: float = Field(0.75, gt=0, le=3, description="further off than that an obstacle costs nothing")
    stuck_s: float = Field(2.0, gt=0, description="standing that long on the way calls for a recovery")
    wait_s: float = Field(2.0, ge=0, description="the first recovery: waiting for the way to clear")
    ask_s: float = Field(15.0, gt=0, description="people have so long to help, before it tries again")
    corner_share: float = Field(
        0.6, gt=0, le=1, description="of its speed, beside what it cannot see, as behind corners; 1: it does not care"
    )
    people_m: float = Field(
        0.0, ge=0, le=0.3, description="kept clear around what may be a leg that the map does not have; 0: nothing more"
    )
    rounds: int = Field(2, ge=1, description="of all recoveries, before people are asked")


class PlanAndFollowPath(Module):
    """Plans ways to goals on the map and follows them."""

    title = "Plan and follow path"
    desire_classes = (GO_TO,)
    Settings = PlanAndFollowPathSettings
    settings: PlanAndFollowPathSettings

    _pilot: Pilot
    _wayfinder: Wayfinder

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.scans = self.input("scans", LaserScan, capacity=4)
        self.images = self.input("images", Image)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True)
        self.localization = self.input("localization", Localization)
        self.map = self.input("map", OccupancyGrid)
        self.zones = self.input("zones", Zones)
        self.base = self.input("base", Exploitation, always_open=True)
        self.twist = self.output("twist", Twist)
        self.path = self.output("path", PlannedPath)
        self.status = self.output("status", NavigationStatus)
        self.costmap = self.output("costmap", OccupancyGrid)
        self.on(self.scans, self._see)
        self.on(self.images, self._look)
        self.on(self.odometry, self._feel)
        self.on(self.localization, self._localize)
        self.on(self.map, self._take_map)
        self.on(self.zones, self._take_zones)
        self.on(self.base, self._notice)
        self.every(self.settings.period_s, self._cycle)
        self._poses = PoseWatch()
        self._scan: LaserScan | None = None
        self._image: Image | None = None
        self._grid: OccupancyGrid | None = None
        self._zones = Zones(0.0, ())
        self._given_mps: float | None = None
        self._goal: Goal | None = None
        self._controller = self.settings.controller
        self._steering_with = self._controller
        self._planning: asyncio.Task[Answer] | None = None
        self._planned_at = -math.inf
        self._planned_from: Localization | None = None
        self._planned_for: Goal | None = None
        self._answer: Answer | None = None
        self._plan: Plan | None = None
        self._wanted_plan = ""
        self._teller = Teller(self.status.publish, self.log)
        self._costmap_at = -math.inf
        self._costmap_version = 0
        self._leave_map: Callable[[], None] | None = None
        self._periods = Periods()

    async def start(self) -> None:
        """Load what is compiled, and learn what the body is. Raises ModuleFailed for one that does not drive."""
        description = robot_link(self).description
        await self.compute(load_kernels)
        await self.compute(go_first)
        s = self.settings
        settings = PilotSettings(
            costmap=CostmapSettings(
                size_m=s.costmap_m,
                memory_m=max(8.0, 1.5 * s.costmap_m),
                resolution_m=s.costmap_resolution_m,
                keep_s=s.keep_s,
            ),
            follower=FollowerSettings(corner_share=s.corner_share),
            recovery=RecoverySettings(stuck_s=s.stuck_s, wait_s=s.wait_s, rounds=s.rounds, ask_s=s.ask_s),
            fresh_s=s.fresh_s,
            people_m=s.people_m,
        )
        try:
            self._pilot = await self.compute(
                lambda: Pilot(description, self._controller, settings, depth=self.images.connected)
            )
        except ValueError as error:
            raise ModuleFailed(f"{self.name} cannot drive {description.name}: {error}") from None
        costs = CostSettings(unknown=s.unknown, closeness=s.closeness, reach_m=s.reach_m)
        self._wayfinder = Wayfinder(self._pilot.footprint, costs)
        if self._pilot.things is not None:
            await self._keep_with_map(self._pilot.things)
        # What was said before a restart still holds.
        self._grid = None if self.map.channel is None else self.map.channel.latest
        self._zones = (None if self.zones.channel is None else self.zones.channel.latest) or self._zones

    async def _keep_with_map(self, things: ThingsMemory) -> None:
        try:
            control, library = self.service(MapControl), self.service(MapLibrary)
        except ModuleFailed:
            return  # where no maps are kept, what is remembered lasts as long as the module
        layer = ThingsKept(things, library, self.compute, self.compute_behind, self.log)
        self._leave_map = await control.add(layer)

    async def stop(self) -> None:
        """Look for no way any more."""
        if self._leave_map is not None:
            self._leave_map()
        if self._planning is not None:
            self._planning.cancel()

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take the desire's goal, and the strategy's ``controller``; without ``x`` and ``y`` nobody wants to go
        anywhere."""
        self._controller = str(parameters.get("controller", self.settings.controller))
        self._goal = goal_of(parameters, self._goal)

    def last_word(self, port: str) -> Twist | None:
        """A stop, when attention takes the wheel away."""
        return Twist(self.clock.now(), 0.0, 0.0) if port == "twist" else None

    # --- what comes in ---

    async def _see(self, scan: LaserScan) -> None:
        self._scan = scan

    async def _look(self, image: Image) -> None:
        self._image = image

    async def _feel(self, odometry: Odometry) -> None:
        self._poses.feel(odometry)

    async def _localize(self, localization: Localization) -> None:
        self._poses.localize(localization)

    async def _take_map(self, grid: OccupancyGrid) -> None:
        self._grid = grid

    async def _take_zones(self, zones: Zones) -> None:
        self._zones = zones
        self._wanted_plan = self._wanted_plan or "zones changed"

    async def _notice(self, exploitation: Exploitation) -> None:
        self._given_mps = exploitation.twist.linear_mps if exploitation.behavior == self.name else 0.0

    # --- a cycle ---

    @property
    def _given(self) -> Goal | None:
        """The goal, while attention has it go there: none where its output is closed, as another behavior drives."""
        return self._goal if self.twist.filter.is_open else None

    async def _cycle(self) -> None:
        now, goal = self.clock.now(), self._given
        if goal is None:
            self._periods.rest()
        if goal is None and self._teller.idle:
            self._teller.tell(NavigationStatus(now, self.name, "idle", "no goal"))
            await self._look_on(now)
            return
        problem = self._poses.problem(now)
        if not problem and self._grid is None:
            problem = "there is no map yet"
        motion = self._poses.motion(now)
        if motion is None:
            self._publish_stop(now, goal, problem)
            return
        answer, self._answer = self._answer, None
        if answer is not None and self._planned_for is not goal:
            answer = None
        senses = Senses(
            now, motion, self._poses.X_MO, problem, goal, self._scan_with_poses(), self._image_with_pose(),
            answer.plan if answer is not None and answer.changed else None,
            None if answer is None else _speeds(answer, self._pilot.body.limits[1] * (goal.speed if goal else 1.0)),
            self._grid, self._poses.astray(now) and self._grid is not None, self._given_mps,
        )  # fmt: skip
        if self._controller != self._steering_with:
            self._steering_with = self._controller
            await self.compute(self._pilot.steer_with, self._controller)
        told = await self.compute(self._pilot.cycle, senses, self.settings.period_s)
        if self._given is not goal:
            # Another desire came while this was decided: what was decided is not for it.
            goal = None
        self._publish(now, told, goal, answer)
        if goal is not None and not problem and told.step.state != "arrived":
            self._plan_if_wanted(now, goal, told)
        if senses.image is not None and senses.goal is not None:
            await self.compute(self._pilot.remember, senses)

    async def _look_on(self, now: float) -> None:
        """Remember what is seen while others drive, by a body that sees what is worth it."""
        if self._pilot.things is None:
            return
        motion, scan, image = self._poses.motion(now), self._scan_with_poses(), self._image_with_pose()
        if motion is not None and (scan is not None or image is not None):
            senses = Senses(now, motion, self._poses.X_MO, self._poses.problem(now), None, scan, image)
            await self.compute(self._pilot.remember, senses)

    def _scan_with_poses(self) -> tuple[LaserScan, Pose2, Pose2] | None:
        scan = self._scan
        if scan is None:
            return None
        begin, end = self._poses.at(scan.stamp), self._poses.at(scan.stamp + scan.duration_s)
        if begin is None or end is None:
            return None
        self._scan = None
        return scan, begin, end

    def _image_with_pose(self) -> tuple[Image, Pose2] | None:
        image = self._image
        X_OB = None if image is None else self._poses.at(image.stamp)
        if image is None or X_OB is None:
            return None
        self._image = None
        return image, X_OB

    def _publish(self, now: float, told: Told, goal: Goal | None, answer: Answer | None) -> None:
        if goal is None:
            self.twist.publish(Twist(now, 0.0, 0.0))
        else:
            self.twist.publish(Twist(now, told.step.linear_mps, told.step.angular_radps))
            self._periods.commanded(self.clock.now())
        if answer is not None and answer.changed:
            self._plan = answer.plan
            self._publish_path(now, answer.plan.poses)
        self._teller.tell(
            NavigationStatus(
                now, self.name, told.step.state if goal is not None else "idle", told.step.reason,
                None if goal is None else goal.pose, None if goal is None else told.target,
                None if goal is None else told.remaining_m, None if goal is None else told.progress_stamp,
                told.recoveries, self._periods.longest_s,
            )
        )  # fmt: skip
        if goal is None:
            self._planned_for = None
            self._forget_way(now)
        if told.around is not None and self.costmap.wanted and now - self._costmap_at >= _COSTMAP_S - 1e-6:
            self._costmap_at = now
            self._costmap_version += 1
            self.costmap.publish(told.around.to_message(self._costmap_version))

    def _publish_stop(self, now: float, goal: Goal | None, problem: str) -> None:
        self.twist.publish(Twist(now, 0.0, 0.0))
        if goal is not None:
            self._periods.commanded(self.clock.now())
        state = "idle" if goal is None else "waiting"
        self._teller.tell(
            NavigationStatus(
                now, self.name, state, problem, None if goal is None else goal.pose, period_s=self._periods.longest_s
            )
        )

    def _forget_way(self, now: float) -> None:
        if self._plan is not None:
            self._plan = None
            self._publish_path(now, np.empty((0, 3)))

    def _publish_path(self, now: float, poses: Any) -> None:
        self.path.publish(PlannedPath(now, "map", read_only(np.array(poses, dtype=np.float64).reshape(-1, 3))))

    # --- planning, behind ---

    def _plan_if_wanted(self, now: float, goal: Goal, told: Told) -> None:
        if self._planning is not None:
            return
        if self._planned_for is not goal:
            self._plan = None
        why = self._why_plan(now, goal, told)
        if why is None:
            return
        localization, grid = self._poses.localization, self._grid
        X_MB = self._poses.X_MB(now)
        if localization is None or grid is None or X_MB is None:
            return
        request = Request(
            grid, self._zones.zones, localization.X_MO, X_MB, goal.pose, told.around, told.opened_up, self._plan, why,
            told.things,
        )  # fmt: skip
        self._planned_at, self._planned_from, self._planned_for = now, localization, goal
        self._wanted_plan = ""
        finding = self.compute_behind(self._wayfinder.find, request)
        self._planning = asyncio.create_task(finding, name=f"{self.name} plans")
        self._planning.add_done_callback(self._planned)

    def _why_plan(self, now: float, goal: Goal, told: Told) -> str | None:
        """Why a way is looked for now: "" for a better one alone; None if it is not the time."""
        since = now - self._planned_at
        if self._planned_for is not goal:
            return "another goal"
        before, newest = self._planned_from, self._poses.localization
        if before is not None and newest is not None and _jumped(before.X_MO, newest.X_MO):
            return "localization corrected itself"
        wanted = told.step.replan or self._wanted_plan
        if wanted and since >= self.settings.blocked_replan_s:
            # What blocks the controller may not block the way: another is taken only if it is better or the old is not.
            return "" if self._plan is not None and len(self._plan.poses) and told.step.state == "following" else wanted
        return "" if since >= self.settings.replan_s else None

    def _planned(self, task: asyncio.Task[Answer]) -> None:
        self._planning = None
        if task.cancelled():
            return
        error = task.exception()
        if isinstance(error, Exception):
            self.fail(error)
        elif error is None:
            self._answer = task.result()


def _jumped(before: Pose2, now: Pose2) -> bool:
    moved = before.inverse() @ now
    return math.hypot(moved.x, moved.y) > _JUMP[0] or abs(moved.theta) > _JUMP[1]


def _speeds(answer: Answer, speed_mps: float) -> Any:
    return lambda points: speed_mps * answer.speed_share(points)
