"""How large a model is: what of the floor its base covers, how high it is, how far below its root it reaches."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from app.base.kinematic_model import KinematicModel
from app.robots.importing.groups import wheels

#: Directions in which an outline is measured: its corners are as many at most.
_CORNERS = 16
#: An outline is no narrower than this (m), and reaches half as far to every side of the root.
_LEAST_M = 0.02


@dataclass(frozen=True, slots=True)
class Outline:
    """``footprint``: corners (m) in the root link, convex, counter-clockwise, of what the base covers; none where it
    does not lie around the root. ``bottom_m``, ``top_m``: least and greatest height of anything, in the root link."""

    footprint: tuple[tuple[float, float], ...]
    bottom_m: float
    top_m: float


def outline(model: KinematicModel, vertices: Mapping[str, NDArray[np.float64]]) -> Outline | None:
    """The outline with all joints at 0 of the shapes' ``vertices`` (N, 3) m by link; None without any.

    The base is what no joint moves, and what turns without end: its wheels.
    """
    if not vertices:
        return None
    poses = model.poses(vertices, {})
    placed = {link: poses[link].transform(points) for link, points in vertices.items()}
    heights = np.concatenate([points[:, 2] for points in placed.values()])
    turning = wheels(model)
    based = [points[:, :2] for link, points in placed.items() if turning.issuperset(model.moved_by(link))]
    corners = around(np.concatenate(based)) if based else ()
    return Outline(corners, float(heights.min()), float(heights.max()))


def around(points: NDArray[np.float64]) -> tuple[tuple[float, float], ...]:
    """A convex polygon of at most 16 corners, counter-clockwise, that covers ``points`` (N, 2); none where that does
    not lie around the origin, or is a line."""
    angles = 2 * math.pi * np.arange(_CORNERS) / _CORNERS
    normals = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    reach = (points @ normals.T).max(axis=0)
    if reach.min() < 0.5 * _LEAST_M:
        return ()
    return tuple((float(x), float(y)) for x, y in _rounded(_corners(normals, reach)))


def _corners(normals: NDArray[np.float64], reach: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners of the polygon of all points whose product with each normal is within its reach.

    They are the polar dual of the hull of normal / reach, since the origin lies inside.
    """
    try:
        hull = ConvexHull(normals / reach[:, np.newaxis])
    except QhullError:
        return np.zeros((0, 2))
    used = [int(vertex) for vertex in hull.vertices]
    pairs = zip(used, [*used[1:], used[0]], strict=True)
    return np.array([np.linalg.solve(normals[list(pair)], reach[list(pair)]) for pair in pairs])


def _rounded(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners to the millimetre, outwards, without those that fall together."""
    outwards = np.sign(corners) * np.ceil(np.abs(corners) * 1000) / 1000
    apart = np.linalg.norm(outwards - np.roll(outwards, 1, axis=0), axis=1) > 2e-3
    return np.asarray(outwards[apart])
