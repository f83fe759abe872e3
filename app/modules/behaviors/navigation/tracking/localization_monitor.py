"""Checks of odometry and localization before driving by them."""

from __future__ import annotations

import math

from app.base.geometry import Pose2
from app.base.pose_buffer import PoseBuffer
from app.messages import Localization, Odometry
from app.modules.behaviors.navigation.controller import MotionState

#: Greatest age of odometry, s.
_ODOMETRY_S = 0.3
#: Greatest age of a localization: this (s), plus this many of its own periods, since attention chooses its rate.
_LOCALIZATION_S = 1.0
_PERIODS = 1.5
_LONGEST_S = 5.0
_NO_ODOMETRY = "there is no odometry: the wheels' encoders give nothing"


class LocalizationMonitor:
    """Keeps the newest poses; :meth:`problem` tests them."""

    def __init__(self) -> None:
        self._buffer = PoseBuffer(span_s=5.0, tolerance_s=0.015)
        self._odometry: Odometry | None = None
        self.localization: Localization | None = None
        self._period_s = 0.0

    def add_odometry(self, odometry: Odometry) -> None:
        """Take an odometry message."""
        if math.isfinite(odometry.stamp):
            self._buffer.add(odometry.stamp, odometry.X_OB)
        self._odometry = odometry

    def add_localization(self, localization: Localization) -> None:
        """Take a localization message."""
        before = self.localization
        if before is not None:
            period_s = localization.stamp - before.stamp
            self._period_s = min(max(period_s, 0.0), _LONGEST_S) if math.isfinite(period_s) else 0.0
        self.localization = localization

    def at(self, stamp: float) -> Pose2 | None:
        """``X_OB`` at ``stamp``; None before odometry reaches it."""
        return self._buffer.at(stamp)

    @property
    def X_MO(self) -> Pose2 | None:
        """Pose of ``odom`` on the map by the newest localization."""
        return None if self.localization is None else self.localization.X_MO

    def motion(self, now: float) -> MotionState | None:
        """The body's state now: the newest odometry, extrapolated by its twist for at most 0.1 s; None before the
        first."""
        newest = self._odometry
        if newest is None:
            return None
        motion = MotionState(newest.X_OB, newest.linear_mps, newest.angular_radps, newest.lateral_mps)
        age_s = now - newest.stamp
        return motion.after(min(max(age_s, 0.0), 0.1) if math.isfinite(age_s) else 0.0)

    def X_MB(self, now: float) -> Pose2 | None:
        """The body on the map now; None without odometry or localization."""
        motion, X_MO = self.motion(now), self.X_MO
        return None if motion is None or X_MO is None else X_MO @ motion.pose

    def problem(self, now: float) -> str:
        """Reason not to drive by the poses, in words for people; "" if there is none."""
        if problem := self._odometry_problem(now):
            return problem
        where = self.localization
        if where is None:
            return "it does not know where it is: nothing localizes it yet"
        match where.state:
            case "mapping" | "tracking":
                return self._localization_problem(where, now)
            case "searching":
                return "it searches its place on the map: drive it a little, or say where it is"
            case _:
                return "it is lost: what the laser sees does not fit the map; drive it a little, or say where it is"

    def is_lost(self, now: float) -> bool:
        """Whether only the pose on the map is unusable: odometry is good, and localization continues."""
        where = self.localization
        if where is None or where.state not in ("searching", "lost"):
            return False
        return not self._odometry_problem(now) and not self._localization_problem(where, now)

    def _odometry_problem(self, now: float) -> str:
        if self._odometry is None:
            return _NO_ODOMETRY
        # Written so that a NaN stamp fails the test.
        if not now - self._odometry.stamp >= -_ODOMETRY_S:
            return "odometry's stamps are not of the robot's clock"
        return _NO_ODOMETRY if now - self._odometry.stamp > _ODOMETRY_S else ""

    def _localization_problem(self, where: Localization, now: float) -> str:
        age_s = now - where.stamp
        if not age_s >= -_ODOMETRY_S:
            return "localization's stamps are not of the robot's clock"
        if age_s > min(_LOCALIZATION_S + _PERIODS * self._period_s, _LONGEST_S):
            return "it waits to be localized: SLAM has just started, or this computer is too slow for it"
        return ""
