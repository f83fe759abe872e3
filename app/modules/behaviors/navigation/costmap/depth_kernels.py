"""Compiled kernels: depth images on a grid in ``odom``, with the heights of obstacles.

Heights of a cell are 16 bands (bits of a uint16) from the floor to the body's height: a ray that passes over a box does
not clear it, a ray through the box's place does.
"""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math

import numpy as np

from app.base.compiled import kernel

NEVER = -(2**30)
_BANDS = 16
#: Least number of pixels in a cell that make an obstacle; a single one may be noise.
_ENOUGH = 2


@kernel(
    "void(uint16[:,::1], float64[::1], float64[:,::1], float64[::1], float64[:,::1], float64[::1], float64[::1],"
    " int64, int32, int32[:,::1], int32[:,::1], uint16[:,::1])"
)
def mark(depth, lens, X_BC, pose, edges, frame, limits, step, now, first, last, bands) -> None:
    """Mark obstacles of ``depth`` (H, W) mm between the floor and the body's height.

    ``lens``: fx, fy, cx, cy (px). ``X_BC`` (3, 4): rotation and translation. ``pose``: x, y, theta of the robot in
    ``odom``. ``edges`` and ``frame`` as in ``raytrace_kernels``. ``limits``: lowest height that counts (m) and its
    growth with distance, the body's height, the greatest depth, and the depth of a drop below the floor (inf: drops do
    not count).
    """
    rows, columns = last.shape
    height, width = depth.shape
    floor, slope, top, furthest, drop = limits[0], limits[1], limits[2], limits[3], limits[4]
    inverse = 1.0 / frame[2]
    c, s = math.cos(pose[2]), math.sin(pose[2])
    count = np.zeros((rows, columns), dtype=np.uint8)
    now_in = np.zeros((rows, columns), dtype=np.uint16)
    touched = np.empty((height // step + 1) * (width // step + 1), dtype=np.int64)
    touches = 0
    for v in range(step // 2, height, step):
        ry = (v - lens[3]) / lens[1]
        for u in range(step // 2, width, step):
            z = depth[v, u] * 0.001
            if z == 0.0 or z > furthest:
                continue
            rx = (u - lens[2]) / lens[0]
            up = (X_BC[2, 0] * rx + X_BC[2, 1] * ry + X_BC[2, 2]) * z + X_BC[2, 3]
            if up > top:
                continue
            px = (X_BC[0, 0] * rx + X_BC[0, 1] * ry + X_BC[0, 2]) * z + X_BC[0, 3]
            py = (X_BC[1, 0] * rx + X_BC[1, 1] * ry + X_BC[1, 2]) * z + X_BC[1, 3]
            if up < floor + slope * math.hypot(px, py):
                if up > -drop:
                    continue
                # The edge is where the ray crosses the floor.
                share = X_BC[2, 3] / (X_BC[2, 3] - up)
                px, py = X_BC[0, 3] + share * (px - X_BC[0, 3]), X_BC[1, 3] + share * (py - X_BC[1, 3])
                up = 0.0
            inside = True
            for e in range(len(edges)):
                if edges[e, 0] * px + edges[e, 1] * py > edges[e, 2]:
                    inside = False
                    break
            if inside:
                continue
            x, y = pose[0] + c * px - s * py, pose[1] + s * px + c * py
            i, j = math.floor((y - frame[1]) * inverse), math.floor((x - frame[0]) * inverse)
            if i < 0 or j < 0 or i >= rows or j >= columns:
                continue
            if count[i, j] == 0:
                touched[touches] = i * columns + j
                touches += 1
            if count[i, j] < 255:
                count[i, j] += 1
            band = min(int(up / top * _BANDS), _BANDS - 1)
            now_in[i, j] = now_in[i, j] | (1 << band)
    for k in range(touches):
        i, j = touched[k] // columns, touched[k] % columns
        if count[i, j] < _ENOUGH:
            continue
        if last[i, j] == NEVER:
            first[i, j] = now
            bands[i, j] = 0
        last[i, j] = now
        bands[i, j] = bands[i, j] | now_in[i, j]


@kernel(
    "void(uint16[:,::1], float64[::1], float64[:,::1], float64[::1], float64[::1], float64, int32, int32, int32[:,::1],"
    " uint16[:,::1])"
)
def clear(depth, lens, X_BC, pose, frame, top, now, clear_ms, last, bands) -> None:
    """Clear bands that the camera looks through: along the ray to a band the measured depth is greater than the band's.

    Only bands not hit for ``clear_ms``. Bands outside the image, and bands whose ray measured nothing, stay.
    """
    rows, columns = last.shape
    height, width = depth.shape
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(rows):
        for j in range(columns):
            if last[i, j] == NEVER or now - last[i, j] < clear_ms:
                continue
            dx = frame[0] + (j + 0.5) * frame[2] - pose[0]
            dy = frame[1] + (i + 0.5) * frame[2] - pose[1]
            px, py = c * dx + s * dy - X_BC[0, 3], c * dy - s * dx - X_BC[1, 3]
            left = int(bands[i, j])
            for band in range(_BANDS):
                if not left & (1 << band):
                    continue
                passed, met = False, False
                # Foot, middle and head of the band: a thin obstacle may be at any of them.
                for k in range(3):
                    pz = (band + 0.1 + 0.4 * k) * top / _BANDS - X_BC[2, 3]
                    z = X_BC[0, 2] * px + X_BC[1, 2] * py + X_BC[2, 2] * pz
                    if z < 0.1:
                        continue
                    u = math.floor((X_BC[0, 0] * px + X_BC[1, 0] * py + X_BC[2, 0] * pz) / z * lens[0] + lens[2] + 0.5)
                    v = math.floor((X_BC[0, 1] * px + X_BC[1, 1] * py + X_BC[2, 1] * pz) / z * lens[1] + lens[3] + 0.5)
                    if v < 0 or v >= height or u < 3 or u >= width - 3:
                        continue
                    measured = depth[v, u]
                    if measured == 0:
                        # A hole in the picture: beside it, if there
                        measured = max(depth[v, u - 3], depth[v, u + 3])
                    if measured == 0:
                        continue
                    if measured * 0.001 > z + 0.1 + 0.01 * z * z:
                        passed = True
                    else:
                        met = True
                if passed and not met:
                    left &= ~(1 << band)
            bands[i, j] = left
            if left == 0:
                last[i, j] = NEVER
