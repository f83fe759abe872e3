"""What MobileBaseControl knows of the robot's surroundings and of the operator's hold, and what follows for a command.

Values and times in, a twist out: it has no loop and no clock of its own.
"""

from __future__ import annotations

import math

from app.base.geometry import Pose2
from app.base.pose_buffer import PoseBuffer
from app.link import BaseLimits
from app.messages import LaserScan, Odometry, OperatorDrive, Twist
from app.modules.actuation.arbitration import approach
from app.modules.actuation.collision_monitor import CollisionMonitor, SeenPoints, Verdict

#: Odometry that is older (s) than this is not carried on to now by its own speed.
_CARRIED_S = 0.1


class CollisionContext:
    """Holds the newest scan, the odometry since, and the operator's hold; limits commands by them."""

    def __init__(self, monitor: CollisionMonitor, limits: BaseLimits, hold_s: float) -> None:
        """``hold_s``: an operator's command that is older is no hold any more."""
        self._monitor = monitor
        self._limits = limits
        self._hold_s = hold_s
        self._scan: LaserScan | None = None
        self._seen: SeenPoints | None = None
        self._odometry: Odometry | None = None
        self._poses = PoseBuffer(span_s=2.0)
        self._operator: OperatorDrive | None = None

    def scanned(self, scan: LaserScan) -> None:
        """Take the newest scan."""
        self._scan, self._seen = scan, None

    def moved(self, odometry: Odometry) -> None:
        """Take the newest odometry."""
        self._odometry = odometry
        self._poses.add(odometry.stamp, odometry.X_OB)

    def commanded(self, drive: OperatorDrive) -> None:
        """Take what an operator's hands say."""
        self._operator = drive

    def overridden(self, now: float) -> bool:
        """Whether an operator holds the override now."""
        drive = self._operator
        return drive is not None and drive.held and drive.override and abs(now - drive.stamp) <= self._hold_s

    def limit(self, before: Twist, target: Twist, longest_s: float, *, by_hand: bool) -> tuple[Twist, str]:
        """What may be given to the wheels at the stamp of ``target``, and why it is less than that ("": it is not).

        ``before`` is what they were given last; ``target`` is approached with the body's accelerations, but what must
        be slower is slower at once. ``by_hand``: an operator drives, and may override.
        """
        now = target.stamp
        if by_hand and self.overridden(now):
            return self._towards(
                before, target, self._monitor.crawl(target.linear_mps, target.angular_radps), longest_s
            )
        stands = before.linear_mps == 0.0 and before.angular_radps == 0.0
        allowed = self._judge(now, target, stands)
        twist, reason = self._towards(before, target, allowed, longest_s)
        if not _is_part(twist, allowed):
            # While it speeds up or brakes, the body drives otherwise than it is to in the end.
            now_allowed = self._judge(now, twist, stands=False)
            if now_allowed.reason:
                return Twist(now, now_allowed.linear, now_allowed.angular), now_allowed.reason
        return twist, reason

    def _towards(self, before: Twist, target: Twist, allowed: Verdict, longest_s: float) -> tuple[Twist, str]:
        wanted = Twist(target.stamp, allowed.linear, allowed.angular)
        twist = approach(before, wanted, self._limits, longest_s)
        if allowed.reason:
            twist = Twist(
                target.stamp,
                _no_faster(twist.linear_mps, allowed.linear),
                _no_faster(twist.angular_radps, allowed.angular),
            )
        return twist, allowed.reason

    def _judge(self, now: float, twist: Twist, stands: bool) -> Verdict:
        scan, monitor = self._scan, self._monitor
        if twist.linear_mps == 0.0 and twist.angular_radps == 0.0:
            return Verdict(0.0, 0.0)
        # As it stands, a stamp that is not a number is no fresh one.
        if scan is None or not abs(now - scan.stamp) <= monitor.rules.stale_s:
            return monitor.blind(None if scan is None else now - scan.stamp)
        if self._seen is None:
            self._seen = monitor.see(scan)
        moved = self._motion(self._seen.stamp, now)
        return monitor.judge(self._seen, moved, twist.linear_mps, twist.angular_radps, stands=stands)

    def _motion(self, then: float, now: float) -> Pose2:
        """``X_SB``: how the base has moved since ``then``, as far as odometry tells."""
        odometry, X_OS = self._odometry, self._poses.at(then)
        if odometry is None or X_OS is None:
            return Pose2()
        since_s = min(max(now - odometry.stamp, 0.0), _CARRIED_S)
        turn = odometry.angular_radps * since_s
        ahead = odometry.linear_mps * since_s
        step = Pose2(ahead * math.cos(turn / 2), ahead * math.sin(turn / 2), turn)
        return X_OS.inverse() @ odometry.X_OB @ step


def _is_part(twist: Twist, allowed: Verdict) -> bool:
    """Whether ``twist`` is what is allowed, or the same arc driven more slowly."""
    linear, angular = twist.linear_mps, twist.angular_radps
    return (
        linear * allowed.angular == angular * allowed.linear
        and _no_faster(linear, allowed.linear) == linear
        and _no_faster(angular, allowed.angular) == angular
    )


def _no_faster(value: float, most: float) -> float:
    """``value``, no faster than ``most`` and not against it."""
    if most >= 0:
        return min(max(value, 0.0), most)
    return max(min(value, 0.0), most)
