"""A scenario's teleoperation script, driven by an operator's hands: the trial of the thesis's figure 4.8, unattended.

The hands only move the sticks: their commands go the way of every operator's, through Teleop, attention and the guard.
Like an operator who watches the robot they know where it is (the world's truth where it is offered, else odometry) and
see what stands in its way; they let go of the sticks before it, and give up when it stays.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.base import paths
from app.base.errors import ConfigError
from app.base.geometry import Pose2, wrap_angle
from app.messages import GroundTruth, LaserScan, Odometry, OperatorDrive
from app.program.system import System
from app.robots.simulated.link import SimulatedLink
from app.robots.simulated.lockstep import LockstepLink
from app.robots.simulated.scenery.scenario_config import WaypointConfig, load_scenario

Waypoint = WaypointConfig

PERIOD_S = 0.05
PATIENCE_S = 20.0
"""So long something may stand in the way, or the robot not do what the sticks say, before the script is given up."""
REACHED_M, FACED_RAD = 0.08, 0.03
TURN_FIRST_RAD, TURNED_RAD = 0.45, 0.12
LANE_M, STOP_M = 0.34, 0.55
"""Half the width that the robot needs, and how far before its laser it stops."""
SHY_M, SHY_AHEAD_M, SHY_PER_M, SHY_MOST = 0.60, 1.1, 2.0, 0.35
"""It leans away from what is nearer aside than the first, up to the second ahead."""
STALE_S = 0.5
_OPERATOR = "script"


class ScriptBlocked(Exception):
    """The script cannot go on; the message says where and why."""


@dataclass(frozen=True, slots=True)
class Sticks:
    """What the hands do now: ``linear``, ``angular`` in [-1, 1]; ``done`` where the leg is at its end."""

    linear: float = 0.0
    angular: float = 0.0
    turning: bool = False
    done: bool = False


def load_script(scenario: Path | None = None) -> tuple[Waypoint, ...]:
    """The drive of a scenario (default: the thesis's trial). Raises ConfigError where there is none."""
    path = scenario or paths.config_dir() / "scenarios" / "trial.yaml"
    script = load_scenario(path).drive
    if not script:
        raise ConfigError("drive: this scenario drives nobody", str(path))
    return script


def steer(leg: Waypoint, X_WB: Pose2, turning: bool) -> Sticks:
    """How to hold the sticks for ``leg`` with the robot at ``X_WB``; ``turning``: whether it turned on the spot before.

    A leg to a point turns on the spot first if the point lies far aside, then drives, slower near the end.
    """
    if leg.face is not None:
        error = wrap_angle(math.radians(leg.face) - X_WB.theta)
        return Sticks(angular=_turn(error, leg.speed), turning=True, done=abs(error) < FACED_RAD)
    if leg.go is None:
        return Sticks(done=True)
    dx, dy = leg.go[0] - X_WB.x, leg.go[1] - X_WB.y
    distance = math.hypot(dx, dy)
    if distance < REACHED_M:
        return Sticks(done=True)
    error = wrap_angle(math.atan2(dy, dx) - X_WB.theta)
    turning = abs(error) > (TURNED_RAD if turning else TURN_FIRST_RAD)
    if turning:
        return Sticks(angular=_turn(error, leg.speed), turning=True)
    linear = leg.speed * min(1.0, 0.25 + distance / 0.5) * math.cos(error)
    return Sticks(linear=linear, angular=_turn(error, leg.speed))


def in_the_way(scan: LaserScan) -> float | None:
    """How far before the laser (m) the first thing stands that the robot would drive into; None if it is far enough."""
    ahead, aside = _points(scan)
    near = (ahead > 0.02) & (ahead < STOP_M) & (np.abs(aside) < LANE_M)
    return float(ahead[near].min()) if near.any() else None


def lean(scan: LaserScan) -> float:
    """How to turn away (stick, left positive) from what is near aside: what an operator does who sees a wall come."""
    ahead, aside = _points(scan)
    beside = (ahead > 0.02) & (ahead < SHY_AHEAD_M) & (np.abs(aside) < SHY_M)
    left, right = (float((SHY_M - side * aside[beside & (side * aside > 0)]).max(initial=0.0)) for side in (1, -1))
    return max(-SHY_MOST, min(SHY_MOST, SHY_PER_M * (right - left)))


def _points(scan: LaserScan) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How far ahead and aside (m, left positive) of the laser each thing is that a ray has met."""
    met = np.isfinite(scan.ranges)
    angles = (scan.angle_min + scan.angle_increment * np.arange(scan.ranges.size))[met]
    ranges = scan.ranges[met].astype(np.float64)
    return ranges * np.cos(angles), ranges * np.sin(angles)


async def drive_script(
    system: System, waypoints: Sequence[Waypoint], progress: Callable[[int, Waypoint], None] | None = None
) -> None:
    """Drive ``system``'s robot along ``waypoints`` and let go of the sticks, however it ends.

    ``progress(i, leg)`` is told each leg that begins. Raises ScriptBlocked when something stays in the way or the robot
    does not follow for ``PATIENCE_S``, KeyError if the program has no channel ``operator_drive``.
    """
    async with contextlib.AsyncExitStack() as stack:
        hands = _Hands(system, stack)
        await hands.ready()
        for number, leg in enumerate(waypoints):
            if progress is not None:
                progress(number, leg)
            await hands.do(leg)


class _Hands:
    """The operator at the sticks."""

    def __init__(self, system: System, stack: contextlib.AsyncExitStack) -> None:
        self._clock = system.clock
        self._channel = system.graph.channels["operator_drive"]
        self._link = system.link
        self._sequence = 0
        self._pose: tuple[float, Pose2] | None = None
        self._scan: LaserScan | None = None
        streams = self._link.description.streams
        stack.callback(self.let_go)
        if "ground_truth" in streams:
            stack.callback(self._link.attach("ground_truth", self._see_truth))
            self._link.demand("ground_truth", True)
            stack.callback(self._link.demand, "ground_truth", False)
        else:
            stack.callback(self._link.attach("odometry", self._see_odometry))
        self._sees = "hokuyo" in streams
        if self._sees:
            stack.callback(self._link.attach("hokuyo", self._see_scan))
        self._start = self._link.start_pose if isinstance(self._link, SimulatedLink | LockstepLink) else Pose2()

    def _see_truth(self, truth: GroundTruth) -> None:
        self._pose = (truth.stamp, truth.X_WB)

    def _see_odometry(self, odometry: Odometry) -> None:
        self._pose = (odometry.stamp, self._start @ odometry.X_OB)

    def _see_scan(self, scan: LaserScan) -> None:
        self._scan = scan

    async def ready(self) -> None:
        """Wait until it is known where the robot is."""
        until = self._clock.now() + PATIENCE_S
        while self._pose is None:
            if self._clock.now() > until:
                raise ScriptBlocked("The robot does not tell where it is.")
            await self._clock.sleep(PERIOD_S)

    async def do(self, leg: Waypoint) -> None:
        """One leg, to its end."""
        if leg.pause is not None:
            until = self._clock.now() + leg.pause
            while self._clock.now() < until:
                self._push(Sticks())
                await self._clock.sleep(PERIOD_S)
            return
        watch = _Watch(self._clock.now())
        turning = False
        while True:
            now, X_WB = self._clock.now(), self._where()
            sticks = steer(leg, X_WB, turning)
            if sticks.done:
                self._push(Sticks())
                return
            turning = sticks.turning
            blocked = not turning and self._blocked(now)
            watch.look(now, X_WB, blocked, leg)
            if not turning and self._scan is not None:
                sticks = replace(sticks, angular=max(-1.0, min(1.0, sticks.angular + lean(self._scan))))
            self._push(Sticks() if blocked else sticks)
            await self._clock.sleep(PERIOD_S)

    def let_go(self) -> None:
        """Release the dead-man."""
        self._publish(held=False, sticks=Sticks())

    def _where(self) -> Pose2:
        assert self._pose is not None
        return self._pose[1]

    def _blocked(self, now: float) -> bool:
        if not self._sees:
            return False
        if self._scan is None or now - self._scan.stamp > STALE_S:
            # Others may have said that nobody wants it; without it the hands do not drive ahead.
            self._link.demand("hokuyo", True)
            return True
        return in_the_way(self._scan) is not None

    def _push(self, sticks: Sticks) -> None:
        self._publish(held=True, sticks=sticks)

    def _publish(self, *, held: bool, sticks: Sticks) -> None:
        self._sequence += 1
        now = self._clock.now()
        self._channel.publish(
            OperatorDrive(
                now, _OPERATOR, sequence=self._sequence, held=held, linear=sticks.linear, angular=sticks.angular
            )
        )


class _Watch:
    """Whether a leg makes progress."""

    def __init__(self, now: float) -> None:
        self._moved = now
        self._last: Pose2 | None = None
        self._blocked = False

    def look(self, now: float, X_WB: Pose2, blocked: bool, leg: Waypoint) -> None:
        """Note where the robot is; raises ScriptBlocked where it has not moved for too long."""
        last = self._last
        moved = last is None or math.dist((last.x, last.y), (X_WB.x, X_WB.y)) > 0.05
        if moved or (last is not None and abs(wrap_angle(last.theta - X_WB.theta)) > 0.05):
            self._last, self._moved = X_WB, now
        if now - self._moved > PATIENCE_S:
            why = "Something stands in the robot's way" if blocked else "The robot does not do what the sticks say"
            where = f"at ({X_WB.x:.1f}, {X_WB.y:.1f})"
            what = f" on its way to {leg.label or leg.go}" if leg.go is not None else ""
            raise ScriptBlocked(f"{why} {where}{what}, for {PATIENCE_S:.0f} s.")


def _turn(error: float, speed: float) -> float:
    return max(-speed, min(speed, 2.0 * error + math.copysign(0.02, error)))
