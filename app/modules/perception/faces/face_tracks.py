"""Multi-target tracking of faces: a face keeps its number while visible, over frames, cameras and turns of the robot.

Each track is a Kalman filter in ``odom`` of position and horizontal velocity, x = (x, y, z, v_x, v_y), walking at
nearly constant velocity. It takes two kinds of sightings:

- measured by depth: the position, with its covariance;
- by direction alone: the two offsets of the predicted position across the ray. The distance by the height prior is used
  once, at the track's birth, where it gives the filter a height and a distance correlated along the ray. Its use at
  each image would count the same unknown (this person's height) many times, and the filter would become certain of a
  wrong place for a tall person. A face once measured by depth keeps its height, so its distance stays known when only
  the other camera sees it.

The size of a face in the image, too, says how far it is, for faces are much of one size. A person's own size is as
unknown as the height, so it is used once, at birth, and otherwise only in the question whose a sighting is: without it,
faces of two persons, one seen by either camera, are one nearer face where their rays pass each other.

Sightings are assigned to tracks jointly, at the least sum of d² + ln |S| (Mahalanobis distance and spread of the
innovation), inside a gate. Sightings without a track may continue one by the overlap of their box with that in the last
image of the same camera; this is the only criterion while the robot's pose is unknown.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose3
from app.modules.perception.faces.face_position import FaceSighting, ray_covariance
from app.modules.perception.faces.yunet import Detection, overlap

Vector = NDArray[np.float64]
Box = tuple[float, float, float, float]

#: Gates: squared Mahalanobis distances that a right pair exceeds once in a thousand times, by dimension.
_GATES = {2: 13.8, 3: 16.3, 4: 18.5}
#: Cost above that of any pair inside the gates.
_NEVER = 1e6
#: Size (m) of a face as :func:`.face_position.apparent_size` has it, and the standard deviation of its logarithm: by
#: persons, by turned heads, and by the detector's boxes, whose own is 0.03 to 0.14 between 2 and 9 m.
FACE_M, _FACE_LOG = 0.165, 0.15


@dataclass(frozen=True, slots=True)
class TrackModel:
    """Motion of people, and how long an unseen face keeps its track."""

    acceleration_mps2: float = 1.5
    speed_mps: float = 0.8
    bobbing_mps: float = 0.05
    forget_s: float = 1.2
    #: ... and at least this many images of the camera that saw it last (decimated streams are slow).
    forget_images: float = 2.5
    #: Least standard deviation of a direction (rad): calibration, and interpolation of the pose.
    angle_floor: float = 0.012
    #: Least standard deviation of a measured position (m), for the same reasons.
    place_floor_m: float = 0.03
    overlap: float = 0.4
    most: int = 100


@dataclass(frozen=True, slots=True)
class TrackedFace:
    """A sighting's track number, and the face's position by all sightings of the track, in ``base_link`` at the image's
    stamp."""

    track: int
    p_BF: Vector
    covariance: Vector


@dataclass(slots=True)
class _Track:
    number: int
    seen: float
    camera: str
    box: Box
    #: State and covariance at ``seen``; None while the robot's pose is unknown.
    x: Vector | None = None
    P: Vector | None = None
    boxes: dict[str, tuple[float, Box]] = field(default_factory=dict)


class FaceTracks:
    """Tracks of all faces in view. ``first``: number of the first track."""

    def __init__(self, model: TrackModel | None = None, first: int = 1) -> None:
        self._model = model or TrackModel()
        self.next = first
        """The number of the next new track."""
        self._tracks: list[_Track] = []
        #: Stamp of the last image and usual period, by camera.
        self._images: dict[str, tuple[float, float]] = {}

    @property
    def numbers(self) -> tuple[int, ...]:
        """Numbers of the current tracks, in the order of birth."""
        return tuple(track.number for track in self._tracks)

    def see(
        self, stamp: float, camera: str, sightings: Sequence[FaceSighting], X_OB: Pose3 | None
    ) -> tuple[TrackedFace, ...]:
        """Assign tracks to one image's ``sightings``; ``X_OB``: the robot's pose at ``stamp``, if known."""
        self._note_image(stamp, camera)
        self._drop_old(stamp)
        pairs = {} if X_OB is None else self._by_place(stamp, sightings, X_OB)
        pairs |= self._by_overlap(stamp, camera, [sighting.face for sighting in sightings], pairs)
        placed = []
        for index, sighting in enumerate(sightings):
            track = pairs.get(index)
            if track is None:
                track = self._new(stamp, camera, sighting.face)
            placed.append(self._placed(track, stamp, camera, sighting, X_OB))
        self._keep_the_newest()
        return tuple(placed)

    def see_in_image(self, stamp: float, camera: str, faces: Sequence[Detection]) -> tuple[int, ...]:
        """Track numbers of one image's ``faces`` without camera pose: by their boxes alone."""
        self._note_image(stamp, camera)
        self._drop_old(stamp)
        pairs = self._by_overlap(stamp, camera, faces, {})
        tracks = [pairs.get(index) or self._new(stamp, camera, face) for index, face in enumerate(faces)]
        for track, face in zip(tracks, faces, strict=True):
            self._note_seen(track, stamp, camera, face)
        self._keep_the_newest()
        return tuple(track.number for track in tracks)

    # --- life and death ------------------------------------------------------------------------------------------

    def _new(self, stamp: float, camera: str, face: Detection) -> _Track:
        track = _Track(self.next, stamp, camera, face.box)
        self.next += 1
        self._tracks.append(track)
        return track

    def _note_seen(self, track: _Track, stamp: float, camera: str, face: Detection) -> None:
        track.seen, track.camera, track.box = max(stamp, track.seen), camera, face.box
        track.boxes[camera] = (stamp, face.box)

    def _keep_the_newest(self) -> None:
        if len(self._tracks) > self._model.most:
            self._tracks = sorted(self._tracks, key=lambda t: t.seen)[-self._model.most :]

    def _note_image(self, stamp: float, camera: str) -> None:
        last, usual = self._images.get(camera, (stamp, 0.0))
        gap = stamp - last
        if gap > 0:
            usual = gap if usual == 0 else usual + 0.3 * (min(gap, 3 * usual) - usual)
        self._images[camera] = (max(stamp, last), usual)

    def _drop_old(self, stamp: float) -> None:
        def waited_for(track: _Track) -> bool:
            patience = max(self._model.forget_s, self._model.forget_images * self._images[track.camera][1])
            return stamp - track.seen <= patience

        self._tracks = [track for track in self._tracks if waited_for(track)]

    # --- assignment ----------------------------------------------------------------------------------------------

    def _by_place(self, stamp: float, sightings: Sequence[FaceSighting], X_OB: Pose3) -> dict[int, _Track]:
        tracks = [track for track in self._tracks if track.x is not None]
        if not tracks or not sightings:
            return {}
        costs = np.full((len(sightings), len(tracks)), _NEVER)
        for column, track in enumerate(tracks):
            x, P = self._predicted(track, stamp)
            for row, sighting in enumerate(sightings):
                residual, H, R = self._with_size(sighting, x, X_OB)
                S = H @ P @ H.T + R
                distance = float(residual @ np.linalg.solve(S, residual))
                if distance <= _GATES[len(residual)]:
                    costs[row, column] = distance + math.log(float(np.linalg.det(S)))
        rows, columns = _assigned(costs)
        return {int(r): tracks[c] for r, c in zip(rows, columns, strict=True) if costs[r, c] < _NEVER}

    def _by_overlap(
        self, stamp: float, camera: str, faces: Sequence[Detection], pairs: dict[int, _Track]
    ) -> dict[int, _Track]:
        taken = {track.number for track in pairs.values()}
        left = [index for index in range(len(faces)) if index not in pairs]
        fresh = max(0.5, self._model.forget_images * self._images[camera][1])
        tracks = [
            track
            for track in self._tracks
            if track.number not in taken and camera in track.boxes and stamp - track.boxes[camera][0] <= fresh
        ]
        if not left or not tracks:
            return {}
        shares = np.array([[overlap(faces[i].box, t.boxes[camera][1]) for t in tracks] for i in left])
        rows, columns = _assigned(-shares)
        return {left[r]: tracks[c] for r, c in zip(rows, columns, strict=True) if shares[r, c] >= self._model.overlap}

    # --- filter --------------------------------------------------------------------------------------------------

    def _placed(
        self, track: _Track, stamp: float, camera: str, sighting: FaceSighting, X_OB: Pose3 | None
    ) -> TrackedFace:
        placed_face = TrackedFace(track.number, sighting.p_BF, sighting.covariance)
        if X_OB is not None:
            self._update(track, stamp, sighting, X_OB)
            if not sighting.measured and track.x is not None and track.P is not None:
                R_BO = X_OB.rotation.T
                p_BF = np.asarray(X_OB.inverse().transform(track.x[:3]), np.float64)
                placed_face = TrackedFace(track.number, p_BF, R_BO @ track.P[:3, :3] @ R_BO.T)
        self._note_seen(track, stamp, camera, sighting.face)
        return placed_face

    def _predicted(self, track: _Track, stamp: float) -> tuple[Vector, Vector]:
        """State and covariance at ``stamp``; those of the last sighting for an image that is older than it."""
        assert track.x is not None
        assert track.P is not None
        dt = max(0.0, stamp - track.seen)
        F = np.eye(5)
        F[0, 3] = F[1, 4] = dt
        q = self._model.acceleration_mps2**2
        Q = np.zeros((5, 5))
        for place, speed in ((0, 3), (1, 4)):
            Q[place, place] = q * dt**3 / 3
            Q[place, speed] = Q[speed, place] = q * dt**2 / 2
            Q[speed, speed] = q * dt
        Q[2, 2] = self._model.bobbing_mps**2 * dt
        return F @ track.x, F @ track.P @ F.T + Q

    def _measurement(self, sighting: FaceSighting, x: Vector, X_OB: Pose3) -> tuple[Vector, Vector, Vector]:
        """Residual, Jacobian and noise of the sighting."""
        ray = X_OB.rotation @ sighting.ray
        origin = X_OB.transform(sighting.origin)
        if sighting.measured:
            H = np.eye(3, 5)
            R = X_OB.rotation @ sighting.covariance @ X_OB.rotation.T + self._model.place_floor_m**2 * np.eye(3)
            return origin + sighting.range_m * ray - x[:3], H, R
        across = _across(ray)
        H = np.hstack((across, np.zeros((2, 2))))
        range_m = max(0.3, float(ray @ (x[:3] - origin)))
        sigma = range_m * math.hypot(sighting.angle_sigma, self._model.angle_floor)
        return across @ (origin - x[:3]), H, sigma**2 * np.eye(2)

    def _with_size(self, sighting: FaceSighting, x: Vector, X_OB: Pose3) -> tuple[Vector, Vector, Vector]:
        """The same with the logarithm of the size, which does not move the track."""
        residual, H, R = self._measurement(sighting, x, X_OB)
        if not sighting.size_rad > 0:
            return residual, H, R
        towards = x[:3] - X_OB.transform(sighting.origin)
        range_m = max(0.3, float(np.linalg.norm(towards)))
        size = math.log(FACE_M / (sighting.size_rad * range_m))
        n = len(residual)
        wider = np.zeros((n + 1, n + 1))
        wider[:n, :n], wider[n, n] = R, _FACE_LOG**2
        along = np.concatenate((towards / range_m**2, np.zeros(2)))
        return np.append(residual, size), np.vstack((H, along)), wider

    def _update(self, track: _Track, stamp: float, sighting: FaceSighting, X_OB: Pose3) -> None:
        if track.x is None:
            track.x, track.P = self._born(sighting, X_OB)
            return
        x, P = self._predicted(track, stamp)
        residual, H, R = self._measurement(sighting, x, X_OB)
        S = H @ P @ H.T + R
        gain = np.linalg.solve(S, H @ P).T
        x, left = x + gain @ residual, np.eye(5) - gain @ H
        P = left @ P @ left.T + gain @ R @ gain.T
        if float(residual @ np.linalg.solve(S, residual)) > _GATES[len(residual)] or not self._likely(
            sighting, x, P, X_OB
        ):
            # The track continued by its box alone, or by directions until its distance was lost: restart its position.
            x, P = self._born(sighting, X_OB)
        track.x, track.P = x, P

    def _likely(self, sighting: FaceSighting, x: Vector, P: Vector, X_OB: Pose3) -> bool:
        ray = X_OB.rotation @ sighting.ray
        range_m = float(ray @ (x[:3] - X_OB.transform(sighting.origin)))
        along_m = math.sqrt(max(0.0, float(ray @ P[:3, :3] @ ray)))
        return sighting.measured or (0.3 < range_m < 10 and along_m <= max(sighting.range_sigma_m, 0.5) * 1.5)

    def _born(self, sighting: FaceSighting, X_OB: Pose3) -> tuple[Vector, Vector]:
        ray = X_OB.rotation @ sighting.ray
        range_m, range_sigma_m = _by_size(sighting)
        x = np.zeros(5)
        x[:3] = X_OB.transform(sighting.origin) + range_m * ray
        angle = math.hypot(sighting.angle_sigma, self._model.angle_floor)
        P = np.diag([0.0, 0.0, 0.0, self._model.speed_mps**2, self._model.speed_mps**2])
        P[:3, :3] = ray_covariance(ray, range_sigma_m, range_m * angle)
        if sighting.measured:
            P[:3, :3] += self._model.place_floor_m**2 * np.eye(3)
        return x, P


