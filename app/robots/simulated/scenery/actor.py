"""One person playing a script: position and walk, gaze, limbs, claps.

Plain kinematics with limited speeds and turns; people do not walk through the robot; everything is determined by the
script, the time and the robot's pose.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from app.base.geometry import Pose2, wrap_angle
from app.messages import PersonTruth
from app.robots.simulated.scenery import gait
from app.robots.simulated.scenery.following import Follower, FollowHabit
from app.robots.simulated.scenery.gait import Posture
from app.robots.simulated.scenery.scenario_config import Look, PersonConfig, StepConfig

ROBOT_FACE_M = 1.30
ACCELERATION_MPS2 = 1.5
TURN_RADPS, HEAD_RADPS = math.radians(110), math.radians(140)
HEAD_YAW, HEAD_PITCH = math.radians(65), math.radians(20)
CLAP_RAISE_S = 0.35
REACHED_M = 0.004
BACK_M, BACK_S = 1.0, 5.0
"""Giving way to the robot: distance (m) back along the path, and time (s) before the next try."""
ALMOST_THERE_M = 0.4
"""Least distance (m) to the begin of a walk for giving way in that direction."""


@dataclass(frozen=True, slots=True)
class ActorSound:
    """A sound that a person starts to make: ``kind`` and ``clip`` as in ``Cue``."""

    kind: str
    clip: str
    gain_db: float
    begin_s: float


class Actor:
    """A person; :meth:`tick` advances by a time step. ``x``, ``y`` (m), ``heading`` (rad) of the body in the world."""

    def __init__(self, config: PersonConfig, height_m: float, habit: FollowHabit | None = None) -> None:
        self.config = config
        self._habit = habit or FollowHabit()
        self._follower: Follower | None = None
        self.name = config.name
        self.height_m = height_m
        self.x, self.y = config.at
        self.heading = math.radians(config.heading_deg)
        self.speed = 0.0
        self._step = 0
        self._since: float | None = None
        self._done = not config.script
        self._gait = 0.0
        self._stride = 0.0
        self._head_yaw = 0.0
        self._head_pitch = 0.0
        self._turning = False
        self._claps: list[float] = []
        self._now = 0.0
        self.waiting_for_robot = False
        self._came = (config.at, config.at)
        self._waited_s = 0.0
        self._back: tuple[float, float] | None = None
        self._back_until = 0.0
        self._going: tuple[float, float] = config.at

    @property
    def posture(self) -> Posture:
        raised, apart = self._clapping()
        return Posture(
            self._gait, self._stride, clap=raised, apart=apart, head_yaw=self._head_yaw, head_pitch=self._head_pitch
        )

    @property
    def gaze(self) -> float:
        """Direction (rad) of the face, in the world."""
        return wrap_angle(self.heading + self._head_yaw)

    @property
    def mouth(self) -> tuple[float, float, float]:
        """Position of the mouth in the world (m)."""
        ahead, up = (self.height_m * share for share in gait.mouth(self.posture))
        return (self.x + ahead * math.cos(self.gaze), self.y + ahead * math.sin(self.gaze), up)

    @property
    def hands(self) -> tuple[float, float, float]:
        """Meeting point of the palms when clapping (m, world)."""
        ahead = gait.HANDS_AHEAD * self.height_m
        return (
            self.x + ahead * math.cos(self.heading),
            self.y + ahead * math.sin(self.heading),
            gait.HANDS_SHARE * self.height_m,
        )

    @property
    def truth(self) -> PersonTruth:
        return PersonTruth(self.name, self.x, y=self.y, heading=self.gaze, height_m=self.height_m, mouth=self.mouth)

    def clap_at(self, time_s: float) -> None:
        """Schedule a clap at ``time_s``, which should leave time to raise the arms."""
        self._claps.append(time_s)

    def let_pass(self) -> None:
        """The robot asks to be let pass; who follows it does."""
        if self._follower is not None:
            self._follower.let_pass(self._now)

    def tick(self, dt: float, now: float, X_WB: Pose2, before: Sequence[Actor]) -> list[ActorSound]:
        """Advance by ``dt`` to ``now``; ``before``: people with right of way. Returns sounds that start."""
        self._now = now
        self._claps = [time for time in self._claps if now - time < 2 * CLAP_RAISE_S]
        happenings: list[ActorSound] = []
        look: Look = "ahead"
        wanted_speed = 0.0
        if self._follower is not None:  # who pauses goes on along the way, too, and through no wall
            self._follower.see(now, X_WB)
        for _ in range(len(self.config.script) + 1):  # steps that take no time are done in one tick
            if self._done:
                look = self.config.script[-1].look if self.config.script else "ahead"
                break
            step = self.config.script[self._step]
            if self._since is None:
                self._since = now
                if math.dist(self._came[-1], (self.x, self.y)) > ALMOST_THERE_M:
                    self._came = (self._came[-1], (self.x, self.y))
                self._back = None
                happenings += self._begin(step, now)
            look = step.look
            if not self._finished(step, now, X_WB):
                if step.walk is not None:
                    self._going = self._place_to_go(step.walk, dt, now)
                    wanted_speed = self._steer(self._going, step.speed, dt, X_WB, before)
                if self._follower is not None and step.follow is not None:
                    goal = self._follower.goal(now, (self.x, self.y), X_WB)
                    if goal is not None:
                        self._going = goal
                        wanted_speed = self._steer(self._going, step.speed, dt, X_WB, before)
                break
            self._next()
        change = ACCELERATION_MPS2 * dt
        braking = 3 * change  # people stop faster than they start
        self.speed += min(max(wanted_speed - self.speed, -braking), change)
        if self.speed > 0 and not self._done and self._moves(self.config.script[self._step]):
            happenings += self._walk(self._going, dt, now)
        else:
            self.speed = 0.0
        self._stride += min(max(min(1.0, self.speed / 1.3) - self._stride, -3 * dt), 3 * dt)
        self._look(look, dt, X_WB)
        return happenings

    @staticmethod
    def _moves(step: StepConfig) -> bool:
        return step.walk is not None or step.follow is not None

    def _begin(self, step: StepConfig, now: float) -> list[ActorSound]:
        if step.follow is not None:
            distance_m = self._habit.distance_m if step.distance is None else step.distance
            habit = FollowHabit(distance_m, self._habit.lag_s if step.lag is None else step.lag)
            if self._follower is None:
                self._follower = Follower(habit)
            self._follower.habit = habit
        if step.say is not None:
            return [ActorSound("speech", step.say, step.gain_db, now)]
        if step.clap is not None:
            times = [now + CLAP_RAISE_S + number * step.every for number in range(step.clap)]
            self._claps += times
            return [ActorSound("clap", "clap", step.gain_db, time) for time in times]
        return []

    def _finished(self, step: StepConfig, now: float, X_WB: Pose2) -> bool:
        assert self._since is not None
        if step.walk is not None:
            return math.dist(step.walk, (self.x, self.y)) < REACHED_M
        if step.wait is not None:
            return now - self._since >= step.wait
        if step.follow is not None:
            return now - self._since >= step.follow
        if step.wait_for_robot is not None:
            near = math.dist(step.wait_for_robot, (X_WB.x, X_WB.y)) <= step.within
            return near or now - self._since >= step.at_most
        if step.clap is not None:
            return now - self._since >= 2 * CLAP_RAISE_S + (step.clap - 1) * step.every
        return True

    def _next(self) -> None:
        self._since = None
        self._step += 1
        if self._step == len(self.config.script):
            self._step = 0
            self._done = not self.config.repeat

    def _place_to_go(self, walk: tuple[float, float], dt: float, now: float) -> tuple[float, float]:
        """The step's point ``walk``, or a place back along the path when giving way to the robot."""
        if self._back is not None and now < self._back_until:
            return self._back
        self._back = None
        self._waited_s = self._waited_s + dt if self.waiting_for_robot else 0.0
        patience = self.config.gives_way_s
        if patience is None or self._waited_s < patience:
            return walk
        before, last = self._came  # from the last turn, or, just round that, from the one before
        came = last if math.dist(last, (self.x, self.y)) > ALMOST_THERE_M else before
        way = math.dist(came, (self.x, self.y))
        if way < ALMOST_THERE_M:
            return walk
        share = min(1.0, BACK_M / way)
        self._back = (self.x + share * (came[0] - self.x), self.y + share * (came[1] - self.y))
        self._back_until, self._waited_s = now + BACK_S, 0.0
        return self._back

    def _steer(
        self, place: tuple[float, float], speed: float, dt: float, X_WB: Pose2, before: Sequence[Actor]
    ) -> float:
        """Turn towards ``place``; return the current walking speed, ``speed`` at most."""
        dx, dy = place[0] - self.x, place[1] - self.y
        left = math.hypot(dx, dy)
        direction = math.atan2(dy, dx)
        error = wrap_angle(direction - self.heading)
        turn = TURN_RADPS * dt
        self.heading = wrap_angle(self.heading + min(max(error, -turn), turn))
        self.waiting_for_robot = self._in_the_way(direction, (X_WB.x, X_WB.y), ahead=1.15, aside=0.62)
        if self.waiting_for_robot or abs(error) > math.radians(50):
            return 0.0
        if any(self._in_the_way(direction, (other.x, other.y), ahead=0.9, aside=0.45) for other in before):
            return 0.0
        return min(speed, math.sqrt(2 * ACCELERATION_MPS2 * left) + 0.02)

    def _in_the_way(self, direction: float, other: tuple[float, float], ahead: float, aside: float) -> bool:
        dx, dy = other[0] - self.x, other[1] - self.y
        along = dx * math.cos(direction) + dy * math.sin(direction)
        across = dy * math.cos(direction) - dx * math.sin(direction)
        return 0.0 < along < ahead and abs(across) < aside

    def _walk(self, target: tuple[float, float], dt: float, now: float) -> list[ActorSound]:
        left = math.dist(target, (self.x, self.y))
        if left < 1e-9:
            return []
        way = min(self.speed * dt, left)
        self.x += way * (target[0] - self.x) / left
        self.y += way * (target[1] - self.y) / left
        step_m = gait.STEP * self.height_m * (0.4 + 0.6 * min(1.0, self.speed / 1.3))
        before = math.floor(self._gait / math.pi)
        self._gait += math.pi * way / step_m
        return [ActorSound("steps", "", 0.0, now)] if math.floor(self._gait / math.pi) > before else []

    def _look(self, look: Look, dt: float, X_WB: Pose2) -> None:
        yaw = pitch = 0.0
        if look != "ahead":
            at = X_WB @ Pose2(0.05, 0.0, 0.0) if look == "robot" else Pose2(*look, 0.0)
            dx, dy = at.x - self.x, at.y - self.y
            whole = wrap_angle(math.atan2(dy, dx) - self.heading)
            if self.speed == 0.0:
                whole = self._turn_body(whole, dt)
            yaw = min(max(whole, -HEAD_YAW), HEAD_YAW) if abs(whole) < math.radians(120) else 0.0
            if look == "robot" and yaw:
                rise = ROBOT_FACE_M - 0.93 * self.height_m
                pitch = min(max(math.atan2(rise, math.hypot(dx, dy)), -HEAD_PITCH), HEAD_PITCH)
        turn = HEAD_RADPS * dt
        self._head_yaw += min(max(yaw - self._head_yaw, -turn), turn)
        self._head_pitch += min(max(pitch - self._head_pitch, -turn / 2), turn / 2)

    def _turn_body(self, error: float, dt: float) -> float:
        """Turn the body where the neck alone would turn too far; return the remaining angle."""
        if abs(error) > math.radians(35):
            self._turning = True
        elif abs(error) < math.radians(5):
            self._turning = False
        if not self._turning:
            return error
        turn = 0.6 * TURN_RADPS * dt
        by = min(max(error, -turn), turn)
        self.heading = wrap_angle(self.heading + by)
        return wrap_angle(error - by)

    def _clapping(self) -> tuple[float, float]:
        """How far the arms are raised, and how far the palms are apart."""
        if not self._claps:
            return 0.0, 1.0
        until, since = self._claps[0] - self._now, self._now - self._claps[-1]
        raised = 1.0 - max(0.0, until, since) / CLAP_RAISE_S
        nearest = min(abs(self._now - time) for time in self._claps)
        return min(max(raised, 0.0), 1.0), min(1.0, nearest / 0.15)
