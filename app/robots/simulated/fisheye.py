"""Fisheye images from perspective ones: the hemisphere tiled by views, and the pixel maps into them.

The views are the faces of a cube about the camera: the whole one in front and the halves beside, above and below it.
That takes the fewest pixels of all tilings by five views; OpenGL cannot draw a hemisphere in one. Towards their edges
perspective views are up to twice as fine as the fisheye, so the outer ones can be coarser than its middle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import FisheyeModel
from app.robots.simulated.renderer import PerspectiveView

_MARGIN_PX = 2.0
"""Drawn beyond what is shown, so that interpolation at a view's edge finds the same on both sides."""


@dataclass(frozen=True, slots=True)
class _Face:
    """One face of the cube in the camera's axes (right, up, backwards), and its pixels per pixel of the fisheye."""

    right: tuple[int, int, int]
    up: tuple[int, int, int]
    detail: float


_FACES = (
    _Face((1, 0, 0), (0, 1, 0), 1.15),
    _Face((0, 0, -1), (0, 1, 0), 1.0),
    _Face((0, 0, 1), (0, 1, 0), 1.0),
    _Face((-1, 0, 0), (0, 0, -1), 0.65),
    _Face((1, 0, 0), (0, 0, -1), 0.65),
)
"""In front, to the left, to the right, above, below: people and posters are at the sides, seldom over or under them."""


@dataclass(frozen=True, slots=True, eq=False)
class Tile:
    """One view of a fisheye, and the column and row (px) of its lower left pixel in the picture of all of them."""

    view: PerspectiveView
    x: int
    y: int


@dataclass(frozen=True, slots=True, eq=False)
class Tiling:
    """The views of a fisheye, side by side in one picture of ``width`` x ``height`` (px) with row 0 at the bottom.

    ``first`` (H, W, 2) int16 and ``second`` (H, W) uint16 are OpenCV's fixed-point maps from the fisheye's pixels into
    that picture. ``seen`` (H, W, 3) uint8 is 255 where the lens has a picture.
    """

    tiles: tuple[Tile, ...]
    width: int
    height: int
    first: NDArray[np.int16]
    second: NDArray[np.uint16]
    seen: NDArray[np.uint8]

    def picture(self, drawn: NDArray[np.uint8], out: NDArray[np.uint8]) -> None:
        """The fisheye's picture ``out`` (H, W, 3) of the views ``drawn`` (height, width, 3); black outside the lens."""
        cv2.remap(drawn, self.first, self.second, cv2.INTER_LINEAR, dst=out, borderMode=cv2.BORDER_CONSTANT)


def tile(lens: FisheyeModel, detail: float = 1.0) -> Tiling:
    """The views that cover ``lens``.

    ``detail`` scales their resolution; 1 is the fisheye's own in its middle.
    """
    columns, rows = np.meshgrid(np.arange(lens.width, dtype=np.float64), np.arange(lens.height, dtype=np.float64))
    rays = lens.rays(np.stack((columns, rows), axis=-1)) * (1.0, -1.0, -1.0)  # right, up, backwards
    seen = ~np.isnan(rays[..., 0])
    axes = [np.column_stack((face.right, face.up, np.cross(face.right, face.up))).astype(np.float64) for face in _FACES]
    ahead = np.stack([-(rays @ a[:, 2]) for a in axes])
    owner = np.where(seen, np.argmax(np.where(seen, ahead, 0.0), axis=0), -1)
    maps = np.full((2, lens.height, lens.width), -1000.0, np.float32)
    packer = _Packer()
    tiles = []
    for number, (face, rotation) in enumerate(zip(_FACES, axes, strict=True)):
        own = owner == number
        if not own.any():  # a narrow lens
            continue
        points = rays[own] @ rotation
        x, y = -points[:, 0] / points[:, 2], -points[:, 1] / points[:, 2]
        per_x, per_y = detail * face.detail * lens.fx, detail * face.detail * lens.fy
        left, right = _extent(x, per_x)
        bottom, top = _extent(y, per_y)
        width, height = math.ceil((right - left) * per_x), math.ceil((top - bottom) * per_y)
        view = PerspectiveView(rotation, left, right=right, bottom=bottom, top=top, width=width, height=height)
        column, row = packer.place(width, height)
        tiles.append(Tile(view, column, row))
        maps[0][own] = column + (x - left) / (right - left) * width - 0.5
        maps[1][own] = row + (y - bottom) / (top - bottom) * height - 0.5
    first, second = cv2.convertMaps(maps[0], maps[1], cv2.CV_16SC2)
    return Tiling(
        tiles=tuple(tiles),
        width=packer.width,
        height=packer.top,
        first=np.asarray(first, np.int16),
        second=np.asarray(second, np.uint16),
        seen=np.repeat(np.where(seen, 255, 0).astype(np.uint8)[..., None], 3, axis=2),
    )


def _extent(tangents: NDArray[np.float64], per_unit: float) -> tuple[float, float]:
    return float(tangents.min()) - _MARGIN_PX / per_unit, float(tangents.max()) + _MARGIN_PX / per_unit


class _Packer:
    """Puts rectangles on shelves as wide as the first one, up to row ``top``."""

    def __init__(self) -> None:
        self.width = self.top = 0
        self._shelf = self._used = 0

    def place(self, width: int, height: int) -> tuple[int, int]:
        """Column and row of a rectangle's lower left pixel."""
        if not self.width or self._used + width > self.width:
            self._shelf = self.top
            self._used = 0
        place = self._used, self._shelf
        self._used += width
        self.width = max(self.width, self._used)
        self.top = max(self.top, self._shelf + height)
        return place
