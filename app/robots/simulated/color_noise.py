"""The noise of a colour camera: Gaussian, the same on each channel, new with every picture."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

SPARE = 96
"""How far a window into a bank of noise can be moved, each way (px)."""


class ColorNoise:
    """Adds noise of ``sigma`` grey levels to pictures of ``height`` x ``width``. The same seed gives the same noise."""

    def __init__(self, height: int, width: int, sigma: float, rng: Generator) -> None:
        self._height, self._width = height, width
        self._rng = rng
        # Drawing fresh noise for every picture would cost more than drawing the picture: windows of a bank instead
        noise = sigma * rng.standard_normal((height + SPARE, width + SPARE, 3)).astype(np.float32)
        self._brighter = np.clip(np.rint(noise), 0, 255).astype(np.uint8)
        self._darker = np.clip(np.rint(-noise), 0, 255).astype(np.uint8)

    def add(self, picture: NDArray[np.uint8], out: NDArray[np.uint8], where: NDArray[np.uint8] | None = None) -> None:
        """``picture`` (H, W, 3) uint8 RGB with noise into ``out``; the bits that ``where`` (H, W, 3) has, if it is
        given."""
        top, left = (int(i) for i in self._rng.integers(0, SPARE, 2))
        window = (slice(top, top + self._height), slice(left, left + self._width))
        cv2.add(picture, self._brighter[window], dst=out)
        cv2.subtract(out, self._darker[window], dst=out)
        if where is not None:  # sooner than masks of the two
            cv2.bitwise_and(out, where, dst=out)
