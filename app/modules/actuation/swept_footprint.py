"""Time to contact of a moving body with laser points: exact for a convex footprint on a circular arc.

The velocity of the body is v = vx + i·vy, m/s forward and to the left, and ω rad/s. In the body's frame every world
point moves on a circle around the centre of rotation i·v/ω (on a straight line when the body does not turn). The
footprint is the intersection of half planes. On such a circle each half plane excludes one arc, so a point is inside
where no such arc holds it. The computation covers all points at once.

The path is not sampled, so a thin obstacle cannot be missed between two samples. To rate circular arcs by their free
length is R. Simmons's *curvature-velocity method* (ICRA 1996).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Points = NDArray[np.complex128]
"""Points of a plane as complex numbers: x + iy, m in ``base_link``."""

#: A slower velocity (m/s) closes in on no edge beyond rounding: it is none.
_STANDS_MPS = 1e-9
#: An arc that turns less than this (rad) within the horizon is treated as straight: the error is under 1 mm on 1 m.
STRAIGHT_RAD = 1e-3
_TOUCH_RAD = 1e-9
_ALWAYS_RAD = 4.0  # more than any bearing: a half plane that is never entered


@dataclass(frozen=True, slots=True, eq=False)
class Polygon:
    """A convex polygon as half planes: a point p is inside where ``normals @ p <= offsets``.

    ``normals`` (M,) outward unit vectors, counter-clockwise, ``bearings`` (M,) their angles, ``offsets`` (M,) m;
    ``inner`` and ``outer`` are the radii (m) of discs around the origin inside it and around it.
    """

    normals: Points
    bearings: Floats
    offsets: Floats
    inner: float
    outer: float

    @staticmethod
    def of(corners: Sequence[tuple[float, float]], margin_m: float = 0.0) -> Polygon:
        """The polygon of ``corners`` (m, convex, counter-clockwise, around the origin), every edge moved out by
        ``margin_m``.

        Raises ValueError for corners without these properties.
        """
        points = np.array([complex(x, y) for x, y in corners])
        edges = np.roll(points, -1) - points
        if len(points) < 3 or not np.all(np.abs(edges) > 0):
            raise ValueError("a footprint has at least 3 corners, none of them twice")
        normals = -1j * edges / np.abs(edges)
        offsets = (normals.conj() * points).real
        beyond = (normals[:, None].conj() * points).real - offsets[:, None]
        if np.any(beyond > 1e-6) or np.any(offsets <= 0):
            raise ValueError("a footprint's corners go counter-clockwise around base_link, and it is convex")
        offsets = offsets + margin_m
        following, further = np.roll(normals, -1), np.roll(offsets, -1)
        cross = (normals.conj() * following).imag
        turned = cross > 1e-9  # else two edges in one line, which have no corner between them
        moved = 1j * (further * normals - offsets * following)[turned] / cross[turned]
        return Polygon(normals, np.angle(normals), offsets, float(offsets.min()), float(np.abs(moved).max()))

    def edgewise(self, points: Points) -> Floats:
        """How far (m) each of ``points`` (N,) lies beyond each edge, (N, M); negative on the inside."""
        return np.asarray(
            points.real[:, None] * self.normals.real + points.imag[:, None] * self.normals.imag - self.offsets
        )

    def beyond(self, points: Points) -> tuple[Floats, NDArray[np.intp]]:
        """How far (m) each of ``points`` (N,) is beyond its most exceeded edge, and the index of that edge.

        Negative inside. Beside an edge it equals the distance, off a corner it is a little less.
        """
        beyond = self.edgewise(points)
        edge = beyond.argmax(axis=1)
        return beyond[np.arange(len(points)), edge], edge


def may_decide(
    points: Points, tight: Polygon, grown: Polygon, velocity: complex, angular: float, horizon_s: float, evidence: int
) -> NDArray[np.intp]:
    """Which of ``points`` (N,) may be among the first ``evidence`` contacts: a superset of them.

    Uses discs around and inside the footprints: a point that reaches the outer disc later than enough others surely
    reach the inner one cannot be among the first.
    """
    if abs(angular) * horizon_s < STRAIGHT_RAD:
        return _first_on_line(points, tight, grown=grown, velocity=velocity, horizon_s=horizon_s, evidence=evidence)
    centre = 1j * velocity / angular
    distance = abs(centre)
    around = points - centre
    reach2 = around.real**2 + around.imag**2
    low, high = max(distance - grown.outer, 0.0) ** 2, (distance + grown.outer) ** 2
    near = np.flatnonzero(np.abs(reach2 - (low + high) / 2) <= (high - low) / 2)
    if distance < 1e-6 or len(near) < 4 * evidence:
        return near
    around, reach2 = around[near], np.maximum(reach2[near], 1e-18)  # one at the very centre has no direction
    # Angle of each point around the centre to the base's origin, and before that to the discs.
    to_go = np.angle(around * -centre.conjugate())
    to_go = to_go if angular > 0 else -to_go
    span = 2 * distance * np.sqrt(reach2)
    middle = reach2 + distance**2
    arrives = _arc_enters(to_go, (middle - grown.outer**2) / span)
    chosen = arrives <= abs(angular) * horizon_s
    low, high = max(distance - tight.inner, 0.0) ** 2, (distance + tight.inner) ** 2
    surely = np.flatnonzero(chosen & (np.abs(reach2 - (low + high) / 2) < (high - low) / 2))
    if len(surely) >= evidence:
        deep = _arc_enters(to_go[surely], (middle[surely] - grown.inner**2) / span[surely])
        chosen &= arrives <= np.partition(deep, evidence - 1)[evidence - 1]
    return near[chosen]


def _arc_enters(to_go: Floats, cosine: Floats) -> Floats:
    half = np.arccos(np.minimum(np.maximum(cosine, -1.0), 1.0))
    angle = to_go - half
    return np.where(angle >= 0, angle, np.where(to_go > -half, 0.0, angle + 2 * math.pi))


def _first_on_line(
    points: Points, tight: Polygon, grown: Polygon, velocity: complex, horizon_s: float, evidence: int
) -> NDArray[np.intp]:
    speed = abs(velocity)
    turned = points * (velocity.conjugate() / speed if speed > 0.0 else 1.0)
    ahead, aside = turned.real, turned.imag
    far = speed * horizon_s + grown.outer
    lane = (np.abs(aside) <= grown.outer) & (np.abs(ahead - (far - grown.outer) / 2) <= (far + grown.outer) / 2)
    near = np.flatnonzero(lane)
    if len(near) < 4 * evidence:
        return near
    ahead, aside2 = ahead[near], aside[near] ** 2
    arrives = ahead - np.sqrt(grown.outer**2 - aside2)
    surely = np.flatnonzero((aside2 < tight.inner**2) & (ahead > 0))
    if len(surely) >= evidence:
        deep = ahead[surely] - np.sqrt(grown.inner**2 - aside2[surely])
        near = near[arrives <= max(0.0, float(np.partition(deep, evidence - 1)[evidence - 1]))]
    return near


def contact_times(points: Points, polygon: Polygon, velocity: complex, angular: float, horizon_s: float) -> Floats:
    """Time until each of ``points`` (N,) is inside ``polygon``, in seconds from now, (N,).

    The body keeps ``velocity`` (m/s, forward + i left) and ``angular`` (rad/s, left positive). 0 for points already
    inside, inf for points not met within ``horizon_s``.
    """
    if abs(angular) * horizon_s < STRAIGHT_RAD:
        return _straight(points, polygon, velocity, horizon_s)
    return _around(points, polygon, velocity, angular, horizon_s)


def _straight(points: Points, polygon: Polygon, velocity: complex, horizon_s: float) -> Floats:
    beyond = polygon.edgewise(points)
    if abs(velocity) < _STANDS_MPS:
        return np.where(beyond.max(axis=1) < 0, 0.0, np.inf)
    closing = velocity.real * polygon.normals.real + velocity.imag * polygon.normals.imag
    entering, leaving = closing > 1e-12, closing < -1e-12
    alongside = ~(entering | leaving)
    enters = np.maximum((beyond[:, entering] / closing[entering]).max(axis=1), 0.0)
    leaves = (beyond[:, leaving] / closing[leaving]).min(axis=1)
    met = (enters < leaves) & (enters <= horizon_s)
    if alongside.any():
        met &= beyond[:, alongside].max(axis=1) < 0
    return np.where(met, enters, np.inf)


def _around(points: Points, polygon: Polygon, velocity: complex, angular: float, horizon_s: float) -> Floats:
    centre = 1j * velocity / angular
    around = points - centre
    reach = np.maximum(np.abs(around), 1e-9)
    # Distance of a half plane's line from the centre; a point is beyond it within `half` of its normal's bearing.
    cosine = (polygon.offsets - (polygon.normals.conj() * centre).real) / reach[:, None]
    half = np.where(cosine > -1.0, np.arccos(np.minimum(np.maximum(cosine, -1.0), 1.0)), _ALWAYS_RAD)
    left = np.angle(around)[:, None] - polygon.bearings
    if angular < 0:
        left = -left
    left[left >= math.pi] -= 2 * math.pi
    left[left < -math.pi] += 2 * math.pi
    end = min(abs(angular) * horizon_s, 2 * math.pi)
    gone = np.zeros(len(points))
    todo = np.arange(len(points))
    for _ in range(2 * len(polygon.offsets)):
        leap = np.where(np.abs(left) < half - _TOUCH_RAD, left + half, 0.0).max(axis=1)
        gone[todo] += leap
        on = np.flatnonzero((leap > 0) & (gone[todo] <= end))
        if not len(on):
            break
        todo, half = todo[on], half[on]
        left = left[on] - leap[on, None]
        left[left < -math.pi] += 2 * math.pi
    else:
        gone[todo] = np.inf
    return np.where(gone <= end, gone / abs(angular), np.inf)
