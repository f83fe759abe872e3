"""One control cycle on values: sensor data in, a velocity command out. Owns the local costmap and the path tracker;
used by one thread."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.base.moving_shapes import BodyOutline
from app.link import RobotDescription
from app.messages import Image, LaserScan, OccupancyGrid
from app.modules.behaviors.navigation.controller import BodyModel, Controller, DistanceField, MotionState
from app.modules.behaviors.navigation.costmap.blind_corners import hidden_distance
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.leg_inflation import LegMemory
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapSettings, CostmapWindow, LocalCostmap
from app.modules.behaviors.navigation.costmap.persistent_obstacle_layer import PersistentObstacleLayer
from app.modules.behaviors.navigation.costmap.scan_costmap import points_of
from app.modules.behaviors.navigation.planning.goal_planning import GlobalPlan
from app.modules.behaviors.navigation.planning.reference_path import SpeedAt
from app.modules.behaviors.navigation.recovery.recovery_behaviors import RecoverySettings
from app.modules.behaviors.navigation.recovery.stall_detector import StallDetector
from app.modules.behaviors.navigation.tracking.arm_outline import ArmOutline
from app.modules.behaviors.navigation.tracking.dynamic_window import PUBLISHED, DynamicWindow
from app.modules.behaviors.navigation.tracking.mppi import Mppi, MppiSettings
from app.modules.behaviors.navigation.tracking.path_tracker import (
    NavigationGoal,
    PathTracker,
    PathTrackerSettings,
    TrackingStep,
)
from app.modules.behaviors.navigation.tracking.sensor_health import DepthHealth, unfit, update_depth_health

#: Names that a strategy may give as ``controller``.
CONTROLLERS = ("mppi", "pursuit", "dwa", "dwa_published")
#: Those that sample forward speed and turn alone: a third axis would multiply their samples.
FORWARD_ONLY = ("dwa", "dwa_published")
#: The published baseline pads a footprint smaller than the true one to 0.62 x 0.53 m: 0.05 m around the true one, which
#: includes the margin of contact of its rollouts.
_PUBLISHED_PADDING_M = 0.03


def controller_named(name: str, mppi: MppiSettings | None = None, *, holonomic: bool = False) -> Controller:
    """The controller ``name`` of :data:`CONTROLLERS`, for a ``holonomic`` body or a differential one.

    Raises ValueError naming them for another, and naming the suitable ones for one that cannot drive sideways where the
    body can.
    """
    if holonomic and name in FORWARD_ONLY:
        others = ", ".join(other for other in CONTROLLERS if other not in FORWARD_ONLY)
        raise ValueError(f"controller: {name} is for differential bases, and this base moves sideways; use {others}")
    match name:
        case "mppi":
            return Mppi(mppi)
        case "pursuit":
            return Mppi(MppiSettings(rollouts=0))
        case "dwa":
            return DynamicWindow()
        case "dwa_published":
            return DynamicWindow(PUBLISHED)
    raise ValueError(f"there is no controller {name!r}; there are {', '.join(CONTROLLERS)}")


@dataclass(frozen=True, slots=True)
class ControlCycleSettings:
    """Settings of the parts. ``fresh_s``: greatest age of a scan or image to drive by (s). ``people_m``: radius marked
    occupied around each leg candidate of the scan (m; 0: no leg detection)."""

    costmap: CostmapSettings = field(default_factory=CostmapSettings)
    path_tracker: PathTrackerSettings = field(default_factory=PathTrackerSettings)
    recovery: RecoverySettings = field(default_factory=RecoverySettings)
    fresh_s: float = 0.3
    people_m: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class CycleInput:
    """Input of one cycle. ``scan`` and ``image``: new data, each with the body's pose in ``odom`` at its stamp (for a
    scan, also at its last ray), or None. ``motion``: the body now; ``X_MO``: pose of ``odom`` on the map, None before
    the first localization. ``problem``: why neither may be used, "" if both may; ``is_lost``: only ``X_MO`` is
    unusable. ``plan``: a new plan; ``moved``: to where the goal has moved; ``speed_at``: the speed that zones allow
    along it. ``given_mps``: forward speed that the arbiter let through for the last command (m/s); None if it is not
    reported, then the command counts.
    ``joints``: the newest positions (rad, m) by name, None where they are not known.
    """

    now: float
    motion: MotionState
    X_MO: Pose2 | None
    problem: str
    goal: NavigationGoal | None
    scan: tuple[LaserScan, Pose2, Pose2] | None = None
    image: tuple[Image, Pose2] | None = None
    plan: GlobalPlan | None = None
    speed_at: SpeedAt | None = None
    grid: OccupancyGrid | None = None
    is_lost: bool = False
    given_mps: float | None = None
    joints: Mapping[str, float] | None = None
    moved: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class CycleOutput:
    """Result of one cycle: the command, its state for NavigationStatus, and the costmap. ``footprint``: of the body
    now, with its arms where they are stretched out. ``persistent_obstacles`` (N, 2): the whole persistent obstacle
    layer, m on the map."""

    step: TrackingStep
    footprint: Footprint
    target: Pose2 | None
    remaining_m: float | None
    progress_stamp: float | None
    recoveries: int
    opened_up: bool
    around: CostmapWindow | None
    persistent_obstacles: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))


class ControlCycle:
    """Drives one body with one controller. ``depth``: the body has a depth camera, and driving needs its images."""

    def __init__(
        self,
        description: RobotDescription,
        controller: str,
        settings: ControlCycleSettings | None = None,
        *,
        depth: bool,
        outline: BodyOutline | None = None,
    ) -> None:
        """``outline``: of a body with joints that may reach beyond its footprint, which :class:`CycleInput` brings.

        Raises ValueError for a body that does not move, or a controller that is unknown or not for this body."""
        self._settings = settings or ControlCycleSettings()
        self.footprint = Footprint.of(description)
        self._padding_m = _PUBLISHED_PADDING_M if controller == "dwa_published" else 0.0
        self.body = BodyModel.of(description.footprint, description.limits, padding_m=self._padding_m)
        self._arms = None if outline is None else ArmOutline(outline, description.footprint)
        self._footprint_now = self.footprint
        self._path_tracker = PathTracker(
            self.body,
            controller_named(controller, holonomic=self.body.holonomic),
            self._settings.path_tracker,
            self._settings.recovery,
        )
        self._costmap = LocalCostmap(self.footprint, description.height_m, self._settings.costmap)
        self._scan_stamp: float | None = None
        self._scan: LaserScan | None = None
        self._legs = LegMemory(self._settings.costmap)
        self._laser_O: tuple[float, NDArray[np.float64]] | None = None
        self._depth = DepthHealth() if depth else None
        self._limits = description.limits
        self._sent = (0.0, 0.0, 0.0)
        self._stall = StallDetector(self.body)
        #: Obstacles seen by the depth camera; None without one.
        self.persistent_obstacles = PersistentObstacleLayer(self.footprint, description.height_m) if depth else None
        self._persistent_points = np.empty((0, 2))
        self._persistent_version = 0

    def use_controller(self, controller: str) -> None:
        """Replace the controller. Raises ValueError for one that is unknown or not for this body."""
        self._path_tracker.use_controller(controller_named(controller, holonomic=self.body.holonomic))

    def run(self, inputs: CycleInput, period_s: float) -> CycleOutput:
        """Update the costmap, choose velocities, return the result; takes a few milliseconds."""
        self._see(inputs)
        self._fit(inputs.joints)
        if inputs.scan is not None:
            self._costmap.add_scan(*inputs.scan)
        if inputs.image is not None and self._depth is not None and not self._depth.problem:
            self._costmap.add_depth(*inputs.image)
        path_tracker = self._path_tracker
        path_tracker.go(inputs.goal, inputs.now)
        if inputs.plan is not None:
            if inputs.moved:
                path_tracker.goal_moved()
            path_tracker.take(inputs.plan, inputs.now, inputs.speed_at)
        blind = unfit(inputs.now, self._scan_stamp, self._depth, self._settings.fresh_s)
        problem = inputs.problem or blind
        if inputs.goal is not None and not problem:
            self._detect_stall(inputs)
        around = self._costmap.around(inputs.motion.pose, inputs.now, self._known(inputs))
        around = self._stall.laid_over(around, inputs.now)
        careful = self._settings.path_tracker.corner_share < 1.0 and inputs.goal is not None
        hidden = hidden_distance(around.cells, around.resolution_m) if careful else None
        seen = DistanceField(around.distance, around.origin, around.resolution_m, hidden)
        if inputs.is_lost and not blind:
            step = path_tracker.relocalize(inputs.now, inputs.motion, seen, period_s, inputs.problem)
        else:
            X_MO = inputs.X_MO or Pose2()
            step = path_tracker.step(inputs.now, inputs.motion, X_MO, seen, period_s, unfit=problem)
        if step.clear:
            self._costmap.clear()
            self._stall.clear()
        step = self._within_reach(step, inputs.motion, period_s)
        return CycleOutput(
            step,
            self._footprint_now,
            path_tracker.target,
            remaining_m=path_tracker.remaining_m,
            progress_stamp=path_tracker.progress_stamp,
            recoveries=path_tracker.recovery.count,
            opened_up=path_tracker.opened_up,
            around=around,
            persistent_obstacles=self.persistent_points(),
        )

    def remember(self, inputs: CycleInput) -> None:
        """Enter obstacles of ``inputs.image`` that the laser does not see into the persistent layer. Call it after
        :meth:`run` with the same inputs, or alone while there is no goal."""
        if inputs.goal is None:
            self._see(inputs)
        if self.persistent_obstacles is None or inputs.image is None or inputs.X_MO is None or inputs.problem:
            return
        image, X_OB = inputs.image
        if self._depth is None or self._depth.problem or self._laser_O is None:
            return
        stamp, points = self._laser_O
        if abs(image.stamp - stamp) <= self._settings.fresh_s:
            self.persistent_obstacles.look(image, inputs.X_MO @ X_OB, inputs.X_MO.transform(points))

    def _see(self, inputs: CycleInput) -> None:
        if inputs.scan is not None:
            scan, begin, _ = inputs.scan
            self._scan, self._scan_stamp = scan, scan.stamp
            if self.persistent_obstacles is not None:
                self._laser_O = scan.stamp, points_of(scan, begin)
        if inputs.image is not None and self._depth is not None:
            self._depth = update_depth_health(self._depth, inputs.image[0], self._scan)

    def _fit(self, positions: Mapping[str, float] | None) -> None:
        """Plan and drive with the outline of the body at these joint positions."""
        arms = self._arms
        if arms is None or positions is None or not arms.update(positions):
            return
        self._footprint_now, body = self.footprint, self.body
        if arms.stretched:
            corners = np.array(arms.corners, dtype=np.float64)
            self._footprint_now = Footprint.stretched(corners, sideways=self.body.holonomic)
            body = BodyModel.of(arms.corners, self._limits, padding_m=self._padding_m)
        self._path_tracker.use_body(body)

    def _detect_stall(self, inputs: CycleInput) -> None:
        given_mps = self._sent[0] if inputs.given_mps is None else inputs.given_mps
        stalled = self._stall.update(inputs.now, given_mps, inputs.motion)
        if stalled and self.persistent_obstacles is not None and inputs.X_MO is not None:
            self.persistent_obstacles.add_contacts(inputs.X_MO.transform(self._stall.newest), inputs.now)

    def _known(self, inputs: CycleInput) -> NDArray[np.float64] | None:
        """Persistent obstacles around the body and room beside people; m in ``odom``. They stay occupied even where the
        planner opens unknown space as a last resort: the body would touch a low obstacle before the camera sees it
        again."""
        if inputs.X_MO is None or inputs.problem:
            return None
        known = np.empty((0, 2))
        if self.persistent_obstacles is not None:
            known = self.persistent_obstacles.near(
                inputs.X_MO, inputs.motion.pose, 0.5 * self._settings.costmap.memory_m
            )
        if self._settings.people_m > 0.0:
            if inputs.scan is not None and inputs.grid is not None:
                scan, begin, _ = inputs.scan
                self._legs.see(scan, begin, inputs.X_MO, inputs.grid)
            # A recovery that clears the costmap leaves these: beside the body nothing would show them again.
            known = np.concatenate((known, self._legs.room(inputs.now, self._settings.people_m)))
        return known

    def persistent_points(self) -> NDArray[np.float64]:
        """The middles (N, 2) of the kept persistent obstacles, m on the map; the same object until they change."""
        if self.persistent_obstacles is not None and self.persistent_obstacles.version != self._persistent_version:
            self._persistent_points, self._persistent_version = (
                self.persistent_obstacles.points,
                self.persistent_obstacles.version,
            )
        return self._persistent_points

    def _within_reach(self, step: TrackingStep, motion: MotionState, period_s: float) -> TrackingStep:
        """``step`` with velocities that the body can reach within one period; a stop is commanded at once."""
        sent, self._sent = self._sent, (0.0, 0.0, 0.0)
        if step.linear_mps == 0.0 and step.angular_radps == 0.0 and step.lateral_mps == 0.0:
            return step
        limits = self._limits
        # The last command counts as long as the body follows it: the measured velocity is older.
        v = _from(sent[0], motion.linear_mps, 2.0 * limits.linear_mps2 * period_s)
        w = _from(sent[1], motion.angular_radps, 2.0 * limits.angular_radps2 * period_s)
        u = _from(sent[2], motion.lateral_mps, 2.0 * limits.linear_mps2 * period_s)
        linear, lateral = limits.within_speeds(*limits.ramped((v, u), (step.linear_mps, step.lateral_mps), period_s))
        change, turn = limits.angular_radps2 * period_s, limits.angular_radps
        angular = _between(_between(step.angular_radps, w - change, w + change), -turn, turn)
        self._sent = (linear, angular, lateral)
        return replace(step, linear_mps=linear, angular_radps=angular, lateral_mps=lateral)


def _from(sent: float, measured: float, apart: float) -> float:
    return sent if abs(sent - measured) <= apart else measured


def _between(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
