"""One control cycle on values: senses in, a decision out. Keeps the costmap and the follower; used by one thread."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.link import RobotDescription
from app.messages import Image, LaserScan, OccupancyGrid
from app.modules.behaviors.navigation.controller import Body, Controller, Field, Motion
from app.modules.behaviors.navigation.costmap.blind_corners import hidden_distance
from app.modules.behaviors.navigation.costmap.footprint import Footprint
from app.modules.behaviors.navigation.costmap.leg_inflation import beside
from app.modules.behaviors.navigation.costmap.local_costmap import CostmapSettings, LocalCostmap, Surroundings
from app.modules.behaviors.navigation.costmap.persistent_obstacle_layer import ThingsMemory
from app.modules.behaviors.navigation.costmap.scan_costmap import points_of
from app.modules.behaviors.navigation.planning.goal_planning import Plan
from app.modules.behaviors.navigation.planning.reference_path import SpeedAt
from app.modules.behaviors.navigation.recovery.recovery_behaviors import RecoverySettings
from app.modules.behaviors.navigation.recovery.stall_detector import Touch
from app.modules.behaviors.navigation.tracking.dynamic_window import PUBLISHED, DynamicWindow
from app.modules.behaviors.navigation.tracking.mppi import Mppi, MppiSettings
from app.modules.behaviors.navigation.tracking.path_tracker import Follower, FollowerSettings, Goal, Step
from app.modules.behaviors.navigation.tracking.sensor_health import DepthWatch, unfit, watch_depth

#: What strategies may choose from.
CONTROLLERS = ("mppi", "pursuit", "dwa", "dwa_published")
#: The published baseline pads a smaller body than the true one to 0.62 x 0.53 m: 0.05 m around the true one, of which
#: the margin within which a rollout counts as touching is a part.
_PUBLISHED_PADDING_M = 0.03


def controller_named(name: str, mppi: MppiSettings | None = None) -> Controller:
    """The controller ``name`` of :data:`CONTROLLERS`. Raises ValueError naming them for another."""
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
class PilotSettings:
    """What the pilot's parts are set to, and for how long a scan or a picture counts (s); ``people_m`` is taken for
    occupied around what may be a leg (0: none is looked for)."""

    costmap: CostmapSettings = field(default_factory=CostmapSettings)
    follower: FollowerSettings = field(default_factory=FollowerSettings)
    recovery: RecoverySettings = field(default_factory=RecoverySettings)
    fresh_s: float = 0.3
    people_m: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Senses:
    """What one cycle is given. ``scan`` and ``image`` are new ones, each with the body's pose at its stamp (of a scan,
    also at its last ray), or None. ``motion`` is the body now; ``X_MO`` where localization says ``odom`` is, None
    before it says so. ``problem`` says why neither must be believed; ``astray``: ``X_MO`` alone. ``plan`` is a new one
    to take, ``speed_at`` what zones allow on it. ``given_mps`` is what the base was given forward for the last cycle's
    command, which others may have stopped; None where nobody tells: the command itself.
    """

    now: float
    motion: Motion
    X_MO: Pose2 | None
    problem: str
    goal: Goal | None
    scan: tuple[LaserScan, Pose2, Pose2] | None = None
    image: tuple[Image, Pose2] | None = None
    plan: Plan | None = None
    speed_at: SpeedAt | None = None
    grid: OccupancyGrid | None = None
    astray: bool = False
    given_mps: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Told:
    """What one cycle decided, and what there is to tell of it. ``things`` (N, 2): all that is remembered, m on the
    map."""

    step: Step
    target: Pose2 | None
    remaining_m: float | None
    progress_stamp: float | None
    recoveries: int
    opened_up: bool
    around: Surroundings | None
    things: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 2)))


class Pilot:
    """Drives one body by one controller; ``depth``: it has a depth camera that must see."""

    def __init__(
        self, description: RobotDescription, controller: str, settings: PilotSettings | None = None, *, depth: bool
    ) -> None:
        """Raises ValueError for a body that does not move, or an unknown controller."""
        self._settings = settings or PilotSettings()
        self.footprint = Footprint.of(description)
        padding = _PUBLISHED_PADDING_M if controller == "dwa_published" else 0.0
        self.body = Body.of(description.footprint, description.limits, padding_m=padding)
        self._follower = Follower(
            self.body, controller_named(controller), self._settings.follower, self._settings.recovery
        )
        self._costmap = LocalCostmap(self.footprint, description.height_m, self._settings.costmap)
        self._scan_stamp: float | None = None
        self._scan: LaserScan | None = None
        self._scan_from = Pose2()
        self._laser_O: tuple[float, NDArray[np.float64]] | None = None
        self._depth = DepthWatch() if depth else None
        self._sent = (0.0, 0.0)
        self._touch = Touch(self.body)
        #: What the camera saw stand; None without one.
        self.things = ThingsMemory(self.footprint, description.height_m) if depth else None
        self._things = np.empty((0, 2))
        self._things_version = 0

    def steer_with(self, controller: str) -> None:
        """Go on with another controller. Raises ValueError for an unknown one."""
        self._follower.steer_with(controller_named(controller))

    def cycle(self, senses: Senses, period_s: float) -> Told:
        """Look, decide, and tell; a few milliseconds."""
        self._see(senses)
        if senses.scan is not None:
            self._costmap.add_scan(*senses.scan)
        if senses.image is not None and self._depth is not None and not self._depth.problem:
            self._costmap.add_depth(*senses.image)
        follower = self._follower
        follower.go(senses.goal, senses.now)
        if senses.plan is not None:
            follower.take(senses.plan, senses.now, senses.speed_at)
        blind = unfit(senses.now, self._scan_stamp, self._depth, self._settings.fresh_s)
        problem = senses.problem or blind
        if senses.goal is not None and not problem:
            self._feel(senses)
        around = self._costmap.around(senses.motion.pose, senses.now, self._known(senses))
        around = self._touch.laid_over(around, senses.now)
        careful = self._settings.follower.corner_share < 1.0 and senses.goal is not None
        hidden = hidden_distance(around.cells, around.resolution_m) if careful else None
        seen = Field(around.distance, around.origin, around.resolution_m, hidden)
        if senses.astray and not blind:
            step = follower.find_itself(senses.now, senses.motion, seen, period_s, senses.problem)
        else:
            X_MO = senses.X_MO or Pose2()
            step = follower.step(senses.now, senses.motion, X_MO, seen, period_s, unfit=problem)
        if step.clear:
            self._costmap.clear()
            self._touch.forget()
        step = self._within_reach(step, senses.motion, period_s)
        return Told(
            step,
            follower.target,
            remaining_m=follower.remaining_m,
            progress_stamp=follower.progress_stamp,
            recoveries=follower.recovery.count,
            opened_up=follower.opened_up,
            around=around,
            things=self._all_things(),
        )

    def remember(self, senses: Senses) -> None:
        """Keep what the camera sees in ``senses`` and the laser does not; not before :meth:`cycle` took them, or in
        place of it while there is no goal."""
        if senses.goal is None:
            self._see(senses)
        if self.things is None or senses.image is None or senses.X_MO is None or senses.problem:
            return
        image, X_OB = senses.image
        if self._depth is None or self._depth.problem or self._laser_O is None:
            return
        stamp, points = self._laser_O
        if abs(image.stamp - stamp) <= self._settings.fresh_s:
            self.things.look(image, senses.X_MO @ X_OB, senses.X_MO.transform(points))

    def _see(self, senses: Senses) -> None:
        if senses.scan is not None:
            scan, begin, _ = senses.scan
            self._scan, self._scan_stamp, self._scan_from = scan, scan.stamp, begin
            if self.things is not None:
                self._laser_O = scan.stamp, points_of(scan, begin)
        if senses.image is not None and self._depth is not None:
            self._depth = watch_depth(self._depth, senses.image[0], self._scan)

    def _feel(self, senses: Senses) -> None:
        given_mps = self._sent[0] if senses.given_mps is None else senses.given_mps
        felt = self._touch.feel(senses.now, given_mps, senses.motion)
        if felt and self.things is not None and senses.X_MO is not None:
            self.things.felt(senses.X_MO.transform(self._touch.newest), senses.now)

    def _known(self, senses: Senses) -> NDArray[np.float64] | None:
        """What is remembered around the body, and room beside people; m in ``odom``. The body keeps clear of it even
        where a way through is tried as a last resort: what is low there is touched before it is seen again."""
        if senses.X_MO is None or senses.problem:
            return None
        known = np.empty((0, 2))
        if self.things is not None:
            known = self.things.near(senses.X_MO, senses.motion.pose, 0.5 * self._settings.costmap.memory_m)
        if self._settings.people_m > 0.0 and self._scan is not None and senses.grid is not None:
            room = beside(self._scan, self._scan_from, senses.X_MO, senses.grid, self._settings.people_m)
            known = np.concatenate((known, room))
        return known

    def _all_things(self) -> NDArray[np.float64]:
        if self.things is not None and self.things.version != self._things_version:
            self._things, self._things_version = self.things.points, self.things.version
        return self._things

    def _within_reach(self, step: Step, motion: Motion, period_s: float) -> Step:
        """``step`` with velocities that the body can have a period from now; a stop is a stop at once."""
        sent, self._sent = self._sent, (0.0, 0.0)
        if step.linear_mps == 0.0 and step.angular_radps == 0.0:
            return step
        _, high, turn, linear_mps2, angular_radps2, braking = self.body.limits
        # What was sent counts, where the body follows it at all: what was measured is a moment old.
        v = _from(sent[0], motion.linear_mps, 2.0 * linear_mps2 * period_s)
        w = _from(sent[1], motion.angular_radps, 2.0 * angular_radps2 * period_s)
        linear = _between(step.linear_mps, v - braking * period_s, v + linear_mps2 * period_s)
        angular = _between(step.angular_radps, w - angular_radps2 * period_s, w + angular_radps2 * period_s)
        self._sent = (_between(linear, -high, high), _between(angular, -turn, turn))
        return Step(*self._sent, step.state, step.reason, step.clear, step.replan)


def _from(sent: float, measured: float, apart: float) -> float:
    return sent if abs(sent - measured) <= apart else measured


def _between(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
