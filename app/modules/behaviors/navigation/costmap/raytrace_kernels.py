"""Compiled kernels: a laser's rays on a grid in ``odom``. Times are ms, int32; NEVER: not occupied, or not seen."""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math

from app.base.compiled import kernel

NEVER = -(2**30)


@kernel(
    "void(float32[::1], float64, float64, float64, float64, float64[:,::1], float64[:,::1], float64[::1], int32,"
    " int32, int32[:,::1], int32[:,::1], int32[:,::1])"
)
def sweep(
    ranges, angle_min, angle_increment, range_min, range_max, poses, body, frame, now, clear_ms, first, last, seen
) -> None:
    """Mark the ends of ``ranges`` (N,) m, and clear the cells that rays pass and that were not hit for ``clear_ms``.

    ``poses`` (2, 5): of the laser in ``odom`` at the first and the last ray (x, y, theta), then x and y of the robot.
    ``body`` (E, 3): its edges in ``base_link`` as outward normals and distances; the first row holds its heading at
    both ends and 0. Returns within the body are the robot itself. ``frame``: x, y (m) of the grid's lower left corner
    and the resolution. ``first``, ``last``, ``seen`` (H, W): times of the first and last hit and of the last look.
    """
    rows, columns = last.shape
    n = len(ranges)
    inverse = 1.0 / frame[2]
    for marking in (True, False):
        for k in range(n):
            distance = float(ranges[k])
            # NaN, or below the least range: no return.
            if not distance >= range_min:
                continue
            hit = distance < range_max
            if marking and not hit:
                continue
            share = k / (n - 1) if n > 1 else 0.0
            x = poses[0, 0] + share * (poses[1, 0] - poses[0, 0])
            y = poses[0, 1] + share * (poses[1, 1] - poses[0, 1])
            angle = poses[0, 2] + share * (poses[1, 2] - poses[0, 2]) + angle_min + k * angle_increment
            c, s = math.cos(angle), math.sin(angle)
            if marking:
                ex, ey = x + distance * c, y + distance * s
                i, j = math.floor((ey - frame[1]) * inverse), math.floor((ex - frame[0]) * inverse)
                if i < 0 or j < 0 or i >= rows or j >= columns:
                    continue
                heading = body[0, 0] + share * (body[0, 1] - body[0, 0])
                dx = ex - poses[0, 3] - share * (poses[1, 3] - poses[0, 3])
                dy = ey - poses[0, 4] - share * (poses[1, 4] - poses[0, 4])
                ch, sh = math.cos(heading), math.sin(heading)
                bx, by = ch * dx + sh * dy, ch * dy - sh * dx
                inside = True
                for e in range(1, len(body)):
                    if body[e, 0] * bx + body[e, 1] * by > body[e, 2]:
                        inside = False
                        break
                if inside:
                    continue
                if last[i, j] == NEVER:
                    first[i, j] = now
                last[i, j] = now
                seen[i, j] = now
                continue
            # A cell and a half before the hit: the cell there may belong to the same obstacle.
            length = (min(distance, range_max) - (1.5 * frame[2] if hit else 0.0)) * inverse
            u, v = (x - frame[0]) * inverse, (y - frame[1]) * inverse
            i, j = math.floor(v), math.floor(u)
            step_i, step_j = (1 if s > 0 else -1), (1 if c > 0 else -1)
            each_i = abs(1.0 / s) if s != 0.0 else math.inf
            each_j = abs(1.0 / c) if c != 0.0 else math.inf
            t_i = (i + (s > 0) - v) / s if s != 0.0 else math.inf
            t_j = (j + (c > 0) - u) / c if c != 0.0 else math.inf
            t = 0.0
            while t < length and 0 <= i < rows and 0 <= j < columns:
                seen[i, j] = now
                if last[i, j] != NEVER and now - last[i, j] >= clear_ms:
                    last[i, j] = NEVER
                if t_i < t_j:
                    t, t_i, i = t_i, t_i + each_i, i + step_i
                else:
                    t, t_j, j = t_j, t_j + each_j, j + step_j


@kernel("void(float64[::1], float64[:,::1], float64[::1], int32[:,::1], int32[:,::1])")
def free_body(pose, edges, frame, laser, depth) -> None:
    """Free the cells under the robot at ``pose`` (x, y, theta), whose ``edges`` (E, 3) are outward normals and
    distances (m): no obstacle is under the robot."""
    reach = 0.0
    rows, columns = laser.shape
    for e in range(len(edges)):
        reach = max(reach, edges[e, 2])
    # Corners lie further out than edges; twice is enough for a triangle.
    cells = int(2.0 * reach / frame[2]) + 1
    row, column = math.floor((pose[1] - frame[1]) / frame[2]), math.floor((pose[0] - frame[0]) / frame[2])
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for i in range(max(row - cells, 0), min(row + cells + 1, rows)):
        for j in range(max(column - cells, 0), min(column + cells + 1, columns)):
            dx = frame[0] + (j + 0.5) * frame[2] - pose[0]
            dy = frame[1] + (i + 0.5) * frame[2] - pose[1]
            bx, by = c * dx + s * dy, c * dy - s * dx
            inside = True
            for e in range(len(edges)):
                if edges[e, 0] * bx + edges[e, 1] * by > edges[e, 2]:
                    inside = False
                    break
            if inside:
                laser[i, j] = NEVER
                depth[i, j] = NEVER


@kernel("void(int32[:,::1], int32[:,::1], int32, int32, int32, int32, uint8[:,::1])")
def standing(first, last, now, forget_ms, steady_ms, keep_ms, free) -> None:
    """Set ``free`` (H, W) to 0 in occupied cells, and drop cells that were not seen for too long."""
    rows, columns = last.shape
    for i in range(rows):
        for j in range(columns):
            if last[i, j] == NEVER:
                continue
            age = now - last[i, j]
            if age > (keep_ms if last[i, j] - first[i, j] >= steady_ms else forget_ms):
                last[i, j] = NEVER
            else:
                free[i, j] = 0
