"""Sensor model of the Kinect: disparity noise, quantisation, shadows, holes, range. Pure on arrays.

The sensor measures disparity, proportional to u = 1/z; everything here happens in u.
- Axial noise sigma_z = s0 + s1 (z - 0.4)^2 (Nguyen, Izadi and Lovell, 3DIMPVT 2012), in disparity a parabola in u.
- Quantisation: steps of ``quantum_m`` in u, so that depth steps grow with z^2 (Khoshelham and Elberink, Sensors 2012).
- Shadow: the projector is ``baseline_m`` beside the camera; unlit pixels have no depth. A pixel in column x is lit from
  the column x - f B u; it is in shadow if some pixel to its right is lit from further left.
- Edges: pixels at a jump in depth mostly have no depth.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from app.base.geometry import CameraModel
from app.robots.simulated.color_noise import SPARE, ColorNoise
from app.robots.stream_config import KinectConfig

_LEVELS = 1024
_EDGE_JUMP = 0.05
_EDGE_KEEP = 0.6
_BAND_PX = 60
"""Rows computed at a time, so that what is in between stays in the processor's cache."""


def camera_model(config: KinectConfig) -> CameraModel:
    """The pinhole camera of the configured fields of view (57 x 43 degrees: pixels 3 % from square)."""
    horizontal, vertical = (math.radians(angle) for angle in config.fov_deg)
    fx = 0.5 * config.width / math.tan(0.5 * horizontal)
    fy = 0.5 * config.height / math.tan(0.5 * vertical)
    return CameraModel(
        config.width, config.height, fx=fx, fy=fy, cx=0.5 * (config.width - 1), cy=0.5 * (config.height - 1)
    )


class KinectNoise:
    """Turns true images into measured ones. The same seed gives the same noise, image by image."""

    def __init__(self, config: KinectConfig, rng: Generator) -> None:
        self._config = config
        self._rng = rng
        shape = (config.height + SPARE, config.width + SPARE)
        # Drawing fresh noise for every picture would cost more than drawing the picture: windows of a bank instead
        bank = cv2.GaussianBlur(rng.standard_normal(shape).astype(np.float32), (3, 3), 0.6)
        self._depth_bank = np.asarray(bank / bank.std(), dtype=np.float32)
        self._color = ColorNoise(config.height, config.width, config.color_noise, rng)
        levels = np.arange(_LEVELS)
        with np.errstate(divide="ignore"):
            depth_m = 1.0 / (levels * config.quantum_m)
        seen = (depth_m >= config.range_min_m) & (depth_m <= config.range_max_m)
        self._millimetres = np.where(seen, np.rint(1000.0 * np.where(seen, depth_m, 0.0)), 0).astype(np.uint16)
        focal = camera_model(config).fx
        self._columns = np.arange(0, config.width, 2, dtype=np.float32)
        self._shift_px_m = np.float32(focal * config.baseline_m)

    def depth(self, inverse_depth: NDArray[np.float32], out: NDArray[np.uint16]) -> None:
        """Measure ``inverse_depth`` (H, W) float32 in 1/m (row 0 on top) into ``out`` (H, W) uint16 mm, 0 = nothing."""
        u, noise = inverse_depth, self._window(self._depth_bank)
        jump = cv2.morphologyEx(u, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
        hidden = self._shadow(u)
        for top in range(0, len(u), _BAND_PX):
            band = slice(top, top + _BAND_PX)
            self._quantize(u[band], noise[band], out[band])
            holes = jump[band] > _EDGE_JUMP * u[band]
            holes &= noise[band] > -_EDGE_KEEP
            holes |= hidden[band]
            np.copyto(out[band], 0, where=holes)

    def _quantize(self, u: NDArray[np.float32], noise: NDArray[np.float32], out: NDArray[np.uint16]) -> None:
        c = self._config
        # sigma in steps of disparity: (s0 + s1 (z - 0.4)^2) u^2 / quantum
        sigma = u * np.float32(c.noise_floor_m + 0.16 * c.noise_slope)
        sigma -= np.float32(0.8 * c.noise_slope)
        sigma *= u
        sigma += np.float32(c.noise_slope)
        sigma *= noise
        sigma += u
        sigma *= np.float32(1.0 / c.quantum_m)
        np.rint(sigma, out=sigma)
        np.take(self._millimetres, sigma.astype(np.intp), out=out, mode="clip")

    def color(self, picture: NDArray[np.uint8], out: NDArray[np.uint8]) -> None:
        """Add the colour camera's noise to ``picture`` (H, W, 3) uint8 RGB, into ``out``."""
        self._color.add(picture, out)

    def _window(self, bank: NDArray[np.float32]) -> NDArray[np.float32]:
        top, left = (int(i) for i in self._rng.integers(0, SPARE, 2))
        return bank[top : top + self._config.height, left : left + self._config.width]

    def _shadow(self, u: NDArray[np.float32]) -> NDArray[np.bool_]:
        lit_from = self._columns - self._shift_px_m * u[::2, ::2]
        leftmost = np.minimum.accumulate(lit_from[:, ::-1], axis=1)[:, ::-1]
        hidden = (lit_from > leftmost + 1.0).astype(np.uint8)
        size = (self._config.width, self._config.height)
        return cv2.resize(hidden, size, interpolation=cv2.INTER_NEAREST).view(np.bool_)
