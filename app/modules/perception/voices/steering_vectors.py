"""Steering vectors: arrival times of sound by direction, and the grid of searched directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.microphone_array import MicrophoneArray

#: Speed of sound in air at about 20 degrees Celsius (m/s).
SPEED_OF_SOUND = 343.0
_LINE_STEP_DEG = 2.0


def sphere(points: int) -> NDArray[np.float64]:
    """``points`` directions (points, 3), evenly over the sphere (Fibonacci's lattice)."""
    index = np.arange(points) + 0.5
    height = 1 - 2 * index / points
    turn = np.pi * (1 + 5**0.5) * index
    radius = np.sqrt(1 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def search_grid(array: MicrophoneArray, points: int, lowest_deg: float) -> NDArray[np.float64]:
    """The directions (G, 3) that ``array`` can distinguish, out of ``points`` on the whole sphere.

    In space: all, except those below an elevation of ``lowest_deg``. In a plane, mirror images are alike: of each pair,
    the direction on the plane's upper side, or the front side of a vertical plane. On a line only the angle to it
    counts: the directions of the level half circle in front of it (to the left if the line points forward).
    """
    _, axes = array.extents
    if array.dimensions == 1:
        line = axes[0]
        aside = next(
            level - (level @ line) * line for level in np.eye(3) if np.linalg.norm(level - (level @ line) * line) > 0.5
        )
        aside /= np.linalg.norm(aside)
        angles = np.radians(np.arange(0, 180 + _LINE_STEP_DEG, _LINE_STEP_DEG))[:, None]
        return np.asarray(np.cos(angles) * line + np.sin(angles) * aside)
    grid = sphere(points)
    grid = grid[grid[:, 2] > np.sin(np.radians(lowest_deg))]
    if array.dimensions == 2:
        normal = axes[2]
        facing = normal[2] if abs(normal[2]) > 0.1 else normal[0] if abs(normal[0]) > 0.1 else normal[1]
        grid = grid[grid @ normal * np.sign(facing) >= 0]
    return np.asarray(grid)


def paths(
    offsets: NDArray[np.float64], sources: NDArray[np.float64], body_m: float = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lengths of the ways from ``sources`` (G, 3) to the microphones (M, 3), both m about the middle of the body; and
    of their parts along its surface. Both (G, M) m.

    Behind a body (a sphere of radius ``body_m``) sound takes the shortest path around it: straight to its edge, then
    along its surface (Woodworth 1938).
    """
    ways = np.asarray(np.linalg.norm(sources[:, None] - offsets, axis=2))
    if not body_m:
        return ways, np.zeros_like(ways)
    away = np.maximum(np.linalg.norm(offsets, axis=1), 1e-6)
    far = np.maximum(np.linalg.norm(sources, axis=1), 1e-6)[:, None]
    on_body = np.minimum(body_m, away)
    angles = np.arccos(np.clip(sources / far @ (offsets / away[:, None]).T, -1, 1))
    arc = angles - np.arccos(np.minimum(on_body / far, 1)) - np.arccos(on_body / away)
    along = on_body * np.maximum(arc, 0)
    straight = np.sqrt(np.maximum(far**2 - on_body**2, 0)) + np.sqrt(away**2 - on_body**2)
    return np.asarray(np.where(arc > 0, straight + along, ways)), np.asarray(along)


def arrivals(
    offsets: NDArray[np.float64], directions: NDArray[np.float64], range_m: float, body_m: float = 0.0
) -> NDArray[np.float64]:
    """Delay (s), relative to the middle, of sound from ``directions`` (G, 3), ``range_m`` away, at each microphone.

    ``offsets`` (M, 3) m about the middle; the result is (G, M). An infinite range gives plane waves. Behind a body
    sound takes the way of :func:`paths`.
    """
    if np.isinf(range_m):
        if not body_m:
            return np.asarray(-directions @ offsets.T / SPEED_OF_SOUND)
        range_m = 1e3
    return np.asarray((paths(offsets, range_m * directions, body_m)[0] - range_m) / SPEED_OF_SOUND)


def tangents(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Two unit vectors at right angles to each of ``directions`` (K, 3) and to one another: (K, 2, 3)."""
    x, y, z = directions.T
    # Duff et al. 2017, "Building an orthonormal basis, revisited": no branch, no division by little.
    sign = np.where(z >= 0, 1.0, -1.0)
    a = -1 / (sign + z)
    b = x * y * a
    pairs = np.stack([1 + sign * x * x * a, sign * b, -sign * x, b, sign + y * y * a, -y], axis=1)
    return np.asarray(pairs.reshape(-1, 2, 3))
