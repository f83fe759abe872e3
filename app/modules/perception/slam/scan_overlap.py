"""Consistency of views: pairs of keyframes overlaid at their poses.

For a point of keyframe ``a``, ``b`` gives one of three results: it has a reading there, too (*agreement*); its rays
pass through the point to a surface behind (*contradiction*); it is occluded or outside the field of view (no result).
Two views of one place agree except for people who walked by; at wrong relative poses they contradict.
"""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from app.base.compiled import kernel
from app.modules.perception.slam.types import Keyframe

#: Number of directions of a view.
_DIRECTIONS = 360
#: Distance (m), and share of the range, within which two readings are of the same surface.
_SAME_M = 0.2
_SAME_SHARE = 0.02
#: Greatest distance (m) of a compared pair, ...
_NEAR_M = 6.0
#: ... number of neighbours in time, and of others, per keyframe.
_ALONG = 30
_MOST_ALONG = 12
_MOST_OTHERS = 24
#: Least number and least share of points with a result.
_LEAST_POINTS = 10
_LEAST_SHARE = 0.15
#: Agreement of a pair: greatest contradicting share, and least agreeing share.
_AGREES = 0.1
_AGREES_SHARE = 0.4
#: Contradiction of a pair: least contradicting share.
_CONTRADICTS = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Pairs of views by index (P,), ``first`` < ``second``: whether they ``agree`` or ``contradict``, (P,) bool each.

    Neither is possible, and a pair may occur twice: from either end.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    agree: NDArray[np.bool_]
    contradict: NDArray[np.bool_]


def compared(keyframes: Sequence[Keyframe], poses: NDArray[np.float64]) -> Pairs:
    """All sufficiently near pairs of ``keyframes``, which are in order of time, at ``poses`` (N, 3)."""
    a, b = _near(poses)
    met = [np.ascontiguousarray(keyframe.ends[keyframe.hits], dtype=np.float64) for keyframe in keyframes]
    counts = np.array([len(points) for points in met], dtype=np.int64)
    points = np.concatenate(met) if met else np.zeros((0, 2))
    starts = np.concatenate((np.zeros(1, np.int64), np.cumsum(counts)))
    sensors_xy = np.array([keyframe.origin for keyframe in keyframes], dtype=np.float64).reshape(-1, 2)
    nearest, farthest = _images(points, starts, sensors_xy)
    agree, through = _laid_over(
        points, starts, sensors_xy, np.ascontiguousarray(poses), nearest, farthest, a, b, _SAME_M, _SAME_SHARE
    )
    seen = agree + through
    says = (seen >= _LEAST_POINTS) & (seen >= _LEAST_SHARE * counts[a])
    wrong = through / np.maximum(seen, 1)
    return Pairs(
        np.minimum(a, b),
        np.maximum(a, b),
        says & (wrong <= _AGREES) & (agree >= _AGREES_SHARE * counts[a]),
        says & (wrong > _CONTRADICTS),
    )


def _near(poses: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    first: list[NDArray[np.int64]] = []
    second: list[NDArray[np.int64]] = []
    if len(poses):
        around = cKDTree(poses[:, :2]).query_ball_point(poses[:, :2], _NEAR_M, return_sorted=True)
        for number, found in enumerate(around):
            near = np.array(found, dtype=np.int64)
            apart = np.abs(near - number)
            for some, most in (
                (near[(apart > 0) & (apart <= _ALONG)], _MOST_ALONG),
                (near[apart > _ALONG], _MOST_OTHERS),
            ):
                chosen = some if len(some) <= most else some[np.linspace(0, len(some) - 1, most).astype(np.int64)]
                second.append(chosen)
                first.append(np.full(len(chosen), number, np.int64))
    if not first:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    return np.concatenate(first), np.concatenate(second)


@kernel("UniTuple(float32[:, ::1], 2)(float64[:, ::1], int64[::1], float64[:, ::1])")
def _images(points, starts, sensors_xy) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """The nearest and the farthest reading (m) of each view in each direction and its neighbours; inf and -1: none."""
    count = len(sensors_xy)
    near = np.full((count, _DIRECTIONS), np.inf, np.float32)
    far = np.full((count, _DIRECTIONS), -1.0, np.float32)
    for view in range(count):
        for i in range(starts[view], starts[view + 1]):
            dx = points[i, 0] - sensors_xy[view, 0]
            dy = points[i, 1] - sensors_xy[view, 1]
            reach = np.float32(math.sqrt(dx * dx + dy * dy))
            at = int((math.atan2(dy, dx) + math.pi) / (2.0 * math.pi) * _DIRECTIONS) % _DIRECTIONS
            for beside in range(at - 1, at + 2):
                to = beside % _DIRECTIONS
                near[view, to] = min(near[view, to], reach)
                far[view, to] = max(far[view, to], reach)
    return near, far


@kernel(
    "UniTuple(int64[::1], 2)(float64[:, ::1], int64[::1], float64[:, ::1], float64[:, ::1], float32[:, ::1],"
    " float32[:, ::1], int64[::1], int64[::1], float64, float64)"
)
def _laid_over(
    points, starts, sensors_xy, poses, nearest, farthest, first, second, same_m, same_share
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Of each pair (P,), the number of points of the first with a reading of the second, and of those it sees
    through."""
    agree = np.zeros(len(first), np.int64)
    through = np.zeros(len(first), np.int64)
    for k in range(len(first)):
        a, b = first[k], second[k]
        turn = poses[a, 2] - poses[b, 2]
        c, s = math.cos(turn), math.sin(turn)
        cb, sb = math.cos(poses[b, 2]), math.sin(poses[b, 2])
        dx, dy = poses[a, 0] - poses[b, 0], poses[a, 1] - poses[b, 1]
        x0 = cb * dx + sb * dy - sensors_xy[b, 0]
        y0 = cb * dy - sb * dx - sensors_xy[b, 1]
        for i in range(starts[a], starts[a + 1]):
            x = x0 + c * points[i, 0] - s * points[i, 1]
            y = y0 + s * points[i, 0] + c * points[i, 1]
            at = int((math.atan2(y, x) + math.pi) / (2.0 * math.pi) * _DIRECTIONS) % _DIRECTIONS
            if farthest[b, at] < 0.0:
                continue
            reach = math.sqrt(x * x + y * y)
            same = same_m + same_share * reach
            if reach < nearest[b, at] - same:
                through[k] += 1
            elif reach <= farthest[b, at] + same:
                agree[k] += 1
    return agree, through
