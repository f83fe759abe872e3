"""What stands out in a picture: contrast, colour and motion, on the grid of the sphere around the head. Pure.

A picture is first reduced and drawn on the grid in odom's axes, as seen from the head, with the camera's own pose. So
the camera's turning moves nothing in it, and two pictures of one camera can be compared cell by cell. Contrast and
colour are differences of centre and surround at two scales (Itti, Koch and Niebur 1998) of intensity and of the two
opponent colours, relative to the brightest component (Walther and Koch 2006). Motion is what a cell has outside the
range of its neighbourhood in the last picture: an edge that is a cell off does not move.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import CameraModel, FisheyeModel, Pose3
from app.modules.perception.saliency.sphere_grid import SphereGrid

Map = NDArray[np.float32]

#: A picture has so many cells across one of the sphere's.
PARTS = 2
#: Standard deviations (cells of the picture) of centre and surround, at two scales.
_SCALES = ((1.0, 4.0), (2.0, 8.0))
#: Differences that count fully.
_FULL_CONTRAST = 0.35
_FULL_COLOR = 0.6
_FULL_MOTION = 0.25
#: Differences (of 1) from the last picture up to this are noise.
_STILL = 0.04
#: Darker than this (of 1), a colour is not known.
_DARK = 0.1
_NEIGHBOURS = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, slots=True)
class MotionRules:
    """When a picture counts. ``turning_radps``: while the camera turns faster, not at all. ``moved_m``: after the
    camera moved further since the last picture, not for motion, for near things seem to move then. ``age_s``: nor
    after a longer time."""

    turning_radps: float = math.radians(20.0)
    moved_m: float = 0.03
    age_s: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class FeatureMaps:
    """``maps`` by feature (rows, columns) in [0, 1] on the sphere's grid, 0 where the picture does not reach."""

    maps: dict[str, Map]


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """A picture on the fine grid: ``color`` (rows, columns, 3) of 1, ``seen`` (rows, columns)."""

    stamp: float
    X_OC: Pose3
    color: Map
    seen: NDArray[np.bool_]