def _by_size(sighting: FaceSighting) -> tuple[float, float]:
    """Range (m) of a sighting and its standard deviation; without depth, by the size of faces, too."""
    if sighting.measured or not sighting.size_rad > 0:
        return sighting.range_m, sighting.range_sigma_m
    far = FACE_M / sighting.size_rad
    of_height, of_size = sighting.range_sigma_m**-2, (_FACE_LOG * far) ** -2
    together = of_height + of_size
    return (of_height * sighting.range_m + of_size * far) / together, together**-0.5


def _across(ray: Vector) -> Vector:
    """Two unit vectors (2, 3) orthogonal to ``ray`` and each other."""
    helper = np.array((0.0, 0.0, 1.0)) if abs(ray[2]) < 0.9 else np.array((1.0, 0.0, 0.0))
    first = np.cross(helper, ray)
    first /= np.linalg.norm(first)
    return np.stack((first, np.cross(ray, first)))


def prepare() -> None:
    """Load lazily imported packages in a module's thread, where the delay blocks no other work."""
    _assigned(np.zeros((1, 1)))


def _assigned(costs: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of least cost together (Kuhn, 1955)."""
    from scipy.optimize import linear_sum_assignment  # takes 0.3 s, too long for a start

    rows, columns = linear_sum_assignment(costs)
    return rows, columns
