"""The recent past of a moving frame: poses are looked up at a message's own stamp, never "now".

Fusing or drawing a percept with another instant's pose smears it (thesis 3.4); this buffer is what prevents it.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import deque

from app.base.geometry import Pose2


class PoseBuffer:
    """Poses ``X_OB`` over the last ``span_s`` seconds, interpolated in between.

    A stamp up to ``tolerance_s`` beyond either end takes the nearest pose, since sensors and odometry are not in
    step; further out there is no answer.
    """

    def __init__(self, span_s: float = 10.0, tolerance_s: float = 0.1) -> None:
        self._span_s = span_s
        self._tolerance_s = tolerance_s
        self._stamps: deque[float] = deque()
        self._poses: deque[Pose2] = deque()

    def add(self, stamp: float, pose: Pose2) -> None:
        """Append a pose; one that is not newer than the last is ignored."""
        if self._stamps and stamp <= self._stamps[-1]:
            return
        self._stamps.append(stamp)
        self._poses.append(pose)
        while self._stamps[0] < stamp - self._span_s:
            self._stamps.popleft()
            self._poses.popleft()

    def at(self, stamp: float) -> Pose2 | None:
        """The pose at ``stamp``, or None where the buffer does not reach."""
        if not self._stamps:
            return None
        after = bisect_right(self._stamps, stamp)
        if after == 0:
            return self._poses[0] if self._stamps[0] - stamp <= self._tolerance_s else None
        if after == len(self._stamps):
            return self._poses[-1] if stamp - self._stamps[-1] <= self._tolerance_s else None
        before = after - 1
        begin, end = self._stamps[before], self._stamps[after]
        return self._poses[before].interpolate(self._poses[after], (stamp - begin) / (end - begin))
