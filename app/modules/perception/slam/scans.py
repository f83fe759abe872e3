"""Preparation of scans for matching: points with normals, corrected for the motion during the sweep."""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.base.compiled import kernel
from app.base.geometry import Pose2

#: Greatest range of any laser (m); some messages give an infinite range.
_FURTHEST_M = 1000.0
#: Number of neighbours on either side for the normal of a reading ...
_NEIGHBOURS = 4
#: ... for a laser with more noise than this (standard deviation, m), up to this number within this distance (m).
_NOISY_M = 0.02
_WIDE_NEIGHBOURS = 12
_WIDE_M = 0.35
#: Greatest variance across a surface, as a share of that along it; ...
_SURFACE = 0.1
#: ... the same for a reliable normal.
_FLAT = 0.02


@dataclass(frozen=True, slots=True, eq=False)
class BeamGeometry:
    """Geometry of a laser: ``angles`` (N,) float64 rad of its rays, about z of its frame, in order of measuring.

    Readings below ``range_min`` or NaN are invalid; from ``range_max`` (m) on there was no return. ``X_BL``: the laser
    in ``base_link``.
    """

    angles: NDArray[np.float64]
    range_min: float
    range_max: float
    X_BL: Pose2 = field(default_factory=Pose2)


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """A sweep in ``base_link`` at the sweep's begin; the arrays are those of :class:`types.Keyframe`."""

    points: NDArray[np.float32]
    ends: NDArray[np.float32]
    hits: NDArray[np.bool_]
    origin: NDArray[np.float32]


