"""Colours of a torso: what a person wears below the face, as a histogram that distinguishes few persons for a while.

It identifies no one beyond the day, and is kept in memory alone. The torso is where it must be below the face, in
space, so that one rule serves every camera: a fisheye bends what is upright.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from app.messages import Image

#: The patch of the torso: how far below the middle of the face (m), and how far to either side.
_BELOW_M, ASIDE_M = (0.38, 0.62), 0.13
#: ... where legs alone say where it is.
LEGS_ASIDE_M = 0.08
_ROWS, _COLUMNS = 9, 9
#: Least share of the patch inside the image, and on the person where depth is measured.
_LEAST_SHARE = 0.6
#: Depth (m) by which a point may differ from the face's: an arm before the chest, not the wall.
_RELIEF_M = 0.35
_HUES, _VALUES = 12, 5
#: Of a colour with less saturation or value (0 to 255) the hue says nothing.
_LEAST_SATURATION, _LEAST_VALUE = 50, 30

#: Length of a histogram.
BINS = _HUES * 2 + _VALUES


def torso_pixels(image: Image, p_BF: tuple[float, float, float], aside_m: float = ASIDE_M) -> NDArray[np.uint8] | None:
    """Colours (N, 3) uint8 RGB of the torso below the face at ``p_BF`` (m in ``base_link``), ``aside_m`` either side.

    None if too little of it is in the image.
    """
    X_CB = image.X_BC.inverse()
    face = np.array(p_BF)
    towards = face[:2] - image.X_BC.translation[:2]
    length = float(np.hypot(*towards))
    if length < 1e-3:
        return None
    aside = np.array([-towards[1], towards[0], 0.0]) / length
    down = np.linspace(*_BELOW_M, _ROWS)
    across = np.linspace(-aside_m, aside_m, _COLUMNS)
    grid = face + across[None, :, None] * aside - down[:, None, None] * np.array([0.0, 0.0, 1.0])
    points_C = X_CB.transform(grid.reshape(-1, 3))
    pixels = image.camera.project(points_C)
    height, width = image.color.shape[:2]
    with np.errstate(invalid="ignore"):
        inside = (pixels >= -0.5).all(axis=1) & (pixels[:, 0] < width - 0.5) & (pixels[:, 1] < height - 0.5)
    columns, rows = np.rint(pixels[inside]).astype(np.intp).T
    if image.depth is not None:
        depth = image.depth[rows, columns] * 1e-3
        on = (depth == 0) | (np.abs(depth - points_C[inside, 2]) <= _RELIEF_M)
        columns, rows = columns[on], rows[on]
    if columns.size < _LEAST_SHARE * len(pixels):
        return None
    return np.asarray(image.color[rows, columns], np.uint8)


def histogram(colors: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Shares (BINS,) float32, their sum 1, of ``colors`` (N, 3) uint8 RGB, N > 0: hues, pale and full, then greys.

    Each colour counts in two neighbouring bins by its distance to both, so that a little more light changes little.
    """
    hsv = cv2.cvtColor(colors.reshape(1, -1, 3), cv2.COLOR_RGB2HSV)[0].astype(np.float64)
    hue, saturation, value = hsv.T
    colored = (saturation >= _LEAST_SATURATION) & (value >= _LEAST_VALUE)
    bins = np.zeros(BINS)
    full = (saturation[colored] >= 128).astype(np.intp) * _HUES
    at = hue[colored] / 180 * _HUES
    low = np.floor(at).astype(np.intp)
    share = at - low
    np.add.at(bins, full + low % _HUES, 1 - share)
    np.add.at(bins, full + (low + 1) % _HUES, share)
    grey = value[~colored] / 255 * (_VALUES - 1)
    low = np.minimum(np.floor(grey).astype(np.intp), _VALUES - 2)
    share = grey - low
    np.add.at(bins, 2 * _HUES + low, 1 - share)
    np.add.at(bins, 2 * _HUES + low + 1, share)
    return np.asarray(bins / bins.sum(), np.float32)


def distance(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    """Hellinger distance of two histograms, 0 (equal) to 1 (nothing in common)."""
    overlap = float(np.sqrt(a.astype(np.float64) * b.astype(np.float64)).sum())
    return float(np.sqrt(max(0.0, 1.0 - overlap)))
