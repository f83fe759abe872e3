"""The known landmarks: sightings in, landmarks out, while the keyframes that they are anchored to move.

Without a map all are anchored to ``odom``. Once the robot is localized, they belong to the keyframe that it is attached
to, with the drift since they were seen, and the frame of all is the map.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, wrap_angle
from app.messages import DisplacedLandmark, Keyframes, Landmark, Landmarks
from app.modules.perception.landmarks.sightings import (
    FloatArray,
    Fused,
    Sightings,
    fused,
    joined,
    moved,
    placed,
    rotations,
    sighting,
)
from app.modules.perception.landmarks.types import (
    CONFIRMED,
    LOCALIZED,
    MAP,
    ODOM,
    Anchored,
    LandmarkSettings,
    LandmarkState,
    Seen,
)

#: 99.9 % of a chi-square distribution of three degrees of freedom.
_GATE_CHI2 = 16.27
#: Directions further apart (rad, and in standard deviations) are two codes, on both sides of a wall.
_TURNED_RAD = 1.0
_TURNED_SIGMAS = 4.0


class LandmarkMap:
    """The landmarks in the order of first sight. The same text may hang in several places: a sighting that fits no
    landmark of its text makes a new one."""

    def __init__(self, settings: LandmarkSettings | None = None) -> None:
        self.settings = settings or LandmarkSettings()
        self._known: list[Anchored] = []
        self._made = 0
        #: Ids, ascending, and poses of anchors.
        self._ids = np.array([MAP, ODOM])
        self._X_FA = np.zeros((2, 3))
        self._travelled = np.zeros(2)
        self._on_map = False
        self._keyframes: Keyframes | None = None
        #: Metres driven by odometry: in all, and when the keyframes came.
        self._driven_m = self._driven_then_m = 0.0
        self._fused: dict[int, Fused] = {}

    # --- State -------------------------------------------------------------------------------------------------------

    @property
    def frame(self) -> str:
        """``map`` once the robot was localized or a map was loaded, else ``odom``."""
        return "map" if self._on_map else "odom"

    @property
    def localized(self) -> bool:
        """Whether sightings can be placed now: in ``odom`` always."""
        return not self._on_map or (self._keyframes is not None and self._keyframes.state in LOCALIZED)

    @property
    def known(self) -> tuple[Anchored, ...]:
        return tuple(self._known)

    def where(self, landmark: Anchored) -> Fused:
        """Where ``landmark`` is, in the frame of all."""
        found = self._fused.get(landmark.id)
        if found is None:
            rows = np.searchsorted(self._ids, landmark.sightings.anchors)
            settings = self.settings
            found = fused(landmark.sightings, self._X_FA[rows], settings.shared_m, settings.shared_rad)
            self._fused[landmark.id] = found
        return found

    def message(self, stamp: float) -> Landmarks:
        """All landmarks."""
        return Landmarks(stamp, tuple(self._report(landmark) for landmark in self._known), self.frame)

    def displaced(self) -> tuple[DisplacedLandmark, ...]:
        """Landmarks not seen where they were, with the place where their text was found instead."""
        found = []
        for old in self._known if self._on_map else ():
            if old.here and not old.misses >= CONFIRMED:
                continue
            new = [
                other for other in self._known
                if other.text == old.text and other.here and other.seen >= CONFIRMED and other.id > old.id
            ]  # fmt: skip
            if new:
                at, now = self.where(old).p, self.where(new[-1]).p
                found.append(DisplacedLandmark(old.id, old.text, _point(at), now=new[-1].id, p_MR=_point(now)))
        return tuple(found)

    @property
    def state(self) -> LandmarkState:
        """All that is known."""
        driven_m = self._driven_m, self._driven_then_m
        return LandmarkState(
            tuple(self._known), self._made, self._ids, self._X_FA, self._travelled,
            on_map=self._on_map, keyframes=self._keyframes, driven_m=driven_m,
        )  # fmt: skip

    def restore(self, state: LandmarkState) -> None:
        """Go on with ``state``."""
        self._known, self._made, self._fused = list(state.known), state.made, {}
        self._ids, self._X_FA, self._travelled = state.ids, state.X_FA, state.travelled
        self._on_map, self._keyframes = state.on_map, state.keyframes
        self._driven_m, self._driven_then_m = state.driven_m

    # --- Changes of the map ------------------------------------------------------------------------------------------

    def clear(self) -> None:
        """Nothing is known: another map is in use."""
        self._known, self._fused, self._made = [], {}, 0
        self._on_map, self._keyframes = False, None
        self._ids, self._X_FA, self._travelled = np.array([MAP, ODOM]), np.zeros((2, 3)), np.zeros(2)

    def drive(self, distance_m: float) -> None:
        """Odometry moved by ``distance_m``."""
        self._driven_m += distance_m

    def follow(self, keyframes: Keyframes) -> bool:
        """Take over the keyframes; returns whether any landmark may have moved."""
        if not self._on_map and keyframes.state not in LOCALIZED:
            # Where odom is on the map is not known yet.
            return False
        before, self._keyframes = self._keyframes, keyframes
        self._driven_then_m = self._driven_m
        if not self._on_map:
            self._on_map = True
            self._leave_odom(keyframes)
        elif before is not None and before.poses is keyframes.poses and not len(keyframes.removed):
            return False
        self._remove(keyframes)
        ids, X_FA = self._ids, self._X_FA
        self._take_poses(keyframes)
        self._known = [self._reanchored(landmark, ids, X_FA) for landmark in self._known]
        self._fused = {}
        self._join_same()
        return True

    def load(
        self, landmarks: Iterable[Anchored], ids: NDArray[np.int64], X_MK: FloatArray, keyframes: Keyframes
    ) -> None:
        """Take the landmarks kept with the map whose keyframes are ``keyframes``.

        ``ids`` (K,), ascending, and ``X_MK`` (K, 3): the anchors' poses when they were kept, for those that the map has
        no more.
        """
        self.clear()
        self._on_map, self._keyframes = True, keyframes
        self._take_poses(keyframes)
        self._known = [
            replace(self._reanchored(landmark, ids, X_MK), here=False, misses=0, driven_m=self._driven_m)
            for landmark in landmarks
        ]
        self._made = max((landmark.id for landmark in self._known), default=0)

    def resume(self, published: Landmarks) -> None:
        """Go on with landmarks that were published, of which no sighting is known any more."""
        self.clear()
        self._on_map = published.frame == "map"
        anchor = MAP if self._on_map else ODOM
        for mark in published.landmarks:
            covariance = mark.sigma_m**2 * np.eye(3)
            sightings = sighting(
                anchor, np.array(mark.p_FQ, np.float64), covariance, heading=mark.heading,
                heading_sigma=mark.heading_sigma,
            )  # fmt: skip
            self._known.append(
                Anchored(mark.id, mark.text, sightings, mark.sightings, mark.first_seen, last_seen=mark.last_seen)
            )
        self._made = max((mark.id for mark in published.landmarks), default=0)

    def anchors(self) -> tuple[NDArray[np.int64], FloatArray]:
        """Ids (K,), ascending, and poses (K, 3) of the anchors in use."""
        used = np.unique(np.concatenate([np.zeros(0, np.int64), *(one.sightings.anchors for one in self._known)]))
        return used, self._X_FA[np.searchsorted(self._ids, used)]

    # --- Sightings ---------------------------------------------------------------------------------------------------

    def take(self, stamp: float, text: str, seen: Seen, X_OB: Pose2) -> Landmark | None:
        """Take one sighting with the robot at ``X_OB``; returns the landmark that it made or moved, None while the
        robot is not localized on the map."""
        if not self.localized:
            return None
        anchor, new = self._sighting(seen, X_OB)
        at = fused(new, self._X_FA[[np.searchsorted(self._ids, anchor)]], 1e-6, 1e-6)
        same = self._nearest(text, at, anchor)
        if same is None:
            self._made += 1
            landmark = Anchored(self._made, text, new, 1, stamp, last_seen=stamp, driven_m=self._driven_m)
            self._known.append(landmark)
        else:
            former = self._known[same]
            landmark = replace(
                former,
                sightings=joined(former.sightings, new),
                seen=former.seen + 1,
                first_seen=min(former.first_seen, stamp),
                last_seen=max(former.last_seen, stamp),
                driven_m=self._driven_m,
                here=True,
                misses=0,
            )
            self._known[same] = landmark
        self._fused.pop(landmark.id, None)
        return self._report(landmark)

    def miss(self, id: int, stamp: float) -> Anchored:
        """A look at ``stamp`` should have shown the landmark ``id``, and did not; returns it."""
        row = next(row for row, landmark in enumerate(self._known) if landmark.id == id)
        former = self._known[row]
        since = stamp if former.misses == 0 else former.missed
        self._known[row] = replace(former, misses=former.misses + 1, missed=since)
        return self._known[row]

    def remove(self, id: int) -> None:
        """Forget the landmark ``id``."""
        self._known = [landmark for landmark in self._known if landmark.id != id]
        self._fused.pop(id, None)

    def X_FB(self, X_OB: Pose2) -> Pose2:
        """The robot in the frame of the landmarks, with odometry at ``X_OB``; for a robot that is localized."""
        return X_OB if self._keyframes is None else self._keyframes.X_MO @ X_OB

    # --- Inside ------------------------------------------------------------------------------------------------------

    def _report(self, landmark: Anchored) -> Landmark:
        at = self.where(landmark)
        return Landmark(
            landmark.text,
            _point(at.p),
            sigma_m=float(np.sqrt(np.trace(at.covariance) / 3.0)),
            sightings=landmark.seen,
            first_seen=landmark.first_seen,
            last_seen=landmark.last_seen,
            heading=at.heading,
            heading_sigma=at.heading_sigma,
            id=landmark.id,
        )

    def _sighting(self, seen: Seen, X_OB: Pose2) -> tuple[int, Sightings]:
        settings, keyframes = self.settings, self._keyframes
        if keyframes is None:
            anchor, pose = ODOM, np.zeros((3, 3))
        else:
            anchor = MAP if keyframes.keyframe not in self._ids else keyframes.keyframe
            driven = self._driven_m - self._driven_then_m
            drift = np.array([settings.drift_per_m, settings.drift_per_m, settings.turn_per_m]) * driven
            pose = keyframes.covariance + np.diag(drift**2)
        X_FB = self.X_FB(X_OB)
        x, y, theta = self._X_FA[np.searchsorted(self._ids, anchor)].tolist()
        X_AB = Pose2(x, y, theta).inverse() @ X_FB
        # The pose's covariance is along the axes of F, what is kept along the anchor's.
        R = rotations(np.array([-theta]))[0]
        pose = R @ pose @ R.T
        dx, dy = (X_AB.transform(seen.p_BQ[:2]) - (X_AB.x, X_AB.y)).tolist()
        J = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx]])
        covariance = seen.sigma_m**2 * np.eye(3)
        covariance[:2, :2] += J @ pose @ J.T
        heading = None if seen.heading is None else X_AB.theta + seen.heading
        sigma = None if seen.heading_sigma is None else float(np.hypot(seen.heading_sigma, np.sqrt(pose[2, 2])))
        return anchor, sighting(anchor, placed(X_AB, seen.p_BQ), covariance, heading, sigma)

    def _nearest(self, text: str, at: Fused, anchor: int) -> int | None:
        """The landmark of this text that a sighting fits best."""
        fits = [(self._misfit(one, at, anchor), row) for row, one in enumerate(self._known) if one.text == text]
        return min((row for row in fits if row[0] <= _GATE_CHI2), default=(0.0, None))[1]

    def _misfit(self, landmark: Anchored, at: Fused, anchor: int) -> float:
        """Squared distance in standard deviations; infinite for a code that looks another way."""
        settings, other = self.settings, self.where(landmark)
        if _turned(at, other):
            return np.inf
        off = at.p - other.p
        spread = at.covariance + other.covariance + 2.0 * settings.gate_sigma_m**2 * np.eye(3)
        spread += self._drift_m(landmark, anchor) ** 2 * np.diag([1.0, 1.0, 0.0])
        misfit = float(off @ np.linalg.solve(spread, off))
        if self._keyframes is None and np.linalg.norm(off) <= settings.gate_m:
            return min(misfit, _GATE_CHI2)
        return misfit

    def _drift_m(self, landmark: Anchored, anchor: int) -> float:
        """Sigma of the drift between the landmark's sightings and ``anchor``; none on a map that stays."""
        settings, keyframes = self.settings, self._keyframes
        if keyframes is None:
            return settings.drift_per_m * (self._driven_m - landmark.driven_m)
        if keyframes.state == "tracking" or anchor < 0:
            return 0.0
        rows = np.searchsorted(self._ids, landmark.sightings.anchors)
        between = np.abs(self._travelled[rows] - self._travelled[np.searchsorted(self._ids, anchor)])
        return min(settings.map_drift_m, settings.map_drift_per_m * float(between.min()))

    def _take_poses(self, keyframes: Keyframes) -> None:
        self._ids = np.concatenate(([MAP, ODOM], keyframes.ids))
        X_MO = keyframes.X_MO
        self._X_FA = np.concatenate(([[0.0, 0.0, 0.0], [X_MO.x, X_MO.y, X_MO.theta]], keyframes.poses))
        self._travelled = np.concatenate(([0.0, 0.0], keyframes.travelled_m))

    def _leave_odom(self, keyframes: Keyframes) -> None:
        """Anchor what was seen in odom to the robot's keyframe, with odometry's drift since."""
        settings = self.settings
        self._take_poses(keyframes)
        anchor = keyframes.keyframe if keyframes.keyframe in self._ids else MAP
        known = []
        for landmark in self._known:
            rows = landmark.sightings.anchors == ODOM
            if rows.any():
                drift = settings.drift_per_m * (self._driven_m - landmark.driven_m)
                own = np.linalg.inv(landmark.sightings.information) + drift**2 * np.diag([1.0, 1.0, 0.0])
                loose = replace(landmark.sightings, information=np.asarray(np.linalg.inv(own), np.float64))
                landmark = replace(landmark, sightings=self._onto(loose, rows, anchor, self._X_FA[[1]]))
            known.append(landmark)
        self._known = known

    def _remove(self, keyframes: Keyframes) -> None:
        """Anchor what belongs to pruned keyframes where their scans went."""
        for id, into, X_IR in zip(
            keyframes.removed.tolist(), keyframes.into.tolist(), keyframes.X_IR, strict=True
        ):  # fmt: skip
            for row, landmark in enumerate(self._known):
                rows = landmark.sightings.anchors == id
                if rows.any():
                    sightings = moved(landmark.sightings, rows, np.array([into]), X_IR[None])
                    self._known[row] = replace(landmark, sightings=sightings)

    def _reanchored(self, landmark: Anchored, ids: NDArray[np.int64], X_MK: FloatArray) -> Anchored:
        """``landmark`` with anchors that are no more, at ``X_MK`` when they were ``ids``, replaced by the nearest."""
        sightings = landmark.sightings
        for id in np.setdiff1d(sightings.anchors, self._ids).tolist():
            last = X_MK[np.searchsorted(ids, id)]
            keyframes = self._X_FA[2:]
            nearest = MAP
            if len(keyframes):
                nearest = int(self._ids[2 + np.argmin(np.linalg.norm(keyframes[:, :2] - last[:2], axis=1))])
            sightings = self._onto(sightings, sightings.anchors == id, nearest, last[None])
        return landmark if sightings is landmark.sightings else replace(landmark, sightings=sightings)

    def _onto(self, sightings: Sightings, rows: NDArray[np.bool_], anchor: int, X_FK: FloatArray) -> Sightings:
        """``rows`` anchored to ``anchor``, with their former anchor at ``X_FK`` (1, 3) in the landmarks' frame."""
        X_FA = Pose2(*self._X_FA[np.searchsorted(self._ids, anchor)].tolist())
        X_AK = X_FA.inverse() @ Pose2(*X_FK[0].tolist())
        count = int(np.count_nonzero(rows))
        return moved(sightings, rows, np.full(count, anchor), np.tile([X_AK.x, X_AK.y, X_AK.theta], (count, 1)))

    def _join_same(self) -> None:
        """Join landmarks of one text that are one, once their keyframes are where they belong: a loop was closed."""
        known: list[Anchored] = []
        for landmark in self._known:
            row = next((row for row, other in enumerate(known) if self._one(other, landmark)), None)
            if row is None:
                known.append(landmark)
                continue
            other = known[row]
            known[row] = replace(
                other,
                sightings=joined(other.sightings, landmark.sightings),
                seen=other.seen + landmark.seen,
                first_seen=min(other.first_seen, landmark.first_seen),
                last_seen=max(other.last_seen, landmark.last_seen),
                driven_m=max(other.driven_m, landmark.driven_m),
                here=other.here or landmark.here,
                misses=0,
            )
            self._fused.pop(other.id, None)
        self._known = known

    def _one(self, one: Anchored, other: Anchored) -> bool:
        if one.text != other.text:
            return False
        at, there = self.where(one), self.where(other)
        spread = at.covariance + there.covariance + 2.0 * self.settings.gate_sigma_m**2 * np.eye(3)
        off = at.p - there.p
        return not _turned(at, there) and float(off @ np.linalg.solve(spread, off)) <= _GATE_CHI2


def _turned(one: Fused, other: Fused) -> bool:
    """Whether two sightings look different ways: they are of two codes."""
    if one.heading is None or other.heading is None:
        return False
    sigma = np.hypot(one.heading_sigma or 0.0, other.heading_sigma or 0.0)
    return abs(wrap_angle(one.heading - other.heading)) > max(_TURNED_RAD, _TURNED_SIGMAS * float(sigma))


def _point(p: FloatArray) -> tuple[float, float, float]:
    x, y, z = p.tolist()
    return x, y, z
