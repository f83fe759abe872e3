"""A map as a picture: for programs that colour it themselves, and for people."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from app.messages import OccupancyGrid

#: Value of an unknown cell in :func:`values_png`.
UNKNOWN = 255
#: The grey of each of a cell's values, and of those below 0 by their two's complement.
_SHADES = np.full(256, 205, np.uint8)
_SHADES[:101] = np.round(254 - 2.54 * np.arange(101, dtype=np.float32))


def values_png(grid: OccupancyGrid) -> bytes:
    """PNG, 8-bit grey, of the cells' own values: 0 free ... 100 occupied, 255 unknown. Its top row has the
    greatest y.
    """
    return _png(grid.cells.view(np.uint8)[::-1])


def shown_png(grid: OccupancyGrid) -> bytes:
    """PNG, 8-bit grey, as people draw maps: free white, occupied black, unknown grey. Its top row has the greatest
    y.
    """
    return _png(np.asarray(cv2.LUT(grid.cells.view(np.uint8), _SHADES), np.uint8)[::-1])


def _png(pixels: NDArray[np.uint8]) -> bytes:
    done, data = cv2.imencode(".png", np.ascontiguousarray(pixels), [cv2.IMWRITE_PNG_COMPRESSION, 3])
    if not done:
        raise ValueError(f"no picture can be made of {pixels.shape[1]} x {pixels.shape[0]} cells")
    return data.tobytes()
