"""Relocalization on a saved map without a prior pose: several hypotheses, until motion distinguishes them.

Scans of the last metres are combined by odometry, which is accurate over that distance, and matched against the whole
map (``likelihood_field``). Every pose of nearly the best score is kept as a hypothesis. Each hypothesis is scored with
further scans. One is accepted when it explains several scans during motion, the search was repeated from a second
place, and no other scores nearly as well. Two indistinguishable corridors remain two hypotheses.

A pose that something else suggests, a landmark that was seen, is one more hypothesis. It is accepted without motion
when it explains the scans as well as any must, and no other explains them better: the landmark tells similar places
apart.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.modules.perception.slam.likelihood_field import LikelihoodField
from app.modules.perception.slam.types import MOST_SUGGESTED


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """Lengths in m, angles in rad, scores and shares in [0, 1]."""

    #: Motion (m, rad) between two used scans.
    apart_m: float = 0.2
    apart_rad: float = 0.25
    #: Number of combined scans; points kept of one, and of all together.
    most_scans: int = 12
    scan_points: int = 120
    search_points: int = 160
    #: Motion (m, rad) from the last global search to the next.
    again_m: float = 0.7
    again_rad: float = 1.0
    #: Least score of a hypothesis, greatest difference to the best, and greatest number of hypotheses.
    floor: float = 0.45
    margin: float = 0.12
    most_hypotheses: int = 60
    #: Distance (m, rad) within which two hypotheses are one.
    same_m: float = 0.5
    same_rad: float = 0.3
    #: Conditions of acceptance: score of the recent scans and of all, worst single scan ...
    believed: float = 0.75
    believed_each: float = 0.6
    #: ... number of scans (times the number of searches after the first), distance (m) or turn (rad), and ...
    scans: int = 4
    scans_most: int = 40
    motion_m: float = 0.6
    motion_rad: float = 1.5
    #: Advantage over any other hypothesis: points explained only by the better, less those only by the other, as a
    #: share of those of the other, and as a multiple of the standard deviation of chance (McNemar's test).
    ahead_points: int = 25
    ahead_sigmas: float = 4.0


@dataclass(frozen=True, slots=True, eq=False)
class SearchScan:
    """One scan of the search: ``points`` (N, 2) float64 m in ``base_link``, the sensor at ``sensor_xy`` (m), the body
    at ``X_OB``."""

    points: NDArray[np.float64]
    sensor_xy: NDArray[np.float64]
    X_OB: Pose2


@dataclass(frozen=True, slots=True, eq=False)
class PoseHypothesis:
    """One possible pose: ``X_MO`` places ``odom`` on the map. ``score``: explained share of the points of the kept
    scans; ``worst``: the second lowest share of one scan; ``explained``: the value of each point. ``so_far``: sum of
    the shares, and number of scans since the hypothesis was made.
    """

    X_MO: Pose2
    score: float
    worst: float
    explained: NDArray[np.int8]
    so_far: tuple[float, int]


class PoseSearch:
    """Searches the robot's pose on ``field``. Used by one thread at a time."""

    def __init__(self, field: LikelihoodField, settings: SearchSettings | None = None) -> None:
        self._field = field
        self._settings = settings or SearchSettings()
        self._seen: deque[SearchScan] = deque(maxlen=self._settings.most_scans)
        self._searched: list[Pose2] = []
        self._travelled = self._turned = 0.0
        self._scans = 0
        #: Poses X_MO suggested, the newest last, and whether one of them has not been looked at yet.
        self._suggested: deque[Pose2] = deque(maxlen=MOST_SUGGESTED)
        self._suggestion_due = False
        #: Current hypotheses, the likeliest first.
        self.hypotheses: tuple[PoseHypothesis, ...] = ()

    @property
    def overlap(self) -> float:
        """Score of the likeliest hypothesis, in [0, 1]; 0 without any."""
        return self.hypotheses[0].score if self.hypotheses else 0.0

    def suggest(self, X_MO: Pose2) -> None:
        """Take ``X_MO``, which a landmark gives, for a hypothesis at the next scan."""
        self._suggested.append(X_MO)
        self._suggestion_due = True

    def see(self, sighting: SearchScan) -> Pose2 | None:
        """Take a scan; returns X_MO once a hypothesis is accepted.

        A global search takes about 0.1 to 1 s of CPU, scoring the hypotheses a few ms.
        """
        settings = self._settings
        if self._seen:
            motion = self._seen[-1].X_OB.inverse() @ sighting.X_OB
            distance = math.hypot(motion.x, motion.y)
            apart = distance >= settings.apart_m or abs(motion.theta) >= settings.apart_rad
            if not apart and not self._suggestion_due:
                return None
            self._travelled += distance
            self._turned += abs(motion.theta)
        self._seen.append(replace(sighting, points=spread(sighting.points, settings.scan_points)))
        self._scans += 1
        X_OB = sighting.X_OB
        together = self._together(X_OB)
        hypotheses: list[tuple[Pose2, PoseHypothesis | None]] = [
            (place.X_MO @ X_OB, place) for place in self.hypotheses
        ]
        if self._suggestion_due:
            hypotheses += [(X_MO @ X_OB, None) for X_MO in self._suggested]
            self._suggestion_due = False
        if self._search_due(X_OB):
            hypotheses += [(X_MB, None) for X_MB in self._searched_for(together)]
            self._searched.append(X_OB)
        self.hypotheses = self._judged(hypotheses, together, X_OB)
        return self._believed_with_landmark(X_OB) or self._believed()

    def _search_due(self, X_OB: Pose2) -> bool:
        if not self.hypotheses:
            return True
        gone = self._searched[-1].inverse() @ X_OB
        # Two searches are enough, unless their hypotheses no longer fit.
        wanted = len(self._searched) < 2 or self.hypotheses[0].score < self._settings.believed
        far = math.hypot(gone.x, gone.y) > self._settings.again_m or abs(gone.theta) > self._settings.again_rad
        return wanted and far

    def _together(self, X_OB: Pose2) -> NDArray[np.float64]:
        """Points of all kept scans, in the body's current frame."""
        X_BO = X_OB.inverse()
        return np.concatenate([moved(seen.points, X_BO @ seen.X_OB) for seen in self._seen])

    def _searched_for(self, points: NDArray[np.float64]) -> list[Pose2]:
        settings = self._settings
        leaves = self._field.search(spread(points, settings.search_points), settings.floor, settings.margin)
        return distinct([Pose2(x, y, t) for x, y, t, _ in leaves.tolist()], 0.3, 0.2, 3 * settings.most_hypotheses)

    def _judged(
        self, hypotheses: Sequence[tuple[Pose2, PoseHypothesis | None]], points: NDArray[np.float64], X_OB: Pose2
    ) -> tuple[PoseHypothesis, ...]:
        """``hypotheses`` of the body now, each refined on all points, without impossible and duplicate ones; each with
        its earlier scores.
        """
        settings = self._settings
        judged: list[tuple[PoseHypothesis, Pose2]] = []
        few = spread(points, 4 * settings.search_points)
        for X_MB, before in hypotheses:
            pose = self._field.refine(few, np.array([X_MB.x, X_MB.y, X_MB.theta]))
            if not self._field.is_free(pose):
                continue
            place = self._place(Pose2(*pose.tolist()) @ X_OB.inverse(), before)
            judged.append((place, place.X_MO @ X_OB))
        judged.sort(key=lambda one: -one[0].score)
        kept: list[tuple[PoseHypothesis, Pose2]] = []
        for place, X_MB in judged:
            if place.score < max(settings.floor, judged[0][0].score - 2 * settings.margin):
                break
            same = [i for i, (_, other) in enumerate(kept) if close(X_MB, other, settings.same_m, settings.same_rad)]
            if not same:
                kept.append((place, X_MB))
            elif place.so_far[1] > kept[same[0]][0].so_far[1]:
                # An earlier hypothesis is found again, slightly refined.
                kept[same[0]] = replace(kept[same[0]][0], so_far=place.so_far), kept[same[0]][1]
        return tuple(place for place, _ in kept[: settings.most_hypotheses])

    def _place(self, X_MO: Pose2, before: PoseHypothesis | None) -> PoseHypothesis:
        explained_each: list[NDArray[np.int8]] = []
        for seen in self._seen:
            at = X_MO @ seen.X_OB
            explained_each.append(self._field.explained(seen.points, seen.sensor_xy, np.array([at.x, at.y, at.theta])))
        each = [_share(one) for one in explained_each]
        so_far = (each[-1], 1) if before is None else (before.so_far[0] + each[-1], before.so_far[1] + 1)
        worst = sorted(each)[1 if len(each) > 3 else 0]
        return PoseHypothesis(X_MO, sum(each) / len(each), worst, np.concatenate(explained_each), so_far)

    def _believed_with_landmark(self, X_OB: Pose2) -> Pose2 | None:
        """The likeliest hypothesis near a suggested pose, if scans bear it out."""
        settings = self._settings
        for one in self.hypotheses:
            at = one.X_MO @ X_OB
            if not any(close(at, X_MO @ X_OB, settings.same_m, settings.same_rad) for X_MO in self._suggested):
                continue
            fits = one.score >= settings.believed and one.worst >= settings.believed_each
            beaten = any(self._ahead(other, one) for other in self.hypotheses if other is not one)
            return one.X_MO if fits and not beaten else None
        return None

    def _believed(self) -> Pose2 | None:
        settings = self._settings
        moved_enough = self._travelled >= settings.motion_m or self._turned >= settings.motion_rad
        if not self.hypotheses or len(self._searched) < 2 or self._scans < settings.scans or not moved_enough:
            return None
        best, *others = self.hypotheses
        so_far, scans = best.so_far
        # After searches without result the robot may be off the map: the first similar place must not be accepted at
        # once.
        if scans < min(settings.scans * (len(self._searched) - 1), settings.scans_most):
            return None
        if min(best.score, so_far / scans) < settings.believed or best.worst < settings.believed_each:
            return None
        return best.X_MO if all(self._ahead(best, other) for other in others) else None

    def _ahead(self, one: PoseHypothesis, other: PoseHypothesis) -> bool:
        """Whether the points that distinguish both favour ``one`` (McNemar's test)."""
        ours = int(np.count_nonzero((one.explained == 1) & (other.explained == 0)))
        theirs = int(np.count_nonzero((one.explained == 0) & (other.explained == 1)))
        settings = self._settings
        return ours - theirs >= max(settings.ahead_points, settings.ahead_sigmas * math.sqrt(ours + theirs))


