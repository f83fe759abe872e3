"""Path tracker: follows a plan to its goal; each cycle gives a command and a state for NavigationStatus.

    planning ─▶ following ─▶ (at the target) turning ─▶ arrived        waiting: something it needs is missing
                   │  ▲
      no progress  ▼  │ the measure is over
                recovering ─▶ waiting for people's help         (lost on the map: turning to find itself)

Beside a goal where something stands that the map does not have, it waits a while for room, and watches the goal.

Poses: ``X_OB`` the body in ``odom``, ``X_MO`` as localization says. Controllers see ``odom`` alone.
"""

# mypy: allow-untyped-calls

from __future__ import annotations

import math
from dataclasses import dataclass

from app.base.geometry import Pose2, wrap_angle
from app.modules.behaviors.navigation.controller import BodyModel, Controller, DistanceField, MotionState
from app.modules.behaviors.navigation.costmap.blind_corners import careful
from app.modules.behaviors.navigation.planning.goal_planning import SUBSTITUTES, GlobalPlan
from app.modules.behaviors.navigation.planning.reference_path import ReferencePath, SpeedAt
from app.modules.behaviors.navigation.recovery.driven_area import DrivenArea, back_toward
from app.modules.behaviors.navigation.recovery.recovery_behaviors import (
    Recovery,
    RecoveryAction,
    RecoverySettings,
    SpinSearch,
)

#: Speeds (m/s, rad/s) below which the body counts as standing.
STANDING = (0.03, 0.06)
#: Decrease of the distance to the goal that counts as progress, m.
_NEARER_M = 0.02
#: Decrease that resets the time without progress, m: creeping does not.
_GETTING_ON_M = 0.1
#: Decrease that ends the recovery, m.
_OUT_OF_TROUBLE_M = 0.3
#: The body need not stop nearer (m) to the end of a plan.
_FINEST_M = 0.05
#: Waiting for room at its goal, the body faces it within this, rad.
_WATCH_RAD = 0.2
#: Number of longer plans that do not count as a step back.
_DETOURS = 12
#: Codes of plans without a path that may succeed later without a change of the goal.
_MAY_PASS = frozenset({"in_the_way", "start_stuck", "start_outside"})


@dataclass(frozen=True, slots=True)
class NavigationGoal:
    """A goal on the map; ``pose.theta`` NaN for any heading. ``speed``: share of the body's speeds."""

    pose: Pose2
    tolerance_m: float = 0.25
    tolerance_rad: float = 0.2
    speed: float = 1.0


@dataclass(frozen=True, slots=True)
class PathTrackerSettings:
    """``look_ahead_s``: the local path covers this time at full speed. ``aim``: share of a tolerance within which the
    body stops. ``spare_m``: clearance for turns and recovery actions. ``corner_share``: share of the speed beside blind
    corners (1: no reduction), which ends at ``corner_m`` from them. ``taken_s``: so long it waits for a goal that is
    taken."""

    look_ahead_s: float = 3.0
    least_ahead_m: float = 2.5
    aim: float = 0.6
    spare_m: float = 0.03
    corner_share: float = 1.0
    corner_m: float = 1.0
    taken_s: float = 30.0
    back_mps: float = 0.15
    turn_radps: float = 0.8


@dataclass(frozen=True, slots=True)
class TrackingStep:
    """Result of one cycle: velocities, state and reason. ``clear``: the costmap must be cleared. ``replan``: reason for
    a new plan now, "" for none."""

    linear_mps: float
    angular_radps: float
    state: str
    reason: str
    clear: bool = False
    replan: str = ""
    lateral_mps: float = 0.0


