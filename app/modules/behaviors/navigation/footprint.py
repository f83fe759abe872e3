"""What a body covers of the floor, and how near it comes to what stands there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.link import RobotDescription


@dataclass(frozen=True, slots=True, eq=False)
class Footprint:
    """A convex polygon about ``base_link``: ``corners`` (N, 2) float64 m, counter-clockwise, N >= 3.

    ``inscribed_m`` is the radius of the largest circle about ``base_link`` that the polygon covers, ``circumscribed_m``
    of the smallest that covers it: whatever its heading, the body touches what is nearer than the first and nothing
    that is further than the second.
    """

    corners: NDArray[np.float64]
    inscribed_m: float
    circumscribed_m: float

    @staticmethod
    def of(description: RobotDescription) -> Footprint:
        """The footprint of a body. Raises ValueError, naming the body, for one that does not move."""
        raise NotImplementedError

    @staticmethod
    def polygon(corners: NDArray[np.float64]) -> Footprint:
        """Of ``corners`` (N, 2) m. Raises ValueError if they are not convex, counter-clockwise and around (0, 0)."""
        raise NotImplementedError

    def samples(self, spacing_m: float) -> NDArray[np.float64]:
        """Points (P, 2) float64 m in ``base_link``, at most ``spacing_m`` apart, of the edge (corners included) and of
        the inside beyond the inscribed circle: nothing larger than that hides in the body between them."""
        raise NotImplementedError

    def contains(self, points: NDArray[np.float64], margin_m: float = 0.0) -> NDArray[np.bool_]:
        """Which of ``points`` (N, 2), m in ``base_link``, lie within ``margin_m`` of the polygon or in it; (N,)."""
        raise NotImplementedError


def clearances(
    distance: NDArray[np.float32],
    origin: tuple[float, float],
    resolution_m: float,
    footprint: Footprint,
    poses: NDArray[np.float64],
) -> NDArray[np.float32]:
    """How far (m) the body's edge is from the nearest obstacle at each of ``poses`` (P, 3) x, y, heading; (P,) float32.

    ``distance`` (H, W) float32: from each cell's middle to the nearest obstacle (m), the lower left corner of the grid
    at ``origin``; poses in the grid's frame. Exact to a cell where the body is near; further off a lower bound. Zero or
    less: it touches. Places outside the grid read as free.
    """
    raise NotImplementedError
