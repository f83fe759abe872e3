"""Context of the collision monitor: newest scan, odometry since, joints, operator's override, a dock; it limits a
command by them.

Pure on values and times: no event loop and no clock of its own.
"""

from __future__ import annotations

import cmath
from collections.abc import Mapping
from dataclasses import replace

from app.base.geometry import Pose2
from app.base.moving_shapes import BodyOutline
from app.base.pose_buffer import PoseBuffer
from app.link import BaseLimits
from app.messages import DockSighting, JointState, LaserScan, Odometry, TeleopCommand, Twist
from app.modules.actuation.arbitration import approach
from app.modules.actuation.collision_monitor import CollisionMonitor, SeenPoints, Verdict
from app.modules.actuation.dock_exemption import FRESH_S, LONGEST_PLATE_M, without_dock

#: Greatest age (s) of odometry that is extrapolated to now by its own twist.
_CARRIED_S = 0.1


class CollisionContext:
    """Holds the newest scan, the odometry since, the joints, and the operator's hold; limits commands by them."""

    def __init__(
        self, monitor: CollisionMonitor, limits: BaseLimits, hold_s: float, outline: BodyOutline | None = None
    ) -> None:
        """``hold_s``: greatest age of an operator's command that still counts as a hold (s). ``outline``: of a body
        with joints that may reach beyond its footprint, which :meth:`posed` brings: it counts with them as they are,
        and with its widest outline while they are not known."""
        self._monitor = monitor
        self._outline = outline
        self._joints: JointState | None = None
        #: The joints that the monitor's outline is of; None: the widest.
        self._fitted: Mapping[str, float] | None = {}
        self._limits = limits
        self._hold_s = hold_s
        self._scan: LaserScan | None = None
        self._seen: SeenPoints | None = None
        self._odometry: Odometry | None = None
        self._poses = PoseBuffer(span_s=2.0)
        self._operator: TeleopCommand | None = None
        self._dock: DockSighting | None = None

    def scanned(self, scan: LaserScan) -> None:
        self._scan, self._seen = scan, None

    def moved(self, odometry: Odometry) -> None:
        self._odometry = odometry
        self._poses.add(odometry.stamp, odometry.X_OB)

    def posed(self, joints: JointState) -> None:
        """Take the joints' newest positions."""
        self._joints = joints

    def commanded(self, drive: TeleopCommand) -> None:
        """Take the operator's newest command."""
        self._operator = drive

    def sighted(self, dock: DockSighting) -> None:
        """Take the newest sighting of a dock that the robot drives into."""
        self._dock = dock

    def overridden(self, now: float) -> bool:
        """Whether an operator holds the override now."""
        drive = self._operator
        return drive is not None and drive.held and drive.override and abs(now - drive.stamp) <= self._hold_s

    def limit(
        self, before: Twist, target: Twist, longest_s: float, *, by_hand: bool, docking: bool = False
    ) -> tuple[Twist, str]:
        """The twist to give to the wheels at the stamp of ``target``, and the reason where it is less than ``target``
        (else "").

        ``before``: the twist given last; the result approaches ``target`` with the body's accelerations, but a
        reduction by the monitor applies at once. ``by_hand``: an operator drives and may use the override.
        ``docking``: the docking behavior drives: at a crawl, the dock that it has just seen does not limit it.
        """
        now = target.stamp
        dock = self._exempt(now) if docking else None
        if dock is not None:
            # Faster motion from before ends at once, as where the monitor reduces it.
            before, target = self._crawling(before), self._crawling(target)
        if by_hand and self.overridden(now):
            return self._towards(
                before, target, self._monitor.crawl(_velocity(target), target.angular_radps), longest_s
            )
        standing = _stands(before)
        allowed = self._judge(now, target, standing, dock)
        twist, reason = self._towards(before, target, allowed, longest_s)
        if not _is_part(twist, allowed):
            # While the body accelerates or brakes, its arc differs from the arc of the target.
            now_allowed = self._judge(now, twist, standing=False, dock=dock)
            if now_allowed.reason:
                return _twist(now, now_allowed), now_allowed.reason
        return twist, reason

    def _towards(self, before: Twist, target: Twist, allowed: Verdict, longest_s: float) -> tuple[Twist, str]:
        twist = approach(before, _twist(target.stamp, allowed), self._limits, longest_s)
        if allowed.reason:
            twist = Twist(
                target.stamp,
                _no_faster(twist.linear_mps, allowed.linear),
                _no_faster(twist.angular_radps, allowed.angular),
                lateral_mps=_no_faster(twist.lateral_mps, allowed.lateral),
            )
        return twist, allowed.reason

    def _crawling(self, twist: Twist) -> Twist:
        allowed = self._monitor.crawl(_velocity(twist), twist.angular_radps)
        return _twist(twist.stamp, allowed)

    def _exempt(self, now: float) -> DockSighting | None:
        """The dock that does not limit the docking behavior now; None where it was not seen just before."""
        dock = self._dock
        # Written so that a NaN is neither fresh nor short.
        if dock is None or not abs(now - dock.stamp) <= FRESH_S or not 0 < dock.plate_m <= LONGEST_PLATE_M:
            return None
        return dock

    def _judge(self, now: float, twist: Twist, standing: bool, dock: DockSighting | None) -> Verdict:
        scan, monitor = self._scan, self._monitor
        if _stands(twist):
            return Verdict(0.0, 0.0)
        # Written so that a NaN stamp is not fresh.
        if scan is None or not abs(now - scan.stamp) <= monitor.rules.stale_s:
            return monitor.blind(None if scan is None else now - scan.stamp)
        self._fit(now)
        if self._seen is None:
            self._seen = monitor.see(scan)
        seen, moved = self._seen, self._motion(self._seen.stamp, now)
        X_OS = None if dock is None else self._poses.at(seen.stamp)
        if dock is not None and X_OS is not None:
            seen = replace(seen, points=without_dock(seen.points, dock, X_OS))
        return monitor.judge(seen, moved, _velocity(twist), twist.angular_radps, standing=standing)

    def _fit(self, now: float) -> None:
        """Give the monitor the outline of the body as its joints are now."""
        outline, joints = self._outline, self._joints
        if outline is None:
            return
        # Written so that a NaN stamp is not fresh.
        if joints is None or not abs(now - joints.stamp) <= self._monitor.rules.stale_s:
            if self._fitted is not None:
                self._fitted, self._seen = None, None
                self._monitor.outline(outline.widest)
            return
        positions = dict(zip(joints.names, joints.positions, strict=True))
        if self._fitted is None or outline.changed(self._fitted, positions):
            self._fitted, self._seen = positions, None
            self._monitor.outline(outline.at(positions))

    def _motion(self, then: float, now: float) -> Pose2:
        """``X_SB``: motion of the base since ``then`` by odometry; None without odometry."""
        odometry, X_OS = self._odometry, self._poses.at(then)
        if odometry is None or X_OS is None:
            return Pose2()
        since_s = min(max(now - odometry.stamp, 0.0), _CARRIED_S)
        turn = odometry.angular_radps * since_s
        chord = complex(odometry.linear_mps, odometry.lateral_mps) * since_s * cmath.rect(1.0, turn / 2)
        return X_OS.inverse() @ odometry.X_OB @ Pose2(chord.real, chord.imag, turn)


def _velocity(twist: Twist) -> complex:
    return complex(twist.linear_mps, twist.lateral_mps)


def _twist(stamp: float, allowed: Verdict) -> Twist:
    return Twist(stamp, allowed.linear, allowed.angular, allowed.lateral)


def _stands(twist: Twist) -> bool:
    return twist.angular_radps == 0.0 and _velocity(twist) == 0.0


def _is_part(twist: Twist, allowed: Verdict) -> bool:
    """Whether ``twist`` is the allowed twist, or the same arc at a lower speed."""
    linear, angular, lateral = twist.linear_mps, twist.angular_radps, twist.lateral_mps
    return (
        linear * allowed.angular == angular * allowed.linear
        and linear * allowed.lateral == lateral * allowed.linear
        and lateral * allowed.angular == angular * allowed.lateral
        and _no_faster(linear, allowed.linear) == linear
        and _no_faster(angular, allowed.angular) == angular
        and _no_faster(lateral, allowed.lateral) == lateral
    )


def _no_faster(value: float, most: float) -> float:
    """``value`` with magnitude at most that of ``most``, and zero where the signs differ."""
    if most >= 0:
        return min(max(value, 0.0), most)
    return max(min(value, 0.0), most)
