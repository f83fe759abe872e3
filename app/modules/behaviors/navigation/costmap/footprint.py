"""Footprint of a body on the floor, and its clearance from obstacles."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from app.link import RobotDescription


@dataclass(frozen=True, slots=True, eq=False)
class Footprint:
    """A convex polygon about ``base_link``: ``corners`` (N, 2) float64 m, counter-clockwise, N >= 3.

    ``inscribed_m``: radius of the largest circle about ``base_link`` within the polygon; ``circumscribed_m``: of the
    smallest around it. At any heading the body touches an obstacle nearer than the first, and none further than the
    second. ``passing_m``: half the width of the narrowest passage for the body, where that is more than the first: of a
    body whose arms are stretched out (:meth:`stretched`). ``with_arms``: it is such an outline.
    """

    corners: NDArray[np.float64]
    inscribed_m: float
    circumscribed_m: float
    passing_m: float
    with_arms: bool = False

    @staticmethod
    def of(description: RobotDescription) -> Footprint:
        """The footprint of a body. Raises ValueError, naming the body, for a body that does not move."""
        if not description.footprint:
            raise ValueError(f"{description.name} has no footprint: it does not move, and no way can be planned for it")
        return Footprint.polygon(np.array(description.footprint, dtype=np.float64))

    @staticmethod
    def polygon(corners: NDArray[np.float64]) -> Footprint:
        """Of ``corners`` (N, 2) m. Raises ValueError if they are not convex, counter-clockwise and around (0, 0)."""
        if corners.ndim != 2 or corners.shape[0] < 3 or corners.shape[1] != 2 or not np.isfinite(corners).all():
            raise ValueError(f"a footprint is three corners or more of x and y in m, not an array {corners.shape}")
        sides = np.roll(corners, -1, axis=0) - corners
        after = np.roll(sides, -1, axis=0)
        if (sides[:, 0] * after[:, 1] - sides[:, 1] * after[:, 0] < -1e-12).any():
            raise ValueError("a footprint's corners go around it counter-clockwise, and it has no dents")
        inscribed = float(_edges(corners)[:, 2].min())
        if inscribed <= 0.0:
            raise ValueError("a footprint lies around base_link: (0, 0) is inside it")
        return Footprint(corners, inscribed, float(np.linalg.norm(corners, axis=1).max()), inscribed)

    @staticmethod
    def stretched(corners: NDArray[np.float64], *, sideways: bool) -> Footprint:
        """Of the outline ``corners`` (N, 2) m of a body with its arms stretched out. It passes between two obstacles
        that are as far apart as it is wide across its way, also where its own middle passes nearer to one of them;
        a body that drives ``sideways`` may turn its narrow side to them. Raises ValueError as :meth:`polygon`."""
        body = Footprint.polygon(corners)
        if sideways:
            widths = [float(np.ptp(corners @ normal)) for normal in _edges(corners)[:, :2]]
        else:
            widths = [float(np.ptp(corners[:, 1]))]
        return replace(body, passing_m=max(body.inscribed_m, 0.5 * min(widths)), with_arms=True)

    def samples(self, spacing_m: float) -> NDArray[np.float64]:
        """Points (P, 2) float64 m in ``base_link``, at most ``spacing_m`` apart, of the edge (corners included) and of
        the inside beyond the inscribed circle, so that a larger obstacle meets at least one of them."""
        pieces = []
        for begin, end in zip(self.corners, np.roll(self.corners, -1, axis=0), strict=True):
            count = max(1, math.ceil(float(np.linalg.norm(end - begin)) / spacing_m - 1e-9))
            pieces.append(begin + np.arange(count)[:, None] / count * (end - begin))
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        steps = [
            np.arange(math.ceil(begin / spacing_m), math.floor(end / spacing_m) + 1) * spacing_m
            for begin, end in zip(low, high, strict=True)
        ]
        inside = np.stack(np.meshgrid(*steps), axis=-1).reshape(-1, 2)
        # A point just beyond the circle may have its nearest sample just within.
        beyond = np.hypot(inside[:, 0], inside[:, 1]) > self.inscribed_m - spacing_m * math.sqrt(0.5)
        return np.concatenate((*pieces, inside[beyond & self.contains(inside)]))

    def contains(self, points: NDArray[np.float64], margin_m: float = 0.0) -> NDArray[np.bool_]:
        """Which of ``points`` (N, 2), m in ``base_link``, lie in the polygon, each edge moved outwards by ``margin_m``;
        (N,)."""
        edges = self.edges(margin_m)
        return np.asarray((points @ edges[:, :2].T <= edges[:, 2]).all(axis=1))

    def edges(self, margin_m: float = 0.0) -> NDArray[np.float64]:
        """The edges (N, 3), each moved outwards by ``margin_m``: x and y of the outward normal, and the distance (m)
        from ``base_link``."""
        return np.asarray(_edges(self.corners) + np.array([0.0, 0.0, margin_m]))


def clearances(
    distance: NDArray[np.float32],
    origin: tuple[float, float],
    resolution_m: float,
    footprint: Footprint,
    poses: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Distance (m) of the body's edge from the nearest obstacle at each of ``poses`` (P, 3) x, y, heading; (P,)
    float32.

    ``distance`` (H, W) float32: m from each cell's middle to the nearest obstacle's, the lower left corner of the grid
    at ``origin``; poses in the grid's frame. Exact to a cell near obstacles; a lower bound at distances beyond the
    body's size. Less than half a cell is contact. Places outside the grid read as the nearest cell inside.
    """
    from app.modules.behaviors.navigation.costmap.clearance_kernels import body_clearances

    out = np.empty(len(poses), dtype=np.float32)
    body_clearances(
        distance,
        (origin[0], origin[1], 1.0 / resolution_m),
        footprint.samples(resolution_m),
        (footprint.inscribed_m, footprint.circumscribed_m),
        np.ascontiguousarray(poses),
        out,
    )
    return out


def _edges(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    sides = np.roll(corners, -1, axis=0) - corners
    normals = np.stack((sides[:, 1], -sides[:, 0]), axis=-1) / np.linalg.norm(sides, axis=1, keepdims=True)
    return np.column_stack((normals, (normals * corners).sum(axis=1)))
