"""What a point of a view shows: a ray from its camera against posters, walls, what was seen, and the floor. Pure.

What is picked is what is drawn: the boxes of the cards and of the walls, the voxels. Only a poster is picked from a
little beside its card, for a finger is wider than a card that is far away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import Pose2
from app.console.view.viewpoints import Shot
from app.console.view.voxels import VOXEL_M
from app.messages import Landmark

#: The card at a poster's place (m).
POSTER_M = (0.22, 0.22, 0.28)
#: A poster is picked from so far (rad) beside its card, and through what is before it by no more than this (m).
_BESIDE_RAD, _THROUGH_M = 0.01, 0.15
#: A voxel counts this much (m) beyond its sides: between two of one surface no ray gets through.
_GAP_M = 0.5 * VOXEL_M
#: Voxels with their middle below this (m) are of the floor, which is even.
_FLOOR_M = 0.08
#: The floor is picked as far away as this (m).
FARTHEST_M = 40.0

Kind: TypeAlias = Literal["poster", "wall", "seen", "floor", "nothing"]
Boxes: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True, slots=True, eq=False)
class Ray:
    """From ``origin`` (3,) m along ``direction`` (3,), a unit vector."""

    origin: NDArray[np.float64]
    direction: NDArray[np.float64]

    def at(self, distance: float) -> NDArray[np.float64]:
        """The point (3,) ``distance`` m from its origin."""
        return self.origin + distance * self.direction

    def in_frame(self, X_AB: Pose2) -> Ray:
        """This ray of B in A."""
        X = X_AB.to_pose3()
        return Ray(X.transform(self.origin[None])[0], X.rotation @ self.direction)


@dataclass(frozen=True, slots=True, eq=False)
class Pickable:
    """What there is to pick: ``posters`` in their frame, ``X_OP``; ``walls``: least and greatest corners (N, 3), m on
    the map, which lies at ``X_OM``; ``voxels``: middles (N, 3), m in O."""

    posters: tuple[Landmark, ...]
    X_OP: Pose2
    walls: Boxes
    X_OM: Pose2
    voxels: NDArray[np.floating]


@dataclass(frozen=True, slots=True)
class Pick:
    """What was picked, at ``p`` (m in ``frame``; None: nothing); ``poster``: the one that it is."""

    kind: Kind
    p: tuple[float, float, float] | None = None
    poster: Landmark | None = None
    frame: Literal["odom", "map"] = "odom"

    def on_map(self, X_OM: Pose2) -> Pick:
        """This one of O on the map, which lies at ``X_OM``."""
        if self.p is None:
            return self
        return replace(self, p=_point(X_OM.inverse().to_pose3().transform(np.array([self.p]))[0]), frame="map")


def ray_through(shot: Shot, aspect: float, u: float, v: float) -> Ray:
    """The ray of the camera ``shot`` through a point of its picture, in the frame of ``shot``: ``u`` and ``v`` are
    shares (0 to 1) of the width from the left and of the height from the top, ``aspect`` is width over height."""
    eye = np.array(shot.eye)
    forward = np.array(shot.target) - eye
    forward /= np.linalg.norm(forward)
    # Its elevation is less than a right angle, so that there is a right.
    right = np.array([forward[1], -forward[0], 0.0]) / math.hypot(forward[0], forward[1])
    down = np.cross(forward, right)
    half = math.tan(0.5 * shot.fov)
    direction = forward + (2.0 * u - 1.0) * half * aspect * right + (2.0 * v - 1.0) * half * down
    return Ray(eye, direction / np.linalg.norm(direction))


def distances(ray: Ray, boxes: Boxes) -> NDArray[np.float64]:
    """Where ``ray`` enters each of ``boxes``, least and greatest corners (N, 3): (N,) m, infinite where it misses, 0
    from within."""
    low, high = boxes
    along = ray.direction == 0.0
    step = np.where(along, 1.0, ray.direction)
    first, second = (low - ray.origin) / step, (high - ray.origin) / step
    # Between two sides that it runs along it is all the way, or never.
    never = np.where((low <= ray.origin) & (ray.origin <= high), -np.inf, np.inf)
    enters = np.where(along, never, np.minimum(first, second)).max(axis=1)
    leaves = np.where(along, -never, np.maximum(first, second)).min(axis=1)
    return np.where((enters <= leaves) & (leaves >= 0.0), np.maximum(enters, 0.0), np.inf)


def picked(ray: Ray, world: Pickable) -> Pick:
    """The first thing on ``ray`` of O."""
    wall, seen = _nearest(ray.in_frame(world.X_OM.inverse()), world.walls), _nearest(ray, _voxel_boxes(world.voxels))
    floor = _floor(ray)
    kinds: tuple[tuple[Kind, float], ...] = (("wall", wall), ("seen", seen), ("floor", floor))
    kind, distance = min(kinds, key=lambda each: each[1])
    poster, away = _poster(ray.in_frame(world.X_OP.inverse()), world.posters)
    if poster is not None and away <= distance + _THROUGH_M:
        middle = world.X_OP.to_pose3().transform(np.array([poster.p_FQ]))[0]
        return Pick("poster", _point(middle), poster)
    if math.isinf(distance):
        return Pick("nothing")
    return Pick(kind, _point(ray.at(distance)))


def _poster(ray: Ray, posters: tuple[Landmark, ...]) -> tuple[Landmark | None, float]:
    """The poster on ``ray``, both in the posters' frame, and how far away its card is (m). Of several beside which it
    passes, one that it meets; of those the nearest."""
    if not posters:
        return None, math.inf
    middles = np.array([poster.p_FQ for poster in posters])
    half = 0.5 * np.array(POSTER_M)
    met = distances(ray, (middles - half, middles + half))
    if np.isinf(met).all():
        beside = half + _BESIDE_RAD * np.linalg.norm(middles - ray.origin, axis=1)[:, None]
        met = distances(ray, (middles - beside, middles + beside))
    nearest = int(np.argmin(met))
    return (None, math.inf) if math.isinf(met[nearest]) else (posters[nearest], float(met[nearest]))


def _voxel_boxes(middles: NDArray[np.floating]) -> Boxes:
    standing = middles[middles[:, 2] >= _FLOOR_M].astype(np.float64)
    half = 0.5 * VOXEL_M + _GAP_M
    return standing - half, standing + half


def _nearest(ray: Ray, boxes: Boxes) -> float:
    return float(distances(ray, boxes).min(initial=math.inf))


def _floor(ray: Ray) -> float:
    down = -float(ray.direction[2])
    height = float(ray.origin[2])
    distance = height / down if down > 0.0 and height > 0.0 else math.inf
    return distance if distance <= FARTHEST_M else math.inf


def _point(p: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in p)
    return x, y, max(z, 0.0) + 0.0
