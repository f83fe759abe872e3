"""Simulated operator: drives a scenario's teleoperation script, as in the trial of the thesis's figure 4.8, unattended.
It publishes stick commands like any operator, through Teleop, attention and the guard. Like an operator who watches the
robot it uses the robot's true pose (else odometry) and the scan; it releases the sticks before an obstacle, and gives
up if the obstacle stays.
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
from app.messages import GroundTruth, LaserScan, Odometry, TeleopCommand
from app.program.system import System
from app.robots.simulated.link import SimulatedLink
from app.robots.simulated.lockstep import LockstepLink
from app.robots.simulated.scenery.scenario_config import WaypointConfig, load_scenario

Waypoint = WaypointConfig

PERIOD_S = 0.05
PATIENCE_S = 20.0
"""Time (s) of an obstacle in the way, or without motion, after which the script is given up."""
REACHED_M, FACED_RAD = 0.08, 0.03
TURN_FIRST_RAD, TURNED_RAD = 0.45, 0.12
LANE_M, STOP_M = 0.34, 0.55
"""Half the width of the checked corridor, and stopping distance before the laser (m)."""
SHY_M, SHY_AHEAD_M, SHY_PER_M, SHY_MOST = 0.60, 1.1, 2.0, 0.35
"""Evasion: lateral distance (m) of an object to steer away from, and greatest distance ahead (m)."""
STALE_S = 0.5
_OPERATOR = "script"


class ScriptBlocked(Exception):
    """The script cannot go on; the message says where and why."""


@dataclass(frozen=True, slots=True)
class StickCommand:
    """Stick position: ``linear``, ``angular`` in [-1, 1]; ``done`` at the end of the leg."""

    linear: float = 0.0
    angular: float = 0.0
    turning: bool = False
    done: bool = False


def load_script(scenario: Path | None = None) -> tuple[Waypoint, ...]:
    """The drive of a scenario (default: the thesis's trial). Raises ConfigError for a scenario without one."""
    path = scenario or paths.config_dir() / "scenarios" / "trial.yaml"
    script = load_scenario(path).drive
    if not script:
        raise ConfigError("drive: this scenario has no drive", str(path))
    return script


def steer(leg: Waypoint, X_WB: Pose2, turning: bool) -> StickCommand:
    """Stick position for ``leg`` with the robot at ``X_WB``; ``turning``: whether it turned on the spot before.

    A leg to a point starts with a turn on the spot if the point is far aside, then drives, slower near the end.
    """
    if leg.face is not None:
        error = wrap_angle(math.radians(leg.face) - X_WB.theta)
        return StickCommand(angular=_turn(error, leg.speed), turning=True, done=abs(error) < FACED_RAD)
    if leg.go is None:
        return StickCommand(done=True)
    dx, dy = leg.go[0] - X_WB.x, leg.go[1] - X_WB.y
    distance = math.hypot(dx, dy)
    if distance < REACHED_M:
        return StickCommand(done=True)
    error = wrap_angle(math.atan2(dy, dx) - X_WB.theta)
    turning = abs(error) > (TURNED_RAD if turning else TURN_FIRST_RAD)
    if turning:
        return StickCommand(angular=_turn(error, leg.speed), turning=True)
    linear = leg.speed * min(1.0, 0.25 + distance / 0.5) * math.cos(error)
    return StickCommand(linear=linear, angular=_turn(error, leg.speed))


def in_the_way(scan: LaserScan) -> float | None:
    """Distance (m) before the laser of the first object in the robot's corridor; None if it is far enough."""
    ahead, aside = _points(scan)
    near = (ahead > 0.02) & (ahead < STOP_M) & (np.abs(aside) < LANE_M)
    return float(ahead[near].min()) if near.any() else None


def lean(scan: LaserScan) -> float:
    """Stick deflection (left positive) away from a near object aside."""
    ahead, aside = _points(scan)
    beside = (ahead > 0.02) & (ahead < SHY_AHEAD_M) & (np.abs(aside) < SHY_M)
    left, right = (float((SHY_M - side * aside[beside & (side * aside > 0)]).max(initial=0.0)) for side in (1, -1))
    return max(-SHY_MOST, min(SHY_MOST, SHY_PER_M * (right - left)))


def _points(scan: LaserScan) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Position ahead and aside (m, left positive) of the laser of each return."""
    met = np.isfinite(scan.ranges)
    angles = (scan.angle_min + scan.angle_increment * np.arange(scan.ranges.size))[met]
    ranges = scan.ranges[met].astype(np.float64)
    return ranges * np.cos(angles), ranges * np.sin(angles)


async def drive_script(
    system: System, waypoints: Sequence[Waypoint], progress: Callable[[int, Waypoint], None] | None = None
) -> None:
    """Drive ``system``'s robot along ``waypoints``; the sticks are released in any case. ``progress(i, leg)`` is called
    at the begin of each leg. Raises ScriptBlocked when an obstacle stays in the way or the robot does not move for
    ``PATIENCE_S``, KeyError if the program has no channel ``teleop_command``.
    """
    async with contextlib.AsyncExitStack() as stack:
        operator = _ScriptOperator(system, stack)
        await operator.ready()
        for number, leg in enumerate(waypoints):
            if progress is not None:
                progress(number, leg)
            await operator.do(leg)


class _ScriptOperator:
    """The simulated operator."""

    def __init__(self, system: System, stack: contextlib.AsyncExitStack) -> None:
        self._clock = system.clock
        self._channel = system.graph.channels["teleop_command"]
        self._link = system.link
        self._sequence = 0
        self._pose: tuple[float, Pose2] | None = None
        self._scan: LaserScan | None = None
        streams = self._link.description.streams
        stack.callback(self.let_go)
        if "ground_truth" in streams:
            stack.callback(self._link.attach("ground_truth", self._see_truth))
            self._link.demand("ground_truth", math.inf)
            stack.callback(self._link.demand, "ground_truth", False)
        else:
            stack.callback(self._link.attach("odometry", self._see_odometry))
        self._truth_scan = "hokuyo" in streams
        if self._truth_scan:
            stack.callback(self._link.attach("hokuyo", self._see_scan))
        self._start = self._link.start_pose if isinstance(self._link, SimulatedLink | LockstepLink) else Pose2()

    def _see_truth(self, truth: GroundTruth) -> None:
        self._pose = (truth.stamp, truth.X_WB)

    def _see_odometry(self, odometry: Odometry) -> None:
        self._pose = (odometry.stamp, self._start @ odometry.X_OB)

    def _see_scan(self, scan: LaserScan) -> None:
        self._scan = scan

    async def ready(self) -> None:
        """Wait for the first pose of the robot."""
        until = self._clock.now() + PATIENCE_S
        while self._pose is None:
            if self._clock.now() > until:
                raise ScriptBlocked("The robot's pose is unknown.")
            await self._clock.sleep(PERIOD_S)

    async def do(self, leg: Waypoint) -> None:
        """Drive one leg to its end."""
        if leg.pause is not None:
            until = self._clock.now() + leg.pause
            while self._clock.now() < until:
                self._push(StickCommand())
                await self._clock.sleep(PERIOD_S)
            return
        watch = _LegProgress(self._clock.now())
        turning = False
        while True:
            now, X_WB = self._clock.now(), self._where()
            sticks = steer(leg, X_WB, turning)
            if sticks.done:
                self._push(StickCommand())
                return
            turning = sticks.turning
            blocked = not turning and self._blocked(now)
            watch.look(now, X_WB, blocked, leg)
            if not turning and self._scan is not None:
                sticks = replace(sticks, angular=max(-1.0, min(1.0, sticks.angular + lean(self._scan))))
            self._push(StickCommand() if blocked else sticks)
            await self._clock.sleep(PERIOD_S)

    def let_go(self) -> None:
        """Release the dead-man."""
        self._publish(held=False, sticks=StickCommand())

    def _where(self) -> Pose2:
        assert self._pose is not None
        return self._pose[1]

    def _blocked(self, now: float) -> bool:
        if not self._truth_scan:
            return False
        if self._scan is None or now - self._scan.stamp > STALE_S:
            # The desire may have been removed by others; without it Teleop does not drive.
            self._link.demand("hokuyo", math.inf)
            return True
        return in_the_way(self._scan) is not None

    def _push(self, sticks: StickCommand) -> None:
        self._publish(held=True, sticks=sticks)

    def _publish(self, *, held: bool, sticks: StickCommand) -> None:
        self._sequence += 1
        now = self._clock.now()
        self._channel.publish(
            TeleopCommand(
                now, _OPERATOR, sequence=self._sequence, held=held, linear=sticks.linear, angular=sticks.angular
            )
        )


class _LegProgress:
    """Progress of one leg."""

    def __init__(self, now: float) -> None:
        self._moved = now
        self._last: Pose2 | None = None
        self._blocked = False

    def look(self, now: float, X_WB: Pose2, blocked: bool, leg: Waypoint) -> None:
        """Note the robot's pose; raises ScriptBlocked if it has not moved for too long."""
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