class PictureFeatures:
    """Feature maps of the pictures of one camera."""

    def __init__(self, grid: SphereGrid, range_m: float = 2.5, rules: MotionRules | None = None) -> None:
        self._grid = grid
        self._fine = grid.finer(PARTS)
        self._directions = self._fine.directions()
        self._range_m = range_m
        self._rules = rules or MotionRules()
        self._last: _Drawn | None = None
        self._pose: tuple[float, Pose3] | None = None

    def take(
        self,
        stamp: float,
        color: NDArray[np.uint8],
        camera: CameraModel | FisheyeModel,
        X_OC: Pose3,
        p_OH: NDArray[np.float64],
    ) -> FeatureMaps | None:
        """The features of ``color`` (H, W, 3) uint8 RGB, taken at ``X_OC``, around the head at ``p_OH`` (3,) m. What is
        seen is taken to be ``range_m`` from the head. None for a picture that does not count."""
        before, self._pose = self._pose, (stamp, X_OC)
        if before is not None and _turning(before, stamp, X_OC) > self._rules.turning_radps:
            self._last = None
            return None
        drawn = self._draw(stamp, color, camera, X_OC, p_OH)
        last, self._last = self._last, drawn
        columns = np.flatnonzero(drawn.seen.any(axis=0))
        if len(columns) == 0:
            return FeatureMaps({})
        # The columns that are seen, in one piece: from after the widest gap all around.
        gaps = np.diff(np.append(columns, columns[0] + self._fine.columns))
        columns = np.roll(columns, -1 - int(np.argmax(gaps)))
        picture, seen = drawn.color[:, columns], drawn.seen[:, columns]
        found = _static(picture, seen)
        if last is not None and self._comparable(last, drawn):
            found["motion"] = _motion(last.color[:, columns], picture, last.seen[:, columns] & seen)
        return FeatureMaps({name: self._reduced(values, columns) for name, values in found.items()})

    def _comparable(self, last: _Drawn, drawn: _Drawn) -> bool:
        moved = float(np.linalg.norm(drawn.X_OC.translation - last.X_OC.translation))
        return 0 < drawn.stamp - last.stamp <= self._rules.age_s and moved <= self._rules.moved_m

    def _draw(
        self,
        stamp: float,
        color: NDArray[np.uint8],
        camera: CameraModel | FisheyeModel,
        X_OC: Pose3,
        p_OH: NDArray[np.float64],
    ) -> _Drawn:
        points = self._range_m * self._directions + (p_OH - X_OC.translation)
        pixels = camera.project(points @ X_OC.rotation)
        height, width = color.shape[:2]
        with np.errstate(invalid="ignore"):
            inside = ((pixels >= 0) & (pixels <= np.array([width - 1, height - 1]))).all(axis=-1)
        # Beside the edge of a fisheye's picture its black surround is mixed in.
        seen = cv2.erode(np.asarray(inside, np.uint8), _NEIGHBOURS) > 0
        # Shrunk to the grid's own fineness first: what is finer would flicker.
        shrink = max(1, int(camera.fx * self._fine.step_rad))
        small = color[: height - height % shrink, : width - width % shrink]
        small = cv2.resize(small, (width // shrink, height // shrink), interpolation=cv2.INTER_AREA)  # type: ignore[assignment]
        at = np.where(seen[..., None], (pixels + 0.5) / shrink - 0.5, -10.0).astype(np.float32)
        drawn = cv2.remap(small, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return _Drawn(stamp, X_OC, np.asarray(drawn, np.float32) / np.float32(255), seen)

    def _reduced(self, values: Map, columns: NDArray[np.intp]) -> Map:
        whole = np.zeros((self._fine.rows, self._fine.columns), np.float32)
        whole[:, columns] = values
        size = (self._grid.columns, self._grid.rows)
        return np.asarray(cv2.resize(whole, size, interpolation=cv2.INTER_AREA), np.float32)


def _turning(before: tuple[float, Pose3], stamp: float, X_OC: Pose3) -> float:
    """Speed (rad/s) at which a camera has turned since ``before``."""
    passed = stamp - before[0]
    cosine = (float(np.trace(before[1].rotation.T @ X_OC.rotation)) - 1) / 2
    return math.acos(min(1.0, max(-1.0, cosine))) / passed if passed > 0 else math.inf


def _static(picture: Map, seen: NDArray[np.bool_]) -> dict[str, Map]:
    """Contrast and colour of ``picture`` (rows, columns, 3), of what is ``seen`` (rows, columns)."""
    most = picture.max(axis=-1)
    lit = np.where(most > _DARK, 1.0 / np.maximum(most, _DARK), 0.0)
    red, green, blue = (picture[..., index] for index in range(3))
    opponents = np.stack(((red - green) * lit, (blue - np.minimum(red, green)) * lit, picture.mean(axis=-1)), axis=-1)
    weight = seen.astype(np.float32)
    opponents = (opponents * weight[..., None]).astype(np.float32)
    off = np.zeros_like(opponents)
    for centre, surround in _SCALES:
        off = np.maximum(off, np.abs(_mean(opponents, weight, centre) - _mean(opponents, weight, surround)))
    color = np.asarray(np.hypot(off[..., 0], off[..., 1]) / _FULL_COLOR, np.float32)
    return {
        "contrast": _standing_out(np.asarray(off[..., 2] / _FULL_CONTRAST, np.float32), seen),
        "color": _standing_out(color, seen),
    }


def _mean(values: Map, weight: Map, sigma: float) -> Map:
    """Gaussian means of what is seen alone, so that the edge of the picture is none."""
    total = cv2.GaussianBlur(weight, (0, 0), sigma)
    return np.asarray(cv2.GaussianBlur(values, (0, 0), sigma) / np.maximum(total, 1e-6)[..., None], np.float32)


def _motion(last: Map, picture: Map, seen: NDArray[np.bool_]) -> Map:
    over = picture - cv2.dilate(last, _NEIGHBOURS)
    under = cv2.erode(last, _NEIGHBOURS) - picture
    off = np.maximum(over, under).max(axis=-1)
    inner = cv2.erode(seen.astype(np.uint8), _NEIGHBOURS, borderType=cv2.BORDER_CONSTANT, borderValue=0) > 0
    return _standing_out((off - _STILL) / _FULL_MOTION, inner)


def _standing_out(values: Map, seen: NDArray[np.bool_]) -> Map:
    """``values`` in [0, 1], weighted by how little there is of them elsewhere: Itti's normalization of maps, with the
    mean of all cells for that of the maxima. Where everything moves, nothing stands out."""
    clipped = np.where(seen, np.clip(values, 0.0, 1.0), 0.0)
    most = float(clipped.max())
    if most <= 0.0:
        return clipped.astype(np.float32)
    rarity = (1.0 - float(clipped[seen].mean()) / most) ** 2
    return (rarity * clipped).astype(np.float32)
