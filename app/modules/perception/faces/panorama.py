"""A fisheye image unrolled into a strip in which faces are upright and undistorted.

Near the rim of a fisheye faces are rotated and compressed, and a detector trained on photographs misses them.
The strip is an equirectangular picture about the vertical through the camera: azimuth across, elevation down, both at
the same pixels per radian, so a face has the same shape everywhere; it covers only the elevations of faces.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import FisheyeModel

#: Heights (m) of the middle of a face: a sitting person's, and that of a person 1.96 m tall.
_LOWEST_M, _HIGHEST_M = 1.05, 1.80
#: ... at this least distance (m); half the height (m) of a face's box.
_NEAREST_M, _HALF_FACE_M = 0.9, 0.14

#: Tilt of the vertical in the camera (rad) from which the strip is computed again.
_TILT = math.radians(1.0)


@dataclass(frozen=True, slots=True)
class StripView:
    """Field of view of a strip: angles in rad, azimuth 0 ahead of the camera, positive left, elevation upwards."""

    pixels_per_rad: float
    azimuth: float = math.radians(90)
    lowest: float = math.radians(-15)
    highest: float = math.radians(50)

    @staticmethod
    def of_people(height_m: float, pixels_per_rad: float) -> StripView:
        """All azimuths, and the elevations of people's faces for a camera ``height_m`` above the floor."""
        down, up = _LOWEST_M - _HALF_FACE_M - height_m, _HIGHEST_M + _HALF_FACE_M - height_m
        # Near faces below the camera are low and those above it high; far ones are near the horizon.
        lowest, highest = min(0.0, math.atan2(down, _NEAREST_M)), max(0.0, math.atan2(up, _NEAREST_M))
        return StripView(pixels_per_rad, lowest=lowest, highest=highest)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        width = math.ceil(2 * self.azimuth * self.pixels_per_rad)
        return width, math.ceil((self.highest - self.lowest) * self.pixels_per_rad)


class Strip:
    """A strip of one camera in one orientation.

    ``up_C`` (3,): the vertical, upwards, in the camera's optical frame; ``view``: the field of view.
    """

    def __init__(self, camera: FisheyeModel, up_C: NDArray[np.float64], view: StripView) -> None:
        self.camera = camera
        self.view = view
        self._up = up_C / np.linalg.norm(up_C)
        ahead = np.array((0.0, 0.0, 1.0)) - self._up[2] * self._up
        if np.linalg.norm(ahead) < 1e-3:
            # The camera looks straight up or down: the top of its image serves as ahead.
            ahead = np.array((0.0, -1.0, 0.0)) + self._up[1] * self._up
        ahead = ahead / np.linalg.norm(ahead)
        self._R_CL = np.stack((ahead, np.cross(self._up, ahead), self._up), axis=1)
        width, height = view.size
        pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
        places = camera.project(self.rays(pixels)).astype(np.float32)
        # Directions outside the image are black: coordinates outside it for `remap`.
        places = np.where(np.isnan(places), np.float32(-2), places)
        # In fixed point with separate fractions: twice as fast as floats.
        self._map, self._fractions = cv2.convertMaps(places[..., 0], places[..., 1], cv2.CV_16SC2)

    def fits(self, camera: FisheyeModel, up_C: NDArray[np.float64]) -> bool:
        """Whether this strip is for that camera in that orientation."""
        return camera == self.camera and float(self._up @ up_C) >= math.cos(_TILT) * float(np.linalg.norm(up_C))

    def unroll(self, color: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The strip (h, w, 3) uint8 of the camera's image ``color`` (H, W, 3) uint8."""
        strip = cv2.remap(color, self._map, self._fractions, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return np.asarray(strip, np.uint8)

    def rays(self, pixels: NDArray[np.floating] | NDArray[np.integer]) -> NDArray[np.float64]:
        """Unit vectors (..., 3) in the camera's optical frame of the strip's ``pixels`` (..., 2)."""
        azimuth = self.view.azimuth - (np.asarray(pixels[..., 0], np.float64) + 0.5) / self.view.pixels_per_rad
        elevation = self.view.highest - (np.asarray(pixels[..., 1], np.float64) + 0.5) / self.view.pixels_per_rad
        flat = np.cos(elevation)
        rays = np.stack((flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)), axis=-1)
        return np.asarray(rays @ self._R_CL.T)
