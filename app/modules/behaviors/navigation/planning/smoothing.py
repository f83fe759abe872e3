"""Smoothing: from cells to a drivable path, by any-angle shortcuts of no higher cost, local descent, rounded corners,
headings."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.modules.behaviors.navigation.costmap.inflation import CostField

#: Local descent: length of pieces (m), then strides to the side (m) with the greatest number of passes. Parts further
#: ahead than ``_BENT_M`` are planned again before the robot gets there.
_BENDING = ((0.4, (0.2, 0.1, 0.05), 12), (0.1, (0.05, 0.025), 6))
_BENT_M = 60.0
#: Passes of relaxation, which round a corner over some eight poses to each side, and the share of the clearance beyond
#: the lethal one that each point keeps.
_ROUNDS = 60
_KEEP = 0.6


def smooth(field: CostField, points: NDArray[np.float64], spacing_m: float) -> NDArray[np.float64]:
    """Points (M, 2) float64 x, y (m), about ``spacing_m`` apart, from the first to the last of ``points`` (N >= 1, 2).
    Both lead along free cells only. The result costs less, or little more for being round."""
    from app.modules.behaviors.navigation.planning.path_kernels import refine, relax, shortcuts

    frame = field.frame
    corner = np.array([frame.y, frame.x])
    cells = np.ascontiguousarray((points[:, ::-1] - corner) / frame.resolution_m - 0.5)
    kept = cells[shortcuts(field.cost, cells)]
    along = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(kept, axis=0).T)))) * frame.resolution_m
    count = int(np.searchsorted(along, _BENT_M)) + 1
    near, far = kept[:count], kept[count:]
    for piece_m, strides_m, rounds in _BENDING:
        near = _divided(near, piece_m / frame.resolution_m)
        for stride_m in strides_m:
            refine(field.cost, near, stride_m / frame.resolution_m, rounds)
    near = _divided(near, spacing_m / frame.resolution_m)
    dense = np.concatenate((near, _divided(np.concatenate((near[-1:], far)), spacing_m / frame.resolution_m)[1:]))
    for part, rounds in ((dense[: len(near)], _ROUNDS), (dense[len(near) - 1 :], _ROUNDS // 4)):
        relax(field.cost, field.clearance, part, rounds, field.lethal_m, _KEEP)
    return np.ascontiguousarray(((dense + 0.5) * frame.resolution_m + corner)[:, ::-1])


def with_headings(points: NDArray[np.float64], first: float, last: float) -> NDArray[np.float64]:
    """Poses (M, 3) of points (M >= 1, 2): headings along the path; ``last`` (rad, NaN: along the path) at the end,
    ``first`` if there is a single point."""
    poses = np.empty((len(points), 3))
    poses[:, :2] = points
    if len(points) > 1:
        ahead = np.diff(points, axis=0)
        turns = np.concatenate((ahead[:1], ahead[:-1] + ahead[1:], ahead[-1:]))
        poses[:, 2] = np.arctan2(turns[:, 1], turns[:, 0])
    else:
        poses[0, 2] = first
    if math.isfinite(last):
        poses[-1, 2] = last
    return poses


def length_of(points: NDArray[np.float64]) -> float:
    """Length (m) of ``points`` (N, 2 or more columns)."""
    return float(np.hypot(*np.diff(points[:, :2], axis=0).T).sum()) if len(points) > 1 else 0.0


def _divided(corners: NDArray[np.float64], spacing: float) -> NDArray[np.float64]:
    """Each leg between ``corners`` divided evenly into pieces of at most ``spacing``."""
    if len(corners) < 2:
        return corners
    legs = np.diff(corners, axis=0)
    counts = np.maximum(np.ceil(np.hypot(legs[:, 0], legs[:, 1]) / spacing - 1e-9).astype(np.int64), 1)
    leg = np.repeat(np.arange(len(legs)), counts)
    within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    points = corners[leg] + (within / counts[leg])[:, None] * legs[leg]
    return np.concatenate((points, corners[-1:]))
