"""GoToward: heads straight for a place, around what the laser sees just now: a rudimentary GoTo (thesis 4.5).

    ┌───────────────────────────────────────────────────────────────────────────────────┐
    │ GoToward  in   scans            LaserScan, 40 Hz / φ                              │
    │           in   odometry         Odometry, 100 Hz, X_OB in odom; never filtered    │
    │           in   localization     Localization, with each scan that SLAM takes      │
    │           in   zones            Zones of the map, when one changes                │
    │           out  twist            Twist, each period while there is a goal          │
    │           out  status           NavigationStatus, when it changes, or every 0.5 s │
    │           out  accomplishments  Accomplishment, at the goal                       │
    └───────────────────────────────────────────────────────────────────────────────────┘

No map, plan, memory or depth: every ``period_s`` the Dynamic Window Approach (pure pursuit on a base that moves
sideways) follows the straight line to the goal in a distance field of the newest scan alone. It costs little CPU and
passes single obstacles. It does not leave a dead end and does not see obstacles lower than the laser. Without progress
it stops and publishes the reason.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import Field as Setting

from app.base.geometry import FloatArray, Pose2
from app.messages import LaserScan, Localization, NavigationStatus, Odometry, Twist, Zones
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.modules.behaviors.go_to import GO_TO, report_arrival
from app.modules.behaviors.navigation.controller import BodyModel, MotionState
from app.modules.behaviors.navigation.costmap.scan_costmap import points_of, scan_field
from app.modules.behaviors.navigation.costmap.zone_layer import speed_share
from app.modules.behaviors.navigation.kernel_loading import load_kernels
from app.modules.behaviors.navigation.planning.goal_planning import GlobalPlan
from app.modules.behaviors.navigation.planning.reference_path import SpeedAt
from app.modules.behaviors.navigation.recovery.recovery_behaviors import RecoverySettings
from app.modules.behaviors.navigation.tracking.desired_goal import goal_of
from app.modules.behaviors.navigation.tracking.dynamic_window import DynamicWindow, DynamicWindowSettings
from app.modules.behaviors.navigation.tracking.localization_monitor import LocalizationMonitor
from app.modules.behaviors.navigation.tracking.mppi import Mppi, MppiSettings
from app.modules.behaviors.navigation.tracking.path_tracker import NavigationGoal, PathTracker, TrackingStep
from app.modules.behaviors.navigation.tracking.sensor_health import unfit
from app.modules.behaviors.navigation.tracking.status_publisher import StatusPublisher
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Caution, Module, ModuleContext, Settings

#: Period of a new straight line, s.
_AIM_S = 1.0
#: Fewer samples than in PlanAndFollowPath, to save CPU; the straight line is only a rough path.
_CHEAP = DynamicWindowSettings(samples=(7, 15), horizon_s=2.0, ahead_m=2.5, weights=(0.05, 1.0, 0.03, 0.25))


class GoTowardSettings(Settings):
    period_s: float = Setting(0.1, gt=0, le=0.2, description="one control cycle")
    fresh_s: float = Setting(0.3, gt=0, le=1, description="an older scan is not driven by")


class GoToward(Module):
    title = "Go toward"
    desire_classes = (GO_TO,)
    Settings = GoTowardSettings
    settings: GoTowardSettings

    _path_tracker: PathTracker

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.scans = self.input("scans", LaserScan)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True, rests=True)
        self.localization = self.input("localization", Localization, rests=True)
        self.zones = self.input("zones", Zones)
        self.twist = self.output("twist", Twist)
        self.status = self.output("status", NavigationStatus)
        self._accomplishments = AccomplishmentReporter(self, GO_TO.name)
        self._poses = LocalizationMonitor()
        self.on(self.scans, self._take_scan)
        self.on(self.odometry, self._poses.add_odometry)
        self.on(self.localization, self._poses.add_localization)
        self.on(self.zones, self._take_zones)
        self.every(self.settings.period_s, self._cycle)
        self._status_publisher = StatusPublisher(self.status.publish, self.log)
        self._scan: LaserScan | None = None
        self._seen: tuple[float, FloatArray] | None = None
        self._zones = Zones(0.0, ())
        self._goal: NavigationGoal | None = None
        self._aimed_at = -math.inf

    async def start(self) -> None:
        """Look up the body. Raises ModuleFailed for a body that does not drive."""
        description = robot_link(self).description
        await self.compute(load_kernels)
        self._zones = (None if self.zones.channel is None else self.zones.channel.latest) or self._zones
        try:
            body = BodyModel.of(description.footprint, description.limits)
        except ValueError as error:
            raise ModuleFailed(f"{self.name} cannot drive {description.name}: {error}") from None
        # No recovery actions: the robot stops and publishes the reason.
        controller = Mppi(MppiSettings(rollouts=0)) if body.holonomic else DynamicWindow(_CHEAP)
        self._path_tracker = PathTracker(body, controller, recovery=RecoverySettings(stuck_s=math.inf))

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take the goal from the desire; without ``x`` and ``y`` there is no goal."""
        self._goal = goal_of(parameters, self._goal)

    def cautions(self) -> tuple[Caution, ...]:
        return self._accomplishments.cautions()

    def last_word(self, port: str) -> Twist | None:
        return Twist(self.clock.now(), 0.0, 0.0) if port == "twist" else None

    async def _take_scan(self, scan: LaserScan) -> None:
        self._scan = scan

    async def _take_zones(self, zones: Zones) -> None:
        self._zones = zones

    async def _cycle(self) -> None:
        now, goal = self.clock.now(), self._goal
        if goal is None and self._status_publisher.idle:
            self._status_publisher.update(NavigationStatus(now, self.name, "idle", "no goal"))
            return
        # Points of one scan keep their place in odom: a correction of the localization does not move them.
        scan = self._scan
        if scan is not None and (X_OB := self._poses.at(scan.stamp)) is not None:
            self._scan, self._seen = None, (scan.stamp, points_of(scan, X_OB))
        motion, X_MO = self._poses.motion(now), self._poses.X_MO
        problem = self._poses.problem(now) or unfit(
            now, None if self._seen is None else self._seen[0], None, self.settings.fresh_s
        )
        if goal is None or problem or motion is None or X_MO is None or self._seen is None:
            self._path_tracker.go(goal, now)
            step = TrackingStep(
                0.0, 0.0, "waiting" if goal is not None else "idle", problem if goal is not None else "no goal"
            )
        else:
            step = await self.compute(self._decide, now, goal, motion, X_MO, self._seen[1], self._zones)
        if self._goal is not goal:
            return
        self.twist.publish(Twist(now, step.linear_mps, step.angular_radps, step.lateral_mps))
        path_tracker = self._path_tracker
        self._status_publisher.update(
            NavigationStatus(
                now,
                self.name,
                state=step.state,
                reason=step.reason,
                goal=None if goal is None else goal.pose,
                target=path_tracker.target,
                remaining_m=path_tracker.remaining_m,
                progress_stamp=path_tracker.progress_stamp,
            )
        )
        if goal is not None and step.state == "arrived":
            report_arrival(self._accomplishments, goal, step.reason)

    def _decide(
        self, now: float, goal: NavigationGoal, motion: MotionState, X_MO: Pose2, seen: FloatArray, zones: Zones
    ) -> TrackingStep:
        """One cycle, in the module's thread; all poses on the map."""
        path_tracker = self._path_tracker
        X_MB = X_MO @ motion.pose
        if goal is not path_tracker.goal or now - self._aimed_at >= _AIM_S:
            path_tracker.go(goal, now)
            path_tracker.take(_straight(X_MB, goal.pose), now, self._speeds(goal, zones))
            self._aimed_at = now
        c, s = math.cos(X_MO.theta), math.sin(X_MO.theta)
        points = seen @ np.array([[c, s], [-s, c]]) + np.array([X_MO.x, X_MO.y])
        field = scan_field(points, zones.zones, X_MB)
        step = path_tracker.step(now, replace(motion, pose=X_MB), Pose2(), field, self.settings.period_s)
        if step.replan and step.state == "following":
            return replace(step, state="waiting", reason="something is in the way, and it knows no way around")
        return step

    def _speeds(self, goal: NavigationGoal, zones: Zones) -> SpeedAt | None:
        if not zones.zones:
            return None
        speed_mps = goal.speed * robot_link(self).description.limits.linear_mps
        return lambda points: np.array([speed_mps * speed_share(zones.zones, x, y)[0] for x, y in points])


def _straight(X_MB: Pose2, goal: Pose2) -> GlobalPlan:
    heading = math.atan2(goal.y - X_MB.y, goal.x - X_MB.x)
    length = math.hypot(goal.y - X_MB.y, goal.x - X_MB.x)
    poses = np.array([[X_MB.x, X_MB.y, heading], [goal.x, goal.y, heading]])
    return GlobalPlan("way", "", poses, goal, length)
