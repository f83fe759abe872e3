"""PanoramaStream: the panoramic camera's picture unrolled for people.

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ PanoramaStream    in   images    Image of a fisheye, 10 Hz / φ                           │
    │                   out  pictures  EncodedImage, JPEG, with each image taken               │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

The picture is equirectangular in the axes of ``base_link``, seen from the camera: its ``width`` px are the half circle
in front, the left edge at azimuth +90°, the right one at -90°; every pixel spans the same angle upwards, and the middle
row is level. A direction of azimuth a and elevation e (rad) is found at x = width (1/2 - a / π) and y = height / 2 -
width e / π, edges counted, not middles of pixels. With 640 x 384 px it reaches 54° up and down. Directions outside the
lens's field of view are black. ``jpeg_quality`` is a parameter of the desire Telepresence.
"""

from __future__ import annotations

import math
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from app.base.geometry import CameraModel, FisheyeModel, Pose3
from app.messages import Image
from app.modules.perception.camera_stream import CameraStream, CameraStreamSettings, encode_jpeg
from app.runtime.module import ModuleContext


def directions(width: int, height: int) -> NDArray[np.float64]:
    """Unit vectors (height, width, 3) in ``base_link``'s axes of the panorama's pixels."""
    azimuth = math.pi * (0.5 - (np.arange(width) + 0.5) / width)
    elevation = math.pi / width * (0.5 * height - (np.arange(height) + 0.5))
    level = np.cos(elevation)[:, None]
    up = np.broadcast_to(np.sin(elevation)[:, None], (height, width))
    return np.stack((level * np.cos(azimuth), level * np.sin(azimuth), up), axis=-1)


class PanoramaProjection:
    """Computes panoramas of ``width`` x ``height`` (px) from one camera's images.

    The remapping table is kept until the camera has turned by half a pixel: encoders' noise turns it a little with
    every image, and a table costs more than the image. What it is made of is computed for the first image: few programs
    are looked at.
    """

    def __init__(self, width: int, height: int) -> None:
        self._size = width, height
        self._turned_rad = 0.5 * math.pi / width
        self._of: tuple[CameraModel | FisheyeModel, Pose3] | None = None
        self._maps: tuple[NDArray[np.int16], NDArray[np.uint16]]

    def unroll(self, color: NDArray[np.uint8], camera: CameraModel | FisheyeModel, X_BC: Pose3) -> NDArray[np.uint8]:
        """The panorama (height, width, 3) uint8 of ``color`` (H, W, 3), seen through ``camera`` at ``X_BC``."""
        if self._of is None or self._of[0] != camera or self._turned(self._of[1], X_BC):
            pixels = camera.project(self._directions @ X_BC.rotation)
            at = np.where(np.isnan(pixels), -10.0, pixels).astype(np.float32)
            first, second = cv2.convertMaps(at[..., 0], at[..., 1], cv2.CV_16SC2)
            self._maps = np.asarray(first, np.int16), np.asarray(second, np.uint16)
            self._of = camera, X_BC
        return np.asarray(cv2.remap(color, *self._maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT), np.uint8)

    @cached_property
    def _directions(self) -> NDArray[np.float64]:
        return directions(*self._size)

    def _turned(self, a: Pose3, b: Pose3) -> bool:
        return bool(np.abs(a.rotation - b.rotation).max() > self._turned_rad)


class PanoramaStreamSettings(CameraStreamSettings):
    width: int = Field(640, ge=64, le=4096, description="px of the half circle")
    height: int = Field(384, ge=16, le=4096, description="px; the middle row is level")


class PanoramaStream(CameraStream):
    """Unrolls and encodes the panoramic camera's images while a subscription is open."""

    title = "Panorama"
    Settings = PanoramaStreamSettings
    settings: PanoramaStreamSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._unroller = PanoramaProjection(self.settings.width, self.settings.height)

    def picture(self, image: Image, quality: int) -> tuple[bytes, int, int]:
        """The panorama of ``image``, as a JPEG."""
        return encode_jpeg(self._unroller.unroll(image.color, image.camera, image.X_BC), quality)
