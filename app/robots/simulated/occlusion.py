"""Occlusion by walls: a depth buffer over the azimuth, since walls reach from floor to ceiling.

In a building with a ceiling, a full-height wall hides everything behind it: occlusion is a question of the floor plan
alone. The azimuth around the camera is divided into sectors, each with the distance of the nearest wall that fills it;
a shape is hidden if every sector it touches has such a wall in front of it. Rounding is conservative: no visible shape
is called hidden.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

_SECTORS = 1024
_PER_RAD = _SECTORS / (2 * math.pi)
_NEAR_FLOOR = 0.01
_CEILING = "ceiling"


class Occlusion:
    """The walls of ``model``, whose positions are in ``data``."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        starts, ends = _walls(model, data)
        self._starts, self._ends = starts, ends
        turns = np.arange(_SECTORS) / _PER_RAD
        self._rays = np.column_stack([np.cos(turns), np.sin(turns)])
        self._radius = model.geom_rbound.copy()
        self._endless = self._radius == 0

    def hidden(self, eye: NDArray[np.float64], centers: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which shapes (ngeom,) with bounding spheres at ``centers`` (ngeom, 3) cannot be seen from ``eye`` (3,)."""
        if not len(self._starts):
            return np.zeros(len(centers), dtype=np.bool_)
        farthest = _range_maxima(self._sectors(eye[:2]))
        offset = centers[:, :2] - eye[:2]
        distance = np.hypot(offset[:, 0], offset[:, 1])
        around = distance <= self._radius
        half = np.arcsin(np.where(around, 0.0, self._radius / np.where(around, 1.0, distance)))
        middle = np.arctan2(offset[:, 1], offset[:, 0])
        first = np.floor((middle - half) * _PER_RAD).astype(np.intp)
        count = np.floor((middle + half) * _PER_RAD).astype(np.intp) - first + 1
        level = np.frexp(count)[1] - 1  # the largest power of two within count
        last = first + count - (1 << level)
        wall = np.maximum(farthest[level, first % _SECTORS], farthest[level, last % _SECTORS])
        return np.asarray((distance - self._radius > wall) & ~around & ~self._endless)

    def _sectors(self, eye: NDArray[np.float64]) -> NDArray[np.float64]:
        """For each sector (from ray i to ray i + 1) the far distance of the nearest wall that fills it; inf for
        none."""
        a, b = self._starts - eye, self._ends - eye
        cross, dot = _cross(a, b), (a * b).sum(axis=1)
        right = np.where(cross[:, None] >= 0, a, b)  # the end from which the wall goes to the left
        along = np.where(cross[:, None] >= 0, b - a, a - b)
        begin = np.arctan2(right[:, 1], right[:, 0])
        first = np.ceil(begin * _PER_RAD).astype(np.intp)
        last = np.floor((begin + np.arctan2(np.abs(cross), dot)) * _PER_RAD).astype(np.intp)
        # Seen along its length, a wall hides nothing
        count = np.where(np.abs(cross) > 1e-9, np.maximum(last - first + 1, 0), 0)
        wall = np.repeat(np.arange(len(count)), count)
        ray = np.arange(len(wall)) + np.repeat(first - np.cumsum(count) + count, count)
        # Ray t d meets right + s along: cross products with along give t
        met = np.abs(cross)[wall] / _cross(self._rays[ray % _SECTORS], along[wall])
        filled = wall[1:] == wall[:-1]
        nearest = np.full(_SECTORS, np.inf)
        np.minimum.at(nearest, ray[:-1][filled] % _SECTORS, np.maximum(met[1:], met[:-1])[filled])
        return nearest


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of vectors (n, 2) in the plane."""
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def _walls(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Ends (n, 2) of the middle lines of walls: upright opaque boxes of the building from the floor to the ceiling."""
    none = np.zeros((0, 2))
    ceiling = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, _CEILING)
    if ceiling < 0:
        return none, none
    height = data.geom_xpos[ceiling][2]
    ends: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
    for geom in range(model.ngeom):
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_BOX or model.geom_bodyid[geom] != 0:
            continue
        rotation, middle = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
        upright = int(np.argmax(np.abs(rotation[2])))
        reach = abs(rotation[2, upright]) * model.geom_size[geom, upright]
        material = model.geom_matid[geom]
        opacity = model.geom_rgba[geom, 3] if material < 0 else model.mat_rgba[material, 3]
        if (
            abs(rotation[2, upright]) < 1.0 - 1e-9
            or middle[2] - reach > _NEAR_FLOOR
            or middle[2] + reach < height - _NEAR_FLOOR
            or opacity < 1.0
        ):
            continue
        long = max((axis for axis in range(3) if axis != upright), key=lambda axis: model.geom_size[geom, axis])
        half = rotation[:2, long] * model.geom_size[geom, long]
        ends.append((middle[:2] - half, middle[:2] + half))
    if not ends:
        return none, none
    return np.array([start for start, _ in ends]), np.array([end for _, end in ends])


def _range_maxima(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Row k holds the cyclic maxima over the 2**k values from each index on."""
    rows = [values]
    while 1 << len(rows) <= 2 * len(values):
        last, shift = rows[-1], (1 << (len(rows) - 1)) % len(values)
        rows.append(np.maximum(last, np.concatenate((last[shift:], last[:shift]))))
    return np.array(rows)
