"""Compiled kernel: clearance of a body from obstacles."""

# mypy: allow-untyped-defs, allow-incomplete-defs

from __future__ import annotations

import math

from app.base.compiled import kernel


@kernel(
    "void(float32[:,::1], UniTuple(float64, 3), float64[:,::1], UniTuple(float64, 2), float64[:,::1], float32[::1])"
)
def body_clearances(field, frame, samples, radii, poses, out) -> None:
    """Write the distance (m) of the body's edge to the nearest obstacle into ``out`` (P,), as ``footprint.clearances``.

    ``frame``: x, y (m) of the field's lower left corner, 1 / resolution. ``radii``: inscribed, circumscribed.
    """
    rows, columns = field.shape
    for k in range(len(poses)):
        x, y = poses[k, 0], poses[k, 1]
        row = min(max(math.floor((y - frame[1]) * frame[2]), 0), rows - 1)
        column = min(max(math.floor((x - frame[0]) * frame[2]), 0), columns - 1)
        middle = field[row, column]
        if middle >= 2.0 * radii[1]:
            out[k] = middle - radii[1]
            continue
        # An obstacle within the inscribed circle, or right at a sample, is contact whatever the other samples give.
        least = middle - radii[0]
        if least > 0.0:
            c, s = math.cos(poses[k, 2]), math.sin(poses[k, 2])
            for i in range(len(samples)):
                px, py = x + c * samples[i, 0] - s * samples[i, 1], y + s * samples[i, 0] + c * samples[i, 1]
                row = min(max(math.floor((py - frame[1]) * frame[2]), 0), rows - 1)
                column = min(max(math.floor((px - frame[0]) * frame[2]), 0), columns - 1)
                least = min(least, field[row, column])
        out[k] = least
