"""Position of a detected face: by depth where the camera has it, else by the distribution of people's heights.

The direction of a face is accurate and, without depth, its distance is not: the covariance is short across the ray and
long along it::

    Σ = σ_r² d dᵀ + (r σ_a)² (I - d dᵀ)        d: the ray, r: the range, σ_a: standard deviation of the direction (rad)
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import FisheyeModel, Pose3
from app.messages import Image
from app.modules.perception.faces.panorama import Strip, StripView
from app.modules.perception.faces.yunet import Detection, YuNetDetector
from app.modules.perception.height_prior import STANDING, HeightPrior, range_from_height

Vector = NDArray[np.float64]

#: Central share of the face's box whose depths are used.
_INNER = 0.5
#: Least number of valid depths there, and least share.
_FEWEST, _SMALLEST_SHARE = 6, 0.3
#: Depths further than this (m) from the median are hair, a hand, or background.
_RELIEF_M = 0.12
#: Error of the middle of a face as a share of the box's width (1 sigma); at least half a pixel.
_MIDDLE = 0.04
#: Error of the depths' median by the shape of faces (m, 1 sigma).
_SHAPE_M = 0.01
#: Noise of one Kinect depth z: _FLOOR_M + _SLOPE (z - 0.4 m)² (Nguyen, Izadi and Lovell 2012). It is not divided by the
#: number of pixels: errors of neighbours are correlated.
_FLOOR_M, _SLOPE = 0.0012, 0.0019


@dataclass(frozen=True, slots=True, eq=False)
class FaceSighting:
    """One face in one image, placed in ``base_link`` at its stamp.

    ``origin`` (3,) m: the camera; ``ray`` (3,): unit vector through the middle of the face; ``range_m`` along it with
    ``range_sigma_m``; ``measured``: whether by depth, else by people's heights; ``angle_sigma`` (rad): standard
    deviation of the ray; ``size_rad``: geometric mean of the angles under which the box's width and height are seen,
    NaN where that is not known.
    """

    face: Detection
    origin: Vector
    ray: Vector
    angle_sigma: float
    range_m: float
    range_sigma_m: float
    measured: bool
    size_rad: float = math.nan

    @property
    def p_BF(self) -> Vector:
        """The middle of the face (3,) m in ``base_link``."""
        return self.origin + self.range_m * self.ray

    @property
    def covariance(self) -> Vector:
        """Covariance (3, 3) m² of :attr:`p_BF`."""
        return ray_covariance(self.ray, self.range_sigma_m, self.range_m * self.angle_sigma)


def ray_covariance(ray: Vector, along_m: float, across_m: float) -> Vector:
    """Covariance (3, 3) m² with deviations ``along_m`` and ``across_m`` the unit vector ``ray`` (3,)."""
    outer = np.outer(ray, ray)
    return np.asarray(along_m**2 * outer + across_m**2 * (np.eye(3) - outer))


def middle(landmarks: NDArray[np.float32]) -> Vector:
    """The middle of the face (2,) px: midway between the eyes' middle and the mouth's."""
    return np.asarray(landmarks[[0, 1, 3, 4]].mean(axis=0), np.float64)


class FaceLocator:
    """Detects and places the faces of one camera after another; caches what is costly to compute.

    Used by one thread at a time.
    """

    def __init__(self, threshold: float, people: HeightPrior = STANDING) -> None:
        self.finder = YuNetDetector(threshold)
        self._people = people
        self._strips: dict[str, Strip] = {}

    def look(self, image: Image, longest: int | None, px_per_rad: float) -> list[FaceSighting]:
        """Every face of ``image``, placed.

        Images of a pinhole camera are reduced to ``longest`` px on their longer side (None: not reduced); those of a
        fisheye are unrolled to ``px_per_rad``.
        """
        if isinstance(image.camera, FisheyeModel):
            return self._find_on_panorama(image, image.camera, px_per_rad)
        camera = image.camera
        sightings = []
        for face in self.finder.find(image.color, longest):
            at = middle(face.landmarks)
            sigma = max(0.5, _MIDDLE * face.box[2]) / camera.fx
            depth = None if image.depth is None else face_depth(face.box, image.depth)
            ray_C = np.asarray(camera.rays(at), np.float64)
            placed = self._placed(face, ray_C, sigma, depth, image.X_BC)
            sightings.append(replace(placed, size_rad=apparent_size(face.box, camera.rays)))
        return sightings

    def _find_on_panorama(self, image: Image, camera: FisheyeModel, px_per_rad: float) -> list[FaceSighting]:
        up_C = np.asarray(image.X_BC.rotation[2], np.float64)
        # To the nearest decimetre: small motions of the torso need no new strip.
        view = StripView.of_people(round(float(image.X_BC.translation[2]), 1), px_per_rad)
        strip = self._strips.get(image.frame)
        if strip is None or strip.view != view or not strip.fits(camera, up_C):
            strip = self._strips[image.frame] = Strip(camera, up_C, view)
        sightings = []
        for face in self.finder.find(strip.unroll(image.color)):
            ray_C = strip.rays(middle(face.landmarks))
            sigma = max(0.5, _MIDDLE * face.box[2]) / px_per_rad
            seen = in_image(face, strip)
            if seen is not None:
                placed = self._placed(seen, ray_C, sigma, None, image.X_BC)
                sightings.append(replace(placed, size_rad=apparent_size(face.box, strip.rays)))
        return sightings

    def _placed(self, face: Detection, ray_C: Vector, sigma: float, depth: float | None, X_BC: Pose3) -> FaceSighting:
        ray = X_BC.rotation @ ray_C
        origin = X_BC.translation
        if depth is None:
            direction, height = tuple(ray.tolist()), float(origin[2])
            range_m, range_sigma_m = range_from_height(
                direction, height, "face", elevation_sigma=sigma, people=self._people
            )
        else:
            # Depth is measured along the optical axis, range along the ray.
            stretch = 1 / float(ray_C[2])
            range_m = depth * stretch
            range_sigma_m = stretch * math.hypot(_SHAPE_M, _FLOOR_M + _SLOPE * (depth - 0.4) ** 2)
        return FaceSighting(
            face,
            origin,
            ray=ray,
            angle_sigma=sigma,
            range_m=range_m,
            range_sigma_m=range_sigma_m,
            measured=depth is not None,
        )


def apparent_size(box: tuple[float, float, float, float], rays: Callable[[Vector], NDArray[np.floating]]) -> float:
    """Angle (rad) under which a face is seen: the geometric mean of those of its ``box``'s width and height.

    ``rays``: unit vectors (..., 3) along which pixels (..., 2) look. NaN where the box reaches beyond them.
    """
    left, top, width, height = box
    x, y = left + 0.5 * width - 0.5, top + 0.5 * height - 0.5
    ends = np.array([[(left - 0.5, y), (left + width - 0.5, y)], [(x, top - 0.5), (x, top + height - 0.5)]])
    a, b = np.moveaxis(np.asarray(rays(ends), np.float64), 1, 0)
    angles = np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(axis=-1))
    return float(np.sqrt(angles.prod()))


def face_depth(box: tuple[float, float, float, float], depth: NDArray[np.uint16]) -> float | None:
    """Depth (m) of the face in ``box`` (left, top, width, height, px), None where too little of it was measured.

    ``depth`` (H, W) uint16 mm, 0 = none. The median of the depths in the middle of the box, then of those near it: the
    box's border shows the background.
    """
    left, top, width, height = box
    rows = _inner(top, height, depth.shape[0])
    columns = _inner(left, width, depth.shape[1])
    inner = depth[rows, columns]
    valid = inner[inner > 0].astype(np.float64) * 1e-3
    if valid.size < max(_FEWEST, _SMALLEST_SHARE * inner.size):
        return None
    near = valid[np.abs(valid - np.median(valid)) <= _RELIEF_M]
    return float(np.median(near)) if near.size else None


def _inner(begin: float, length: float, size: int) -> slice:
    rim = 0.5 * (1 - _INNER) * length
    return slice(max(0, round(begin + rim)), min(size, max(0, round(begin + length - rim))))


def in_image(face: Detection, strip: Strip) -> Detection | None:
    """A face found in a strip, in pixels of the camera's image; None if its middle is outside.

    The box is the smallest upright one about the face's outline, which the fisheye bends.
    """
    left, top, width, height = face.box
    steps = np.linspace(0, 1, 5)
    outline = np.concatenate(
        [np.stack((left + width * steps, np.full(5, top + edge * height)), axis=-1) for edge in (0.0, 1.0)]
        + [np.stack((np.full(5, left + edge * width), top + height * steps), axis=-1) for edge in (0.0, 1.0)]
    )
    camera = strip.camera
    seen = camera.project(strip.rays(outline - 0.5)) + 0.5
    landmarks = camera.project(strip.rays(face.landmarks))
    seen = seen[~np.isnan(seen[:, 0])]
    if np.isnan(landmarks).any() or len(seen) < 3:
        return None
    (u0, v0), (u1, v1) = seen.min(axis=0).tolist(), seen.max(axis=0).tolist()
    return Detection(face.score, (u0, v0, u1 - u0, v1 - v0), landmarks.astype(np.float32))
