"""CameraStream: the camera's picture for people (thesis 3.4).

    ┌─────────────────────────────────────────────────────────────────────────────────────────┐
    │ CameraStream    in   images    Image, 15 Hz / φ                                          │
    │                 out  pictures  EncodedImage, JPEG, with each image taken                 │
    └─────────────────────────────────────────────────────────────────────────────────────────┘

Computes the JPEG of the colour image (ITU-T T.81), reduced to ``width`` first where that is smaller than the image.
``jpeg_quality`` is a parameter of the desire Telepresence.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from app.messages import EncodedImage, Image
from app.modules.perception.opencv import use_calling_thread
from app.modules.perception.telepresence import TELEPRESENCE
from app.runtime.module import Module, ModuleContext, Settings


def encode_jpeg(color: NDArray[np.uint8], quality: int, width: int | None = None) -> tuple[bytes, int, int]:
    """JPEG of ``color`` (H, W, 3) uint8 RGB with its width and height (px), reduced to ``width`` if that is smaller.

    ``quality`` is 1 to 100.
    """
    height, full_width = color.shape[:2]
    picture = cv2.cvtColor(color, cv2.COLOR_RGB2BGR)
    if width is not None and width < full_width:
        size = (width, max(1, round(height * width / full_width)))
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    _, encoded = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
    return encoded.tobytes(), picture.shape[1], picture.shape[0]


class CameraStreamSettings(Settings):
    jpeg_quality: int = Field(80, ge=1, le=100, description="used while no desire says another")
    width: int | None = Field(None, ge=16, description="widest picture (px); none: as the camera gives it")


class CameraStream(Module):
    title = "Camera picture"
    desire_classes = (TELEPRESENCE,)
    Settings = CameraStreamSettings
    settings: CameraStreamSettings

    def __init__(self, context: ModuleContext) -> None:
        super().__init__(context)
        self._quality = self.settings.jpeg_quality
        self.images = self.input("images", Image)
        self.pictures = self.output("pictures", EncodedImage)
        self.on(self.images, self._encode)

    async def start(self) -> None:
        """Keep OpenCV's work in the module's thread, where its CPU time is measured."""
        use_calling_thread()

    def configure(self, parameters: Mapping[str, Any]) -> None:
        self._quality = int(parameters.get("jpeg_quality", self.settings.jpeg_quality))

    async def _encode(self, image: Image) -> None:
        jpeg, width, height = await self.compute(self.picture, image, self._quality)
        self.pictures.publish(
            EncodedImage(image.stamp, image.frame, jpeg=jpeg, width=width, height=height, X_BC=image.X_BC)
        )

    def picture(self, image: Image, quality: int) -> tuple[bytes, int, int]:
        """The published picture of ``image``, as of :func:`encode_jpeg`; runs in the module's own thread."""
        return encode_jpeg(image.color, quality, self.settings.width)
