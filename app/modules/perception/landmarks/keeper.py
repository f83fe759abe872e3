"""What QRCodeDetector knows of landmarks: which are news, gone or displaced, and where a lost robot may be by them."""

from __future__ import annotations

import logging
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from app.base.geometry import Pose2
from app.messages import DisplacedLandmarks, Image, Keyframes, LandmarkPose, Landmarks, read_only
from app.modules.perception.landmarks.landmark_file import StoredLandmarks
from app.modules.perception.landmarks.landmark_map import LandmarkMap
from app.modules.perception.landmarks.looks import should_show
from app.modules.perception.landmarks.robot_pose import pose_by_landmark
from app.modules.perception.landmarks.types import LandmarkSettings, LandmarkState, Seen

#: A code read in an image, and where.
Found = tuple[str, Seen]


@dataclass(frozen=True, slots=True)
class KeeperSettings:
    """Landmarks that moved less than ``moved_m`` are not news, unless they were not published for ``refresh_s``. One is
    gone after ``gone_looks`` looks in a row, over ``gone_s``, that should have shown it."""

    landmarks: LandmarkSettings
    moved_m: float = 0.01
    refresh_s: float = 1.0
    gone_looks: int = 10
    gone_s: float = 10.0


class LandmarkKeeper:
    """The landmarks of the map in use. Called on the event loop alone."""

    def __init__(self, settings: KeeperSettings, log: logging.Logger | logging.LoggerAdapter[logging.Logger]) -> None:
        self._settings = settings
        self._log = log
        self.map = LandmarkMap(settings.landmarks)
        self._published: Landmarks | None = None
        self._displaced: frozenset[tuple[int, int]] = frozenset()
        self._keyframes: Keyframes | None = None
        #: Keyframes of an earlier version are of a map that is in use no more.
        self._least_version = 0
        #: Landmarks of a map whose keyframes have not come yet.
        self._waiting: StoredLandmarks | None = None

    # --- The map in use ----------------------------------------------------------------------------------------------

    def follow(self, keyframes: Keyframes) -> bool:
        """Take over the keyframes; returns whether any landmark may have moved."""
        if keyframes.version < self._least_version:
            return False
        self._keyframes = keyframes
        if self._waiting is not None:
            self.load(self._waiting)
            return True
        return self.map.follow(keyframes)

    def change_map(self, version: int) -> None:
        """Another map is in use, whose keyframes have at least this ``version``. What is on the former map is void,
        what was seen in odom is not."""
        self._least_version, self._keyframes, self._waiting = version, None, None
        if self.map.frame == "map":
            self.map.clear()

    def load(self, stored: StoredLandmarks) -> None:
        """Take over the landmarks kept with the map in use."""
        self._waiting = stored if self._keyframes is None else None
        if self._keyframes is not None:
            self.map.load(stored.landmarks, stored.ids, stored.X_MK, self._keyframes)

    def snapshot(self) -> StoredLandmarks:
        """The landmarks to keep with the map; none of those that are not on it."""
        if self.map.frame != "map":
            return self._waiting or StoredLandmarks((), np.zeros(0, np.int64), np.zeros((0, 3)))
        ids, X_MK = self.map.anchors()
        return StoredLandmarks(self.map.known, ids, X_MK)

    # --- Images ------------------------------------------------------------------------------------------------------

    def see(self, stamp: float, found: Iterable[Found], X_OB: Pose2) -> frozenset[int]:
        """Take the codes found in one image; returns the ids of their landmarks."""
        marks = [self.map.take(stamp, text, seen, X_OB) for text, seen in found]
        return frozenset(mark.id for mark in marks if mark is not None)

    def look(self, image: Image, X_OB: Pose2, shown: frozenset[int], unplaced: Collection[str]) -> None:
        """Count the landmarks on the map that ``image`` should have shown, the robot standing.

        Those ``shown`` were, and so may be those with a text that was read ``unplaced``.
        """
        if self.map.frame != "map" or not self.map.localized:
            return
        X_FC = self.map.X_FB(X_OB).to_pose3() @ image.X_BC
        for landmark in self.map.known:
            at = self.map.where(landmark)
            if landmark.id in shown or landmark.text in unplaced:
                continue
            if at.heading is None or not should_show(image, X_FC, at.p, at.heading):
                continue
            missed = self.map.miss(landmark.id, image.stamp)
            if missed.misses >= self._settings.gone_looks and image.stamp - missed.missed >= self._settings.gone_s:
                self.map.remove(landmark.id)
                x, y, _ = at.p.tolist()
                place = f"x {x:.2f} m, y {y:.2f} m in {self.map.frame}"
                self._log.info(
                    "the code %r is gone from %s: %d looks did not show it", landmark.text, place, missed.misses
                )

    def poses(self, stamp: float, found: Sequence[Found], X_OB: Pose2) -> list[LandmarkPose]:
        """Where the robot may be, by the landmarks on the map that say what was found; none while it is localized."""
        if self.map.localized:
            return []
        poses = []
        for text, seen in found:
            for landmark in self.map.known:
                by = pose_by_landmark(self.map.where(landmark), seen) if landmark.text == text else None
                if by is not None:
                    X_MB, covariance = by
                    X_MO = X_MB @ X_OB.inverse()
                    poses.append(LandmarkPose(stamp, X_MO, read_only(covariance), landmark=landmark.id, text=text))
        return poses

    # --- News --------------------------------------------------------------------------------------------------------

    def resume(self, published: Landmarks, state: LandmarkState | None) -> None:
        """Go on with landmarks that were published, and with their ``state`` if it is known."""
        self._published = published
        if state is None:
            self.map.resume(published)
        else:
            self.map.restore(state)

    def news(self, stamp: float, *, seen: bool) -> Landmarks | None:
        """All landmarks, if that is news; ``seen``: their counts are, too, from time to time."""
        published = self._published
        # The images of two cameras are processed in turn, and one may come later with an earlier stamp.
        known = self.map.message(stamp if published is None else max(stamp, published.stamp))
        if published is None:
            is_news = bool(known.landmarks)
        else:
            stale = seen and known.stamp - published.stamp >= self._settings.refresh_s
            is_news = stale or _differ(published, known, self._settings.moved_m)
        if not is_news:
            return None
        self._published = known
        return known

    def displaced(self, stamp: float) -> DisplacedLandmarks:
        """The landmarks that hang elsewhere than the map says; a new one is logged."""
        found = self.map.displaced()
        for mark in found:
            if (mark.id, mark.now) not in self._displaced:
                (x, y, _), (u, v, _) = mark.p_MQ, mark.p_MR
                there, now = f"x {x:.2f} m, y {y:.2f} m", f"x {u:.2f} m, y {v:.2f} m"
                off_m = math.dist(mark.p_MQ, mark.p_MR)
                self._log.warning(
                    "the code %r hangs at %s, %.2f m from %s, where the map has it", mark.text, now, off_m, there
                )
        self._displaced = frozenset((mark.id, mark.now) for mark in found)
        return DisplacedLandmarks(stamp, found)


def _differ(published: Landmarks, known: Landmarks, moved_m: float) -> bool:
    if published.frame != known.frame:
        return True
    before: Mapping[int, tuple[float, float, float]] = {mark.id: mark.p_FQ for mark in published.landmarks}
    if before.keys() != {mark.id for mark in known.landmarks}:
        return True
    return any(math.dist(before[mark.id], mark.p_FQ) > moved_m for mark in known.landmarks)
