"""The newest scan and image for the costmap, each with the body's poses at its own stamps."""

from __future__ import annotations

from collections.abc import Callable

from app.base.geometry import Pose2
from app.messages import Image, LaserScan


class PosedReadings:
    """Gives each reading once, when its poses are known; ``scan`` and ``image`` are those that were not given yet.

    ``pose_at``: X_OB at a stamp (s); None before odometry reaches it.
    """

    def __init__(self, pose_at: Callable[[float], Pose2 | None]) -> None:
        self._pose_at = pose_at
        self.scan: LaserScan | None = None
        self.image: Image | None = None

    def add_scan(self, scan: LaserScan) -> None:
        """Take a scan in the place of the last."""
        self.scan = scan

    def add_image(self, image: Image) -> None:
        """Take an image in the place of the last."""
        self.image = image

    def take_scan(self) -> tuple[LaserScan, Pose2, Pose2] | None:
        """The newest scan, with X_OB at its first ray and at its last; None without a new one, or before its poses."""
        scan = self.scan
        if scan is None:
            return None
        begin, end = self._pose_at(scan.stamp), self._pose_at(scan.stamp + scan.duration_s)
        if begin is None or end is None:
            return None
        self.scan = None
        return scan, begin, end

    def take_image(self) -> tuple[Image, Pose2] | None:
        """The newest image, with X_OB; None without a new one, or before its pose."""
        image = self.image
        X_OB = None if image is None else self._pose_at(image.stamp)
        if image is None or X_OB is None:
            return None
        self.image = None
        return image, X_OB
