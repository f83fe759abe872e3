"""Candidate regions for codes in a fisheye image, resampled as a pinhole camera would see them.

Straight edges are bent in a fisheye image, and far from its middle its scale differs along and across: decoders meant
for straight codes miss those there. Undistorting the whole hemisphere finely enough would cost more than everything
else, so only print-like regions are: a code has the highest density of edges in *both* directions. The score of a block
of 16 x 16 px is the mean difference of neighbouring pixels in the direction where it is less. The blocks of highest
score are cut out as patches, square to a ray through their middle (a gnomonic projection), resampled at a scale of
``PX_PER_RAD``. Patches lie on a fixed grid of directions that overlap, so that each is computed once and kept.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from app.base.geometry import FisheyeModel

#: (azimuth, elevation) of a patch's middle in steps of the grid, right and up.
Cell = tuple[int, int]

#: Scale of a patch at its middle: about twice that of the thesis's panoramic camera.
PX_PER_RAD = 600.0
#: Half size of a patch and spacing of patches (rad): an object up to 20 degrees wide is whole in the nearest patch (a
#: code of 0.18 m from 0.5 m on).
HALF_FOV = math.radians(15.0)
STEP = math.radians(10.0)
#: Least mean difference over two pixels (grey levels), in the direction where it is less, for print. A sensor's noise
#: of 5 levels gives 4, a code of 200 levels of contrast 15 to 40.
LEAST_DETAIL = 8.0

_BLOCK = 16
_SIDE = 2 * round(PX_PER_RAD * math.tan(HALF_FOV))
_COARSE = 8
_SPREAD_BLOCKS = 1.5
_APART_BLOCKS = 4
#: Number of cached remapping tables, 0.6 MB each.
_KEPT = 64


class FisheyePatches:
    """Patches of the images of one fisheye camera; caches its remapping tables."""

    def __init__(self, camera: FisheyeModel) -> None:
        self.camera = camera
        u, v = np.meshgrid(
            *((np.arange(size // _BLOCK) + 0.5) * _BLOCK - 0.5 for size in (camera.width, camera.height))
        )
        self._block_rays = camera.rays(np.stack((u, v), axis=-1))
        self._tables: OrderedDict[Cell, tuple[NDArray[np.int16], NDArray[np.uint16]]] = OrderedDict()

    def promising(self, grey: NDArray[np.uint8], most: int) -> list[Cell]:
        """The cells of ``grey`` (H, W) uint8 with print-like regions, by descending score, at most ``most``."""
        strength = _detail(grey)
        strength[np.isnan(self._block_rays[..., 0])] = 0.0
        cells: list[Cell] = []
        # One cell may be the nearest of several blocks.
        for _ in range(2 * most):
            v, u = divmod(int(np.argmax(strength)), strength.shape[1])
            if strength[v, u] < LEAST_DETAIL or len(cells) == most:
                break
            x, y, z = self._block_rays[v, u]
            cell = (round(math.atan2(x, z) / STEP), round(-math.asin(y) / STEP))
            if cell not in cells:
                cells.append(cell)
            strength[
                max(0, v - _APART_BLOCKS) : v + _APART_BLOCKS + 1, max(0, u - _APART_BLOCKS) : u + _APART_BLOCKS + 1
            ] = 0
        return cells

    def cut(self, grey: NDArray[np.uint8], cell: Cell) -> NDArray[np.uint8]:
        """The patch ``cell`` of ``grey`` (H, W) uint8: (S, S) uint8; black outside the camera's field of view."""
        patch = cv2.remap(grey, *self._table(cell), cv2.INTER_CUBIC)
        return np.asarray(patch, np.uint8)

    def rays(self, cell: Cell, pixels: NDArray[np.floating]) -> NDArray[np.float64]:
        """Unit vectors (..., 3) in the camera's optical frame of ``pixels`` (..., 2) of a patch."""
        middle = 0.5 * (_SIDE - 1)
        flat = (np.asarray(pixels, np.float64) - middle) / PX_PER_RAD
        rays = np.concatenate((flat, np.ones_like(flat[..., :1])), axis=-1)
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        turned: NDArray[np.float64] = rays @ _rotation(cell).T
        return turned

    def _table(self, cell: Cell) -> tuple[NDArray[np.int16], NDArray[np.uint16]]:
        if cell in self._tables:
            self._tables.move_to_end(cell)
            return self._tables[cell]
        # The projection is smooth: computed for every eighth pixel and interpolated. Also beyond the lens's limit,
        # since a gap would spread; the image is black there.
        blocks = -(-_SIDE // _COARSE) + 2
        at = _COARSE * (np.arange(blocks) - 1) + 0.5 * (_COARSE - 1)
        v, u = np.meshgrid(at, at, indexing="ij")
        coarse = replace(self.camera, theta_max=math.pi).project(self.rays(cell, np.stack((u, v), axis=-1)))
        fine = cv2.resize(coarse, (blocks * _COARSE, blocks * _COARSE), interpolation=cv2.INTER_LINEAR)
        source = fine[_COARSE : _COARSE + _SIDE, _COARSE : _COARSE + _SIDE].astype(np.float32)
        whole, fraction = cv2.convertMaps(source[..., 0], source[..., 1], cv2.CV_16SC2)
        table = (np.asarray(whole, np.int16), np.asarray(fraction, np.uint16))
        self._tables[cell] = table
        if len(self._tables) > _KEPT:
            self._tables.popitem(last=False)
        return table


def _detail(grey: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Per block (H/16, W/16): mean difference over two pixels, of the direction where it is less, somewhat spread."""
    height, width = grey.shape
    blocks = (width // _BLOCK, height // _BLOCK)
    whole = grey[: blocks[1] * _BLOCK, : blocks[0] * _BLOCK]
    # Whole blocks only: their mean is many times faster than areas with fractions of pixels.
    across, down = np.zeros_like(whole), np.zeros_like(whole)
    across[:, :-2] = cv2.absdiff(whole[:, 2:], whole[:, :-2])
    down[:-2] = cv2.absdiff(whole[2:], whole[:-2])
    lesser = np.minimum(*(cv2.resize(d, blocks, interpolation=cv2.INTER_AREA) for d in (across, down)))
    return np.asarray(cv2.GaussianBlur(lesser.astype(np.float32), (0, 0), _SPREAD_BLOCKS), np.float32)


def _rotation(cell: Cell) -> NDArray[np.float64]:
    """R_CP of the patch's own optical frame: to the right by its azimuth, then up by its elevation."""
    (ca, sa), (ce, se) = ((math.cos(steps * STEP), math.sin(steps * STEP)) for steps in cell)
    about_y: NDArray[np.float64] = np.array([(ca, 0.0, sa), (0.0, 1.0, 0.0), (-sa, 0.0, ca)])
    about_x: NDArray[np.float64] = np.array([(1.0, 0.0, 0.0), (0.0, ce, -se), (0.0, se, ce)])
    return np.asarray(about_y @ about_x)
