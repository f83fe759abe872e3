"""Percepts of messages of one type, placed at their own instant; one of them is followed."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

from app.base.geometry import Pose2, Pose3
from app.base.pose_buffer import PoseBuffer
from app.messages import Faces, QRCodes, SoundSources
from app.modules.behaviors.gaze.gaze_behavior import Look
from app.modules.behaviors.gaze.target_choice import Candidate, TargetChoice

P = TypeVar("P", Faces, QRCodes, SoundSources)

#: Percepts wait so long (s) for odometry to reach their stamp.
_PATIENCE_S = 1.0


class PerceptFollower(Generic[P]):
    """Follows one of the percepts that ``candidates`` finds in a message, given the robot's pose in odom at its stamp.
    ``poses``: X_OB of the last seconds."""

    def __init__(self, poses: PoseBuffer, candidates: Callable[[P, Pose3], list[Candidate]]) -> None:
        self._poses = poses
        self._candidates: Callable[[P, Pose3], list[Candidate]] = candidates
        self._waiting: deque[P] = deque(maxlen=32)
        self._choice: TargetChoice | None = None

    def take(self, percepts: P) -> None:
        """What was perceived; it is looked at by :meth:`look`."""
        self._waiting.append(percepts)

    def rest(self) -> None:
        """The next track begins with the percepts of its time."""
        self._choice = None
        self._waiting.clear()

    def look(self, now: float, X_OB: Pose2 | None, begin: Callable[[], TargetChoice]) -> Look:
        """The percept that is followed, where the robot is at ``now`` (s); where it was last, while it is not
        perceived. ``begin`` gives the choice at the begin of a track."""
        if self._choice is None:
            self._choice = begin()
        choice = self._choice
        self._place(choice, now)
        if problem := choice.problem(now):
            return Look(None, problem, outcome="failed")
        if choice.target is None or X_OB is None:
            return Look(None, f"it waits: {choice.what} is not perceived yet")
        return Look(np.asarray(X_OB.to_pose3().inverse().transform(choice.target.p_OP)))

    def _place(self, choice: TargetChoice, now: float) -> None:
        """Place those that wait, once odometry has reached their stamp."""
        later = []
        for percepts in sorted(self._waiting, key=lambda each: each.stamp):
            X_OB = self._poses.at(percepts.stamp)
            if X_OB is not None:
                choice.see(percepts.stamp, self._candidates(percepts, X_OB.to_pose3()))
            elif now - percepts.stamp < _PATIENCE_S:
                later.append(percepts)
        self._waiting.clear()
        self._waiting.extend(later)
