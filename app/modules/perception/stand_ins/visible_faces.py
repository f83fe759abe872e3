"""Which faces the robot's cameras would see: pure functions of the truth."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2, Pose3, wrap_angle
from app.maps.grid_rays import GridRays
from app.messages import Face, PersonTruth, read_only

#: A face that looks farther aside (rad) is not found.
TURNED_RAD = math.radians(70)
#: The middle of the face is above the mouth by this share of the height.
_ABOVE_MOUTH = 0.03
#: Width of a face (m), and the standard deviations of its place (m).
_WIDE_M = 0.16
_SIGMA_M = 0.05


@dataclass(frozen=True, slots=True)
class Eye:
    """A camera: its frame in the model, full fields of view (rad), how far it finds faces (m), picture size (px) and
    rate (Hz)."""

    frame: str
    fov: tuple[float, float]
    reach_m: float
    size: tuple[int, int]
    rate_hz: float


def visible(
    people: Iterable[PersonTruth], X_MB: Pose2, X_BC: Pose3, eye: Eye, rays: GridRays | None
) -> Iterator[tuple[PersonTruth, Face]]:
    """The people whose faces ``eye`` at ``X_BC`` would find, and their faces with track 0; with ``rays`` on the map,
    those that are not behind a wall."""
    X_MC = X_MB @ Pose2(float(X_BC.translation[0]), float(X_BC.translation[1]))
    for person in people:
        x, y, z = person.mouth[0], person.mouth[1], person.mouth[2] + _ABOVE_MOUTH * person.height_m
        away = math.atan2(X_MC.y - y, X_MC.x - x)
        if abs(wrap_angle(person.heading - away)) > TURNED_RAD:
            continue
        at = X_MB.inverse() @ Pose2(x, y)
        p_BF = np.array([at.x, at.y, z])
        ahead = X_BC.rotation.T @ (p_BF - X_BC.translation)
        range_m = float(np.linalg.norm(ahead))
        aside, down = math.atan2(ahead[0], ahead[2]), math.atan2(ahead[1], math.hypot(ahead[0], ahead[2]))
        if range_m > eye.reach_m or abs(aside) > eye.fov[0] / 2 or abs(down) > eye.fov[1] / 2:
            continue
        if rays is not None and not rays.sees((X_MC.x, X_MC.y), (x, y)):
            continue
        yield person, _face(p_BF, range_m, aside, down, eye)


def _face(p_BF: NDArray[np.float64], range_m: float, aside: float, down: float, eye: Eye) -> Face:
    (width, height), (across, upright) = eye.size, eye.fov
    wide = _WIDE_M / range_m / across * width
    middle = ((aside / across + 0.5) * width, (down / upright + 0.5) * height)
    x, y, z = p_BF.tolist()
    return Face(
        track=0,
        score=0.9,
        box=(middle[0] - wide / 2, middle[1] - wide / 2, wide, wide),
        landmarks=read_only(np.tile(np.array(middle, np.float32), (5, 1))),
        p_BF=(x, y, z),
        covariance=read_only(_SIGMA_M**2 * np.eye(3)),
        range_m=range_m,
        range_sigma_m=_SIGMA_M,
    )


class TrackNumbers:
    """A number for each person who is seen, kept until they were not for ``forget_s``, as FaceDetector's tracks are."""

    def __init__(self, forget_s: float = 1.2) -> None:
        self._forget_s = forget_s
        self._known: dict[str, tuple[int, float]] = {}
        self._last = 0

    def of(self, name: str, stamp: float) -> int:
        """The number of the person ``name``, who is seen at ``stamp`` (s)."""
        number, seen = self._known.get(name, (0, -math.inf))
        if stamp - seen > self._forget_s:
            self._last += 1
            number = self._last
        self._known[name] = number, stamp
        return number