def prepared(
    ranges: NDArray[np.floating],
    beams: BeamGeometry,
    twist: tuple[float, float, float],
    sweep_s: float,
    range_max_m: float,
    thinning_m: float,
) -> Scan:
    """The scan of ``ranges`` (N,) m, measured over ``sweep_s`` from the first ray to the last, with the body's
    ``twist`` (m/s forward, rad/s, m/s to the left).

    Points nearer to the last one than ``thinning_m`` or farther than ``range_max_m`` from the laser are omitted. Raises
    ValueError where the number of ranges differs from that of the beams.
    """
    if len(ranges) != len(beams.angles):
        raise ValueError(f"{len(ranges)} ranges of {len(beams.angles)} beams")
    readings = np.array(ranges, dtype=np.float64)
    range_max = min(beams.range_max, _FURTHEST_M)
    ends, origins = _ends(
        readings,
        np.array(beams.angles, dtype=np.float64),
        range_max,
        beams.X_BL.x,
        beams.X_BL.y,
        beams.X_BL.theta,
        twist[0],
        twist[1],
        twist[2],
        sweep_s,
    )
    limit = min(range_max_m, range_max)
    points = _surface(readings, ends, origins, beams.range_min, limit, thinning_m)
    measured = readings >= beams.range_min  # False of NaN
    return Scan(
        points=points,
        ends=ends[measured].astype(np.float32),
        hits=readings[measured] < range_max,
        origin=origins[len(origins) // 2].astype(np.float32),
    )


@kernel(
    "Tuple((float64[:, ::1], float64[:, ::1]))(float64[::1], float64[::1], float64, float64, float64, float64, float64,"
    " float64, float64, float64)"
)
def _ends(
    ranges, angles, range_max, laser_x, laser_y, laser_theta, speed, turn_rate, lateral, sweep_s
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Ends and origins (N, 2) of all rays in the base frame at the sweep's begin, for a constant twist."""
    count = len(ranges)
    ends = np.empty((count, 2))
    origins = np.empty((count, 2))
    for i in range(count):
        elapsed = sweep_s * i / max(count - 1, 1)
        turned = turn_rate * elapsed
        half = 0.5 * turned
        # Chord of the arc driven so far: its parts along and across its own heading.
        shorter = math.sin(half) / half if abs(half) > 1e-9 else 1.0
        ahead, aside = speed * elapsed * shorter, lateral * elapsed * shorter
        base_x = ahead * math.cos(half) - aside * math.sin(half)
        base_y = ahead * math.sin(half) + aside * math.cos(half)
        c = math.cos(turned)
        s = math.sin(turned)
        origins[i, 0] = base_x + c * laser_x - s * laser_y
        origins[i, 1] = base_y + s * laser_x + c * laser_y
        reach = min(ranges[i], range_max)
        direction = turned + laser_theta + angles[i]
        ends[i, 0] = origins[i, 0] + reach * math.cos(direction)
        ends[i, 1] = origins[i, 1] + reach * math.sin(direction)
    return ends, origins


@kernel("float64(float64[::1], float64, float64)")
def _noise(ranges, range_min, range_max) -> float:
    """Standard deviation (m) of the ranges' noise, by second differences: most surfaces are smooth."""
    bends = np.empty(len(ranges))
    n = 0
    for i in range(1, len(ranges) - 1):
        first, middle, last = ranges[i - 1], ranges[i], ranges[i + 1]
        if min(first, middle, last) > range_min and max(first, middle, last) < range_max:
            bends[n] = abs(first - 2.0 * middle + last)
            n += 1
    # The median absolute value of a normal distribution is 0.6745 standard deviations; variances of three readings add.
    return float(np.median(bends[:n]) / (0.6745 * math.sqrt(6.0))) if n > 0 else 0.0


@kernel("UniTuple(float64, 2)(float64[::1], float64[:, ::1], int64, int64, float64, float64, float64)")
def _line(ranges, ends, at, neighbours, gap, range_min, range_max) -> tuple[float, float]:
    """Direction (rad) of the readings around one, and their variance across as a share of that along; 1 if
    undefined."""
    x = ends[at, 0]
    y = ends[at, 1]
    n = 0
    sx = sy = sxx = sxy = syy = 0.0
    for j in range(max(0, at - neighbours), min(len(ranges), at + neighbours + 1)):
        if not (ranges[j] > range_min and ranges[j] < range_max):
            continue
        u = ends[j, 0] - x
        v = ends[j, 1] - y
        if u * u + v * v < gap * gap:
            n += 1
            sx += u
            sy += v
            sxx += u * u
            sxy += u * v
            syy += v * v
    if n < 3:
        return 0.0, 1.0
    sxx -= sx * sx / n
    sxy -= sx * sy / n
    syy -= sy * sy / n
    axis = 0.5 * math.atan2(2.0 * sxy, sxx - syy)
    c = math.cos(axis)
    s = math.sin(axis)
    along = sxx * c * c + 2.0 * sxy * c * s + syy * s * s
    return axis, (sxx + syy - along) / (along + 1e-8)


@kernel("float32[:, ::1](float64[::1], float64[:, ::1], float64[:, ::1], float64, float64, float64)")
def _surface(ranges, ends, origins, range_min, range_max, thinning) -> NDArray[np.float32]:
    """Thinned points with normals (M, 4) by principal component analysis of each reading's neighbours on its
    surface."""
    count = len(ranges)
    points = np.empty((count, 4), np.float32)
    made = 0
    last_x = 1e9
    last_y = 1e9
    noisy = _noise(ranges, range_min, range_max) > _NOISY_M
    for i in range(count):
        if not (ranges[i] > range_min and ranges[i] < range_max):
            continue
        x = ends[i, 0]
        y = ends[i, 1]
        if (x - last_x) ** 2 + (y - last_y) ** 2 < thinning * thinning:
            continue
        last_x = x
        last_y = y
        points[made, 0] = x
        points[made, 1] = y
        points[made, 2] = 0.0
        points[made, 3] = 0.0
        # A neighbour beyond this is on another surface; the bound grows with range and spacing.
        gap = max(0.12, 0.06 * ranges[i])
        axis, flatness = _line(ranges, ends, i, _NEIGHBOURS, gap, range_min, range_max)
        if noisy and flatness > _FLAT and gap < _WIDE_M:
            # At short range the noise of the readings exceeds their spacing.
            wide_axis, wide_flatness = _line(ranges, ends, i, _WIDE_NEIGHBOURS, _WIDE_M, range_min, range_max)
            if wide_flatness < flatness:
                axis, flatness = wide_axis, wide_flatness
        if flatness < _SURFACE:
            c = math.cos(axis)
            s = math.sin(axis)
            towards = -s * (origins[i, 0] - x) + c * (origins[i, 1] - y)
            sign = 1.0 if towards >= 0.0 else -1.0
            points[made, 2] = -s * sign
            points[made, 3] = c * sign
        made += 1
    return points[:made].copy()