def _share(explained: NDArray[np.int8]) -> float:
    """Explained share of the points that are not unknown; these must be at least half of all."""
    judged = np.count_nonzero(explained >= 0)
    return float(np.count_nonzero(explained == 1)) / max(float(judged), 0.5 * len(explained), 1.0)


def moved(points: NDArray[np.float64], pose: Pose2) -> NDArray[np.float64]:
    """``points`` (N, 2) transformed by ``pose``."""
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    placed: NDArray[np.float64] = points @ np.array([[c, s], [-s, c]]) + np.array([pose.x, pose.y])
    return placed


def spread(points: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """At most ``most`` of ``points``, evenly over the floor: near walls have more ray ends than far ones."""
    if len(points) <= most:
        return np.ascontiguousarray(points)
    cell = 0.1
    while True:
        keys = np.floor(points / cell).astype(np.int64)
        _, first = np.unique(keys[:, 0] * 1_000_003 + keys[:, 1], return_index=True)
        if len(first) <= 1.5 * most:
            break
        cell *= 1.4
    first = np.sort(first)
    if len(first) > most:
        first = first[np.linspace(0, len(first) - 1, most).astype(np.int64)]
    return np.ascontiguousarray(points[first])


def close(one: Pose2, other: Pose2, within_m: float, within_rad: float) -> bool:
    turn = abs(math.remainder(one.theta - other.theta, math.tau))
    return turn < within_rad and math.hypot(one.x - other.x, one.y - other.y) < within_m


def distinct(poses: Sequence[Pose2], apart_m: float, apart_rad: float, most: int) -> list[Pose2]:
    """A subset of ``poses``, in order, with pairwise distances above the tolerances."""
    kept: list[Pose2] = []
    for pose in poses:
        if all(not close(pose, other, apart_m, apart_rad) for other in kept):
            kept.append(pose)
            if len(kept) == most:
                break
    return kept
