"""A fisheye image unrolled, so that faces stand upright in it and are as wide as they look from everywhere.

Near the rim of a fisheye faces lie on their sides and are squeezed, and a detector trained on photographs misses them.
The strip is an equirectangular picture about the vertical through the camera: azimuth across, elevation down, both at
the same pixels per radian, so a face keeps its shape wherever it is; and it shows only elevations where faces can be.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import FisheyeModel

#: Faces are looked for whose middle is between these heights (m): somebody who sits, and one as tall as 1.96 m.
_LOWEST_M, _HIGHEST_M = 1.05, 1.80
#: ... from so far away on (m); half of a face's box is so high (m).
_NEAREST_M, _HALF_FACE_M = 0.9, 0.14

#: The vertical may tilt so far in the camera (rad) before the strip is made anew: faces turn no further than that.
_TILT = math.radians(1.0)


@dataclass(frozen=True, slots=True)
class StripView:
    """What a strip shows: angles in rad, azimuth 0 ahead of the camera, positive to the left, elevation upwards."""

    pixels_per_rad: float
    azimuth: float = math.radians(90)
    lowest: float = math.radians(-15)
    highest: float = math.radians(50)

    @staticmethod
    def of_people(height_m: float, pixels_per_rad: float) -> StripView:
        """All around, as far up and down as people's faces can be for a camera ``height_m`` above the floor."""
        down, up = _LOWEST_M - _HALF_FACE_M - height_m, _HIGHEST_M + _HALF_FACE_M - height_m
        # Faces below the camera go down the nearer they are, faces above it go up; the others near the horizon.
        lowest, highest = min(0.0, math.atan2(down, _NEAREST_M)), max(0.0, math.atan2(up, _NEAREST_M))
        return StripView(pixels_per_rad, lowest=lowest, highest=highest)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, px."""
        width = math.ceil(2 * self.azimuth * self.pixels_per_rad)
        return width, math.ceil((self.highest - self.lowest) * self.pixels_per_rad)


class Strip:
    """A strip of one camera, held one way.

    ``up_C`` (3,) is the vertical, upwards, in the camera's optical frame; ``view`` what to show.
    """

    def __init__(self, camera: FisheyeModel, up_C: NDArray[np.float64], view: StripView) -> None:
        self.camera = camera
        self.view = view
        self._up = up_C / np.linalg.norm(up_C)
        ahead = np.array((0.0, 0.0, 1.0)) - self._up[2] * self._up
        if np.linalg.norm(ahead) < 1e-3:
            # The camera looks straight up or down: where its image has its top is as good as any ahead.
            ahead = np.array((0.0, -1.0, 0.0)) + self._up[1] * self._up
        ahead = ahead / np.linalg.norm(ahead)
        self._R_CL = np.stack((ahead, np.cross(self._up, ahead), self._up), axis=1)
        width, height = view.size
        pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1)
        places = camera.project(self.rays(pixels)).astype(np.float32)
        # What no pixel shows is black: outside the image for `remap`.
        places = np.where(np.isnan(places), np.float32(-2), places)
        # In fixed point, with the fractions apart: twice as quick as in floats.
        self._map, self._fractions = cv2.convertMaps(places[..., 0], places[..., 1], cv2.CV_16SC2)

    def fits(self, camera: FisheyeModel, up_C: NDArray[np.float64]) -> bool:
        """Whether this is the strip of that camera, held that way."""
        return camera == self.camera and float(self._up @ up_C) >= math.cos(_TILT) * float(np.linalg.norm(up_C))

    def unroll(self, color: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The strip (h, w, 3) uint8 of the camera's image ``color`` (H, W, 3) uint8."""
        strip = cv2.remap(color, self._map, self._fractions, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return np.asarray(strip, np.uint8)

    def rays(self, pixels: NDArray[np.floating] | NDArray[np.integer]) -> NDArray[np.float64]:
        """Unit vectors (..., 3) in the camera's optical frame along which the strip's ``pixels`` (..., 2) look."""
        azimuth = self.view.azimuth - (np.asarray(pixels[..., 0], np.float64) + 0.5) / self.view.pixels_per_rad
        elevation = self.view.highest - (np.asarray(pixels[..., 1], np.float64) + 0.5) / self.view.pixels_per_rad
        flat = np.cos(elevation)
        rays = np.stack((flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)), axis=-1)
        return np.asarray(rays @ self._R_CL.T)