class PathTracker:
    """Drives one body to one goal after another."""

    def __init__(
        self,
        body: BodyModel,
        controller: Controller,
        settings: PathTrackerSettings | None = None,
        recovery: RecoverySettings | None = None,
    ) -> None:
        self.settings = settings or PathTrackerSettings()
        self.recovery = Recovery(recovery)
        self._search = SpinSearch(self.recovery.settings)
        self._body = body
        self._controller = controller
        self._driven_area = DrivenArea()
        self.goal: NavigationGoal | None = None
        self.plan: GlobalPlan | None = None
        self.remaining_m: float | None = None
        self.progress_stamp: float | None = None
        #: Plans may cross unknown cells and transient obstacles at no extra cost.
        self.opened_up = False
        self._track: ReferencePath | None = None
        self._least = math.inf
        self._troubled_at = math.inf
        self._detours = 0
        self._held_since: float | None = None
        self._held_at = math.inf
        self._at_place = False
        #: Since when it waits for room at its goal.
        self._taken_since: float | None = None
        self._arrived = False
        self._begin = MotionState(Pose2(), 0.0, 0.0)
        self._X_OM = Pose2()
        self._turned = 0.0
        self._turn_sign = 1.0
        self._left_to_turn = 0.0

    # --- inputs ---

    def use_controller(self, controller: Controller) -> None:
        self._controller = controller

    def use_body(self, body: BodyModel) -> None:
        """Take another outline of the same body: its arms moved."""
        self._body = body

    def go(self, goal: NavigationGoal | None, now: float) -> None:
        """Another goal, or none; the same object changes nothing."""
        if goal is self.goal:
            return
        self.goal, self.plan, self._track = goal, None, None
        self.remaining_m, self.progress_stamp = None, None if goal is None else now
        self._least, self._troubled_at, self._detours = math.inf, math.inf, 0
        self._at_place = self._arrived = self.opened_up = False
        self._held_since = self._taken_since = None
        self.recovery.reset()
        self._search.end()
        self._controller.reset()

    def take(self, plan: GlobalPlan, now: float, speed_at: SpeedAt | None = None) -> None:
        """Take a plan to the goal, from about the body's pose. ``speed_at``: the greatest speed (m/s) by place on the
        map."""
        if self.plan is not None and self.plan.code in SUBSTITUTES and self.plan.code != plan.code:
            self._at_place = False
        self.plan = plan
        if len(plan.poses) == 0:
            self._track, self.remaining_m = None, None
            return
        body = self._driven_body()
        self._track = ReferencePath(
            plan.poses, speed_mps=body.limits[1], braking_mps2=body.limits[5], speed_at=speed_at
        )
        if self._track.length_m > self._least + _NEARER_M and self._detours < _DETOURS:
            self._detours += 1
            self._least = self._track.length_m

    def goal_moved(self) -> None:
        """The goal has moved on, as a person does who is followed: progress is measured along the next plan alone."""
        self._least = self._held_at = math.inf

    @property
    def target(self) -> Pose2 | None:
        """End of the plan in force, on the map; heading NaN for any."""
        return None if self.plan is None else self.plan.target

    # --- decisions ---

    def step(
        self, now: float, motion: MotionState, X_MO: Pose2, field: DistanceField, period_s: float, *, unfit: str = ""
    ) -> TrackingStep:
        """One cycle. ``unfit``: reason not to drive; the pose and the field may then be meaningless."""
        if self.goal is None:
            return TrackingStep(0.0, 0.0, "idle", "no goal")
        if unfit:
            self._controller.reset()
            self._held_since = None
            return TrackingStep(0.0, 0.0, "waiting", unfit)
        self._search.end()
        self._X_OM = X_MO.inverse()
        if motion.linear_mps > 0.01:
            self._driven_area.add(motion.pose)
        if self._arrived:
            return TrackingStep(0.0, 0.0, "arrived", self._arrival())
        if self.plan is None:
            return TrackingStep(0.0, 0.0, "planning", "looking for a way", replan="there is no way yet")
        if self.recovery.current is not None:
            return self._recover(now, motion, field, period_s)
        if self._track is None:
            return self._without_way(now, motion, field, period_s)
        return self._follow(now, motion, X_MO, field, period_s)

    def _driven_body(self) -> BodyModel:
        return self._body if self.goal is None or self.goal.speed >= 1.0 else self._body.limited(self.goal.speed)

    def _without_way(self, now: float, motion: MotionState, field: DistanceField, period_s: float) -> TrackingStep:
        assert self.plan is not None
        if self.plan.code == "arms":
            # They are lowered by themselves, or another behavior holds them: no motion of the base helps.
            return TrackingStep(0.0, 0.0, "waiting", self.plan.reason, replan=self.plan.reason)
        if self.plan.code not in _MAY_PASS:
            return TrackingStep(0.0, 0.0, "unreachable", self.plan.reason, replan=self.plan.reason)
        if self._held(now, still=True):
            return self._begin_measure(now, motion, field, period_s)
        return TrackingStep(0.0, 0.0, "waiting", self.plan.reason, replan=self.plan.reason)

    def _follow(
        self, now: float, motion: MotionState, X_MO: Pose2, field: DistanceField, period_s: float
    ) -> TrackingStep:
        assert self._track is not None
        assert self.goal is not None
        X_MB = X_MO @ motion.pose
        self.remaining_m, _ = self._track.come_to(X_MB)
        end = self._track.end
        distance = math.hypot(end.x - X_MB.x, end.y - X_MB.y)
        if self.remaining_m < self._least - _NEARER_M:
            self._least, self.progress_stamp = self.remaining_m, now
            if self._least < self._held_at - _GETTING_ON_M:
                self._held_since, self._held_at = None, self._least
            if self._least < self._troubled_at - _OUT_OF_TROUBLE_M:
                self.recovery.succeeded()
                self._troubled_at, self.opened_up = math.inf, False
        if self._at_place and distance > 1.3 * self.goal.tolerance_m:
            self._at_place = False
        near = distance <= self.goal.tolerance_m and self.remaining_m <= 2 * self.goal.tolerance_m
        if self._at_place or (near and distance <= self._stop_within_m(self.goal)):
            self._at_place = True
            if self._is_taken(now):
                return self._wait_for_room(now, motion, X_MB, field, period_s)
            return self._turn_to_heading(now, motion, X_MB, field, period_s)
        body = self._driven_body()
        ahead = max(self.settings.least_ahead_m, self.settings.look_ahead_s * body.limits[1])
        way = self._track.ahead(self._X_OM, ahead)
        if field.hidden is not None:
            way = careful(
                way,
                field,
                hidden=field.hidden,
                speed_mps=body.limits[1],
                share=self.settings.corner_share,
                reach_m=self.settings.corner_m,
            )
        choice = self._controller.choose(motion, field, way, body, period_s)
        # Either no motion is admissible, or the body does not move as commanded.
        still = choice.blocked or (motion.speed_mps < 0.02 and abs(motion.angular_radps) < 0.05)
        if self._held(now, still=still):
            if near:
                self._at_place = True
            else:
                return self._begin_measure(now, motion, field, period_s)
        words = "something is in the way" if choice.blocked else ""
        if not words and self.plan is not None:
            words = self.plan.reason
        return TrackingStep(
            choice.linear_mps, choice.angular_radps, "following", words,
            replan="something is in the way" if choice.blocked else "", lateral_mps=choice.lateral_mps,
        )  # fmt: skip

    def _held(self, now: float, *, still: bool) -> bool:
        """Whether the body has made no progress for so long that recovery must begin."""
        if self._held_since is None:
            self._held_since, self._held_at = now, self._least
        # A standstill is detected at once; oscillation takes longer to distinguish from a detour.
        patience = self.recovery.settings.stuck_s * (1.0 if still else 4.0)
        return now - self._held_since >= patience

    def _turn_to_heading(
        self, now: float, motion: MotionState, X_MB: Pose2, field: DistanceField, period_s: float
    ) -> TrackingStep:
        assert self.goal is not None
        target = self.target
        heading = math.nan if target is None else target.theta
        error = 0.0 if math.isnan(heading) else wrap_angle(heading - X_MB.theta)
        standing = motion.speed_mps < STANDING[0] and abs(motion.angular_radps) < STANDING[1]
        if abs(error) <= self.settings.aim * self.goal.tolerance_rad:
            if standing:
                self._arrived = True
                self.remaining_m, self.progress_stamp = 0.0, now
                return TrackingStep(0.0, 0.0, "arrived", self._arrival())
            return TrackingStep(0.0, 0.0, "following", "stopping at the goal")
        turn = self._turn(error, motion, field, period_s)
        if abs(error) < self._left_to_turn - 0.02:
            self._held_since, self.progress_stamp = None, now
        self._left_to_turn = abs(error)
        if turn is None:
            if self._held(now, still=True):
                return self._begin_measure(now, motion, field, period_s)
            return TrackingStep(0.0, 0.0, "following", "there is no room to turn to the heading asked for")
        return TrackingStep(0.0, turn, "following", "turning to the heading asked for")

    def _stop_within_m(self, goal: NavigationGoal) -> float:
        """How near to the end of the plan the body stops: within the tolerance of the goal itself, if the end is."""
        plan = self.plan
        away_m = plan.away_m(goal.pose) if plan is not None and plan.code in SUBSTITUTES else 0.0
        left_m = goal.tolerance_m - away_m if away_m < goal.tolerance_m else goal.tolerance_m
        return max(self.settings.aim * left_m, min(_FINEST_M, self.settings.aim * goal.tolerance_m))

    def _is_taken(self, now: float) -> bool:
        """Whether what stands in the goal may still go."""
        if self.plan is None or self.plan.code != "taken":
            return False
        self._taken_since = now if self._taken_since is None else self._taken_since
        return now - self._taken_since < self.settings.taken_s

    def _wait_for_room(
        self, now: float, motion: MotionState, X_MB: Pose2, field: DistanceField, period_s: float
    ) -> TrackingStep:
        """Face the goal: the sensors see only ahead."""
        assert self.goal is not None
        assert self.plan is not None
        self._held_since, self.progress_stamp = None, now
        goal = self.goal.pose
        error = wrap_angle(math.atan2(goal.y - X_MB.y, goal.x - X_MB.x) - X_MB.theta)
        turn = self._turn(error, motion, field, period_s) if abs(error) > _WATCH_RAD else None
        return TrackingStep(0.0, turn or 0.0, "waiting", f"it waits for room: {self.plan.reason}")

    def _arrival(self) -> str:
        return self.plan.reason if self.plan is not None and self.plan.code in SUBSTITUTES else ""

    def _turn(self, error: float, motion: MotionState, field: DistanceField, period_s: float) -> float | None:
        """Rate (rad/s) of a turn on the spot that reduces ``error`` (rad); None if an obstacle bars it."""
        _, _, turn, _, angular_mps2, *_ = self._driven_body().limits
        rate = min(
            self.settings.turn_radps, turn, math.sqrt(2.0 * 0.4 * angular_mps2 * abs(error)), 1.5 * abs(error) + 0.05
        )
        rate = math.copysign(rate, error)
        for share in (1.0, 0.4):
            if self._free(motion, field, 0.0, share * rate, period_s):
                return share * rate
        return None

    def _free(self, motion: MotionState, field: DistanceField, linear: float, angular: float, period_s: float) -> bool:
        from app.modules.behaviors.navigation.tracking.rollout_kernels import can_stop

        return bool(
            can_stop(
                field.distances, field.frame, self._body.outline, self._body.radii, self._body.limits, motion.state,
                (linear, angular, 0.0), period_s + 0.05, self.settings.spare_m,
            )
        )  # fmt: skip

    # --- recovery ---

    def relocalize(
        self, now: float, motion: MotionState, field: DistanceField, period_s: float, lost: str
    ) -> TrackingStep:
        """One cycle in place of :meth:`step` while the pose on the map is unknown; ``lost``: the reason, for people.
        ``field``: the current sensors' distances."""
        self._controller.reset()
        self._held_since = None
        if self.goal is not None and self._search.turns(now):
            turn = self._turn(self._turn_sign, motion, field, period_s)
            if turn is None and self._search.barred(now):
                self._turn_sign = -self._turn_sign
                turn = self._turn(self._turn_sign, motion, field, period_s)
            if turn is not None:
                self._search.turned(abs(turn) * period_s, now)
                return TrackingStep(0.0, turn, "recovering", "it is lost on the map: turning to find itself")
        return TrackingStep(0.0, 0.0, "waiting", lost)

    def _begin_measure(self, now: float, motion: MotionState, field: DistanceField, period_s: float) -> TrackingStep:
        self._troubled_at = min(self._troubled_at, self._least)
        measure = self.recovery.begin(now)
        self._begin, self._turned = motion, 0.0
        self._turn_sign = 1.0
        if self._track is not None and measure is RecoveryAction.TURN:
            # Toward the path; if the body faces it already, to the left.
            way = self._track.ahead(self._X_OM, 0.5)
            bearing = wrap_angle(float(way.points[-1, 2]) - motion.pose.theta)
            self._turn_sign = math.copysign(1.0, bearing)
        if measure is RecoveryAction.OPEN_UP:
            self.opened_up = True
        return self._recover(now, motion, field, period_s)

    def _recover(self, now: float, motion: MotionState, field: DistanceField, period_s: float) -> TrackingStep:
        measure = self.recovery.current
        assert measure is not None
        linear, angular, barred = 0.0, 0.0, False
        if measure is RecoveryAction.BACK_OFF:
            linear, angular, barred = self._back_off(motion, field, period_s)
        elif measure is RecoveryAction.TURN:
            turn = self._turn(self._turn_sign, motion, field, period_s)
            barred, angular = turn is None, turn or 0.0
            self._turned += abs(motion.angular_radps) * period_s
        driven = math.dist((motion.pose.x, motion.pose.y), (self._begin.pose.x, self._begin.pose.y))
        state = "waiting" if measure in (RecoveryAction.WAIT, RecoveryAction.ASK) else "recovering"
        if self.recovery.over(now, driven_m=driven, turned_rad=self._turned, barred=barred):
            self.recovery.end()
            self._controller.reset()
            self._held_since = None
            return TrackingStep(
                0.0, 0.0, state, measure.value, clear=measure is RecoveryAction.CLEAR, replan=f"after {measure.value}"
            )
        return TrackingStep(linear, angular, state, measure.value)

    def _back_off(self, motion: MotionState, field: DistanceField, period_s: float) -> tuple[float, float, bool]:
        past = self._driven_area.back_from(motion.pose)
        if past is None:
            return 0.0, 0.0, True
        speed = min(self.settings.back_mps, self._body.limits[1])
        linear, angular = back_toward(motion.pose, past, speed, self.settings.turn_radps)
        return linear, angular, not self._free(motion, field, linear, angular, period_s)
