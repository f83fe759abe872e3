"""PlanAndFollowPath: drives to a place on the map, around obstacles (thesis 4.2).

    ┌─────────────────────────────────────────────────────────────────────────────────────────────────┐
    │ PlanAndFollowPath  in   scans            LaserScan, 40 Hz / φ                                   │
    │                    in   images           Image with depth, 15 Hz / φ; not wired: no such camera │
    │                    in   odometry         Odometry, 100 Hz, X_OB in odom; never filtered         │
    │                    in   joints           JointState, 30 Hz; never filtered; not wired: no arms  │
    │                    in   localization     Localization, with each scan that SLAM takes           │
    │                    in   map              OccupancyGrid of the map, when it changes              │
    │                    in   zones            Zones of the map, when one changes                     │
    │                    in   base             Exploitation, 10 Hz: what its command became; or none  │
    │                    out  twist            Twist, each period while there is a goal               │
    │                    out  path             PlannedPath (map), when another way is taken           │
    │                    out  status           NavigationStatus, when it changes, or every 0.5 s      │
    │                    out  costmap          OccupancyGrid (odom), at most 5 Hz, while subscribed   │
    │                    out  accomplishments  Accomplishment, at the goal                            │
    └─────────────────────────────────────────────────────────────────────────────────────────────────┘

Every ``period_s`` (10 Hz as in the thesis), in the module's thread: the newest scan and image enter the costmap, and
the controller chooses velocities along the path (``navigation/tracking/path_tracker.py``). Paths are planned in the
second thread (``navigation/planning/global_planner.py``): once a second, and at once where an obstacle blocks the path
or localization jumped.

What the depth camera sees of the robot's own arms is left out (``navigation/costmap/self_filter.py``). Arms that are
stretched out count as part of the body (``navigation/tracking/arm_outline.py``).

It stands still, and publishes the reason, without a trusted pose, with a scan or image older than ``fresh_s``, or with
dead depth images. Obstacles that the camera sees and the laser does not are kept with the map
(``navigation/costmap/persistent_obstacle_layer.py``), also while another behavior drives, if the inputs are open.
Ways are planned for others, too, without driving (``app/maps/route_service.py``). The goal is given by the parameters
of the desire GoTo, the controller by the strategy: ``mppi``, ``pursuit``, ``dwa`` or ``dwa_published`` (the baseline of
the BARN challenge).

Follow is a subclass of it, whose goal moves (``follow/follow.py``).
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from app.base.errors import ConfigError
from app.base.geometry import Pose2
from app.base.joint_buffer import JointBuffer
from app.base.moving_shapes import BodyOutline, MovingShapes
from app.maps.library import MapLibrary
from app.maps.map_service import MapService, MapUnavailable
from app.maps.route_service import RouteLeg, RouteService
from app.messages import (
    Exploitation,
    Image,
    JointState,
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
from app.modules.behaviors.accomplishment_reporter import AccomplishmentReporter
from app.modules.behaviors.go_to import GO_TO, report_arrival
from app.modules.behaviors.navigation.costmap.persistent_obstacle_layer import PersistentObstacleLayer
from app.modules.behaviors.navigation.costmap.persistent_obstacle_store import PersistentObstacleStore
from app.modules.behaviors.navigation.costmap.self_filter import self_filtered
from app.modules.behaviors.navigation.kernel_loading import load_kernels
from app.modules.behaviors.navigation.planning.global_planner import GlobalPlanner, PlanRequest, PlanResult
from app.modules.behaviors.navigation.planning.route_planner import LegRequest, RouteFinder
from app.modules.behaviors.navigation.tracking.background_planner import BackgroundPlanner
from app.modules.behaviors.navigation.tracking.command_jitter import CommandJitter
from app.modules.behaviors.navigation.tracking.control_cycle import (
    ControlCycle,
    CycleInput,
    CycleOutput,
)
from app.modules.behaviors.navigation.tracking.desired_goal import goal_of
from app.modules.behaviors.navigation.tracking.localization_monitor import LocalizationMonitor
from app.modules.behaviors.navigation.tracking.navigation_settings import PlanAndFollowPathSettings
from app.modules.behaviors.navigation.tracking.path_tracker import NavigationGoal, TrackingStep
from app.modules.behaviors.navigation.tracking.posed_readings import PosedReadings
from app.modules.behaviors.navigation.tracking.replanning import MOVED
from app.modules.behaviors.navigation.tracking.status_publisher import StatusPublisher
from app.modules.body_shapes import moving_shapes
from app.modules.stream_module import robot_link
from app.runtime.errors import ModuleFailed
from app.runtime.module import Caution, Module, ModuleContext
from app.runtime.realtime import raise_thread_priority

#: Least period of published costmaps, s.
_COSTMAP_S = 0.2


class PlanAndFollowPath(Module):
    title = "Plan and follow path"
    desire_classes = (GO_TO,)
    Settings = PlanAndFollowPathSettings
    settings: PlanAndFollowPathSettings

    _control: ControlCycle
    _global_planner: GlobalPlanner
    _route_finder: RouteFinder

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self.scans = self.input("scans", LaserScan, capacity=4)
        self.images = self.input("images", Image)
        self.odometry = self.input("odometry", Odometry, capacity=100, always_open=True, rests=True)
        self.joints = self.input("joints", JointState, capacity=4, always_open=True, rests=True)
        self.localization = self.input("localization", Localization, rests=True)
        self.map = self.input("map", OccupancyGrid)
        self.zones = self.input("zones", Zones)
        self.base = self.input("base", Exploitation, always_open=True, rests=True)
        self.twist = self.output("twist", Twist)
        self.path = self.output("path", PlannedPath)
        self.status = self.output("status", NavigationStatus)
        self.costmap = self.output("costmap", OccupancyGrid)
        self._accomplishments = AccomplishmentReporter(self, self.desire_classes[0].name)
        self._poses = LocalizationMonitor()
        self._readings = PosedReadings(self._poses.at)
        self._planner = BackgroundPlanner(
            lambda request: self.compute_background(self._global_planner.find, request),
            self.fail,
            period_s=self.settings.replan_s,
            blocked_period_s=self.settings.blocked_replan_s,
            name=f"{self.name} plans",
        )
        self.on(self.scans, self._readings.add_scan)
        self.on(self.images, self._take_image)
        self.on(self.odometry, self._poses.add_odometry)
        self.on(self.joints, self._take_joints)
        self.on(self.localization, self._poses.add_localization)
        self.on(self.map, self._take_map)
        self.on(self.zones, self._take_zones)
        self.on(self.base, self._take_exploitation)
        self.every(self.settings.period_s, self._cycle)
        self._positions = JointBuffer()
        #: What the joints move: the camera may see it, and it may reach beyond the footprint; None: nothing.
        self._own: MovingShapes | None = None
        self._grid: OccupancyGrid | None = None
        self._zones = Zones(0.0, ())
        self._given_mps: float | None = None
        self._goal: NavigationGoal | None = None
        self._controller = self.settings.controller
        self._controller_in_use = self._controller
        self._status_publisher = StatusPublisher(self.status.publish, self.log)
        self._costmap_at = -math.inf
        self._costmap_version = 0
        self._leave_map: Callable[[], None] | None = None
        self._leave_routes: Callable[[], None] = lambda: None
        self._periods = CommandJitter()

    async def start(self) -> None:
        """Load the compiled kernels and look up the body. Raises ModuleFailed for a body that does not drive, or with
        joints whose shapes cannot be read."""
        description = robot_link(self).description
        outline: BodyOutline | None = None
        if self.joints.connected and description.groups and description.footprint:
            try:
                self._own = await self.compute(moving_shapes, description)
            except ConfigError as error:
                raise ModuleFailed(f"{self.name} does not know the arms of {description.name}: {error}") from None
            outline = BodyOutline(description.footprint, self._own)
        await self.compute(load_kernels)
        await self.compute(raise_thread_priority)
        try:
            self._control = await self.compute(
                lambda: ControlCycle(
                    description,
                    self._controller,
                    self.settings.of_control_cycle(),
                    depth=self.images.connected,
                    outline=outline,
                )
            )
        except ValueError as error:
            raise ModuleFailed(f"{self.name} cannot drive {description.name}: {error}") from None
        costs = self.settings.of_costs()
        self._global_planner = GlobalPlanner(self._control.footprint, costs)
        self._route_finder = RouteFinder(self._control.footprint, self._control.body, costs)
        await self._attach()
        # Messages from before a restart still hold.
        self._grid = None if self.map.channel is None else self.map.channel.latest
        self._zones = (None if self.zones.channel is None else self.zones.channel.latest) or self._zones

    async def _attach(self) -> None:
        """Keep obstacles with the map, and plan ways for others."""
        if self._control.persistent_obstacles is not None:
            await self._keep_with_map(self._control.persistent_obstacles)
        with contextlib.suppress(ModuleFailed):  # a program that does not offer ways drives all the same
            self._leave_routes = self.service(RouteService).attach(self)

    async def _keep_with_map(self, things: PersistentObstacleLayer) -> None:
        try:
            control, library = self.service(MapService), self.service(MapLibrary)
        except ModuleFailed:
            return  # without a map library, obstacles last as long as the module
        layer = PersistentObstacleStore(things, library, self.compute, self.compute_background, self.log)
        self._leave_map = await control.add(layer)

    async def stop(self) -> None:
        """Cancel planning and leave the map control and the service of ways."""
        self._leave_routes()
        if self._leave_map is not None:
            self._leave_map()
        self._planner.cancel()

    def configure(self, parameters: Mapping[str, Any]) -> None:
        """Take the desire's goal, and the strategy's ``controller``; without ``x`` and ``y`` there is no goal."""
        self._controller = str(parameters.get("controller", self.settings.controller))
        self._goal = goal_of(parameters, self._goal)

    def cautions(self) -> tuple[Caution, ...]:
        return self._accomplishments.cautions()

    def last_word(self, port: str) -> Twist | None:
        return Twist(self.clock.now(), 0.0, 0.0) if port == "twist" else None

    async def leg(self, start: Pose2, goal: Pose2, speed: float) -> RouteLeg:
        """Plan a way that is not driven now, between two plannings of the one that is. As :class:`RoutePlanner`."""
        # SLAM that rests lets no map through to this module, and the map in use is there all the same.
        grid = (None if self.map.channel is None else self.map.channel.latest) or self._grid
        if grid is None:
            raise MapUnavailable("there is no map yet: start SLAM")
        zones = (None if self.zones.channel is None else self.zones.channel.latest) or self._zones
        obstacles = await self.compute(self._control.persistent_points)
        request = LegRequest(grid, zones.zones, start, goal, speed=speed, persistent_obstacles=obstacles)
        return await self.compute_background(self._route_finder.find, request)

    # --- inputs ---

    async def _take_image(self, image: Image) -> None:
        own, positions = self._own, self._positions.at(image.stamp)
        if own is not None and positions is not None:
            image = await self.compute(lambda: self_filtered(image, own.at(positions)))
        self._readings.add_image(image)

    async def _take_joints(self, joints: JointState) -> None:
        self._positions.add(joints.stamp, dict(zip(joints.names, joints.positions, strict=True)))

    async def _take_map(self, grid: OccupancyGrid) -> None:
        self._grid = grid

    async def _take_zones(self, zones: Zones) -> None:
        self._zones = zones
        self._planner.want("zones changed")

    async def _take_exploitation(self, exploitation: Exploitation) -> None:
        self._given_mps = exploitation.twist.linear_mps if exploitation.behavior == self.name else 0.0

    # --- a cycle ---

    @property
    def _given(self) -> NavigationGoal | None:
        """The goal while the output is open; None where attention closed it because another behavior drives."""
        return self._goal if self.twist.filter.is_open else None

    def _end_of(self, goal: NavigationGoal) -> Pose2:
        """Where ``goal`` is now, on the map: the same object while it does not move."""
        return goal.pose

    def _limited(self, step: TrackingStep) -> TrackingStep:
        """The command that is published for ``step``."""
        return step

    def _arrived(self, goal: NavigationGoal, reason: str) -> None:
        """It stands at ``goal``; called in every cycle."""
        report_arrival(self._accomplishments, goal, reason)

    async def _cycle(self) -> None:
        now, goal = self.clock.now(), self._given
        if goal is None:
            self._periods.rest()
        if goal is None and self._status_publisher.idle:
            self._status_publisher.update(NavigationStatus(now, self.name, "idle", "no goal"))
            await self._observe(now)
            return
        problem = self._poses.problem(now)
        if not problem and self._grid is None:
            problem = "there is no map yet"
        motion = self._poses.motion(now)
        if motion is None:
            self._publish_stop(now, goal, problem)
            return
        answer = self._planner.take_answer(goal)
        inputs = CycleInput(
            now,
            motion,
            X_MO=self._poses.X_MO,
            problem=problem,
            goal=goal,
            scan=self._readings.take_scan(),
            image=self._readings.take_image(),
            plan=answer.plan if answer is not None and answer.changed else None,
            speed_at=None
            if answer is None
            else _speeds(answer, self._control.body.limits[1] * (goal.speed if goal else 1.0)),
            grid=self._grid,
            is_lost=self._poses.is_lost(now) and self._grid is not None,
            given_mps=self._given_mps,
            joints=self._positions.newest,
            moved=answer is not None and answer.why == MOVED,
        )
        if self._controller != self._controller_in_use:
            self._controller_in_use = self._controller
            try:
                await self.compute(self._control.use_controller, self._controller)
            except ValueError as error:
                raise ModuleFailed(f"{self.name}: {error}") from None
        output = await self.compute(self._control.run, inputs, self.settings.period_s)
        if self._given is not goal:
            # The desire changed during the computation: the result is for another goal.
            goal = None
        self._publish(now, output, goal, answer)
        if goal is not None and not problem and output.step.state != "arrived":
            self._plan_if_wanted(now, goal, output)
        if inputs.image is not None and inputs.goal is not None:
            await self.compute(self._control.remember, inputs)

    async def _observe(self, now: float) -> None:
        """Enter persistent obstacles while another behavior drives, on a body with a depth camera."""
        if self._control.persistent_obstacles is None:
            return
        motion, scan, image = self._poses.motion(now), self._readings.take_scan(), self._readings.take_image()
        if motion is not None and (scan is not None or image is not None):
            inputs = CycleInput(
                now, motion, X_MO=self._poses.X_MO, problem=self._poses.problem(now), goal=None, scan=scan, image=image
            )
            await self.compute(self._control.remember, inputs)

    def _publish(self, now: float, output: CycleOutput, goal: NavigationGoal | None, answer: PlanResult | None) -> None:
        if goal is None:
            self.twist.publish(Twist(now, 0.0, 0.0))
        else:
            step = self._limited(output.step)
            self.twist.publish(Twist(now, step.linear_mps, step.angular_radps, step.lateral_mps))
            self._periods.commanded(self.clock.now())
        if answer is not None and answer.changed:
            self._planner.plan = answer.plan
            self._publish_path(now, answer.plan.poses)
        self._status_publisher.update(
            NavigationStatus(
                now,
                self.name,
                state=output.step.state if goal is not None else "idle",
                reason=output.step.reason,
                goal=None if goal is None else self._end_of(goal),
                target=None if goal is None else output.target,
                remaining_m=None if goal is None else output.remaining_m,
                progress_stamp=None if goal is None else output.progress_stamp,
                recoveries=output.recoveries,
                period_s=self._periods.longest_s,
            )
        )
        if goal is None:
            if self._planner.drop():
                self._publish_path(now, np.empty((0, 3)))
        elif output.step.state == "arrived":
            self._arrived(goal, output.step.reason)
        if output.around is not None and self.costmap.wanted and now - self._costmap_at >= _COSTMAP_S - 1e-6:
            self._costmap_at = now
            self._costmap_version += 1
            self.costmap.publish(output.around.to_message(self._costmap_version))

    def _publish_stop(self, now: float, goal: NavigationGoal | None, problem: str) -> None:
        self.twist.publish(Twist(now, 0.0, 0.0))
        if goal is not None:
            self._periods.commanded(self.clock.now())
        state, end = ("idle", None) if goal is None else ("waiting", self._end_of(goal))
        period_s = self._periods.longest_s
        self._status_publisher.update(NavigationStatus(now, self.name, state, problem, end, period_s=period_s))

    def _publish_path(self, now: float, poses: Any) -> None:
        self.path.publish(PlannedPath(now, "map", read_only(np.array(poses, dtype=np.float64).reshape(-1, 3))))

    # --- planning, in the second thread ---

    def _plan_if_wanted(self, now: float, goal: NavigationGoal, output: CycleOutput) -> None:
        localization, grid, end = self._poses.localization, self._grid, self._end_of(goal)
        X_MO, X_MB = self._poses.X_MO, self._poses.X_MB(now)
        why = self._planner.due(now, goal, end, X_MO, output.step)
        if why is None or localization is None or grid is None or X_MB is None:
            return
        request = PlanRequest(
            grid,
            self._zones.zones,
            X_MO=localization.X_MO,
            X_MB=X_MB,
            goal=end,
            around=output.around,
            opened_up=output.opened_up,
            kept=self._planner.plan,
            why=why,
            footprint=output.footprint,
            persistent_obstacles=output.persistent_obstacles,
            tolerance_m=goal.tolerance_m if self.settings.taken_s else math.inf,
        )
        self._planner.begin(now, goal, request)


def _speeds(answer: PlanResult, speed_mps: float) -> Any:
    return lambda points: speed_mps * answer.speed_share(points)
