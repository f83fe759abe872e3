"""Where the parts of a body are that its joints move: capsules about collision shapes, their outline on the floor, and
which points of a camera are on them. Pure functions of joint positions."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.collision_shapes import CollisionShape
from app.base.kinematic_model import KinematicModel

Corners = tuple[tuple[float, float], ...]

#: Joints that moved less (rad, m) leave an outline as it is: 6 mm at the hand.
_MOVED_RAD = 0.01

#: Corners of a hull are whole multiples of this (m).
_GRAIN_M = 1e-6
#: Corners of the polygon about a circle: its corners lie 3.5 % outside.
_CORNERS = 12
_TURNS = 2 * math.pi / _CORNERS * np.arange(_CORNERS)
_CIRCLE = np.stack((np.cos(_TURNS), np.sin(_TURNS)), axis=-1) / math.cos(math.pi / _CORNERS)


@dataclass(frozen=True, slots=True, eq=False)
class Capsules:
    """Capsules in ``base_link``: ``ends`` (N, 2, 3) m of their segments, ``radii`` (N,) m about them."""

    ends: NDArray[np.float64]
    radii: NDArray[np.float64]

    def contains(self, points: NDArray[np.float64], margin_m: float = 0.0) -> NDArray[np.bool_]:
        """Which of ``points`` (M, 3) m in ``base_link`` are in one of them, or within ``margin_m`` of it; (M,)."""
        inside = np.zeros(len(points), dtype=np.bool_)
        for (begin, end), radius in zip(self.ends, self.radii, strict=True):
            along = end - begin
            beside = points - begin
            share = np.clip(beside @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
            apart = beside - share[:, None] * along
            inside |= (apart * apart).sum(axis=1) <= (radius + margin_m) ** 2
        return inside


class MovingShapes:
    """The ``shapes`` of ``model`` on links that ``joints`` move, by name."""

    def __init__(self, model: KinematicModel, shapes: Sequence[CollisionShape], joints: Collection[str]) -> None:
        self._model = model
        moving = {shape.link: set(model.moved_by(shape.link)).intersection(joints) for shape in shapes}
        moved = [shape for shape in shapes if moving[shape.link]]
        #: Those of the joints that move a shape.
        self.joints = tuple(joint for joint in joints if any(joint in by for by in moving.values()))
        self.links = tuple(dict.fromkeys(shape.link for shape in moved))
        self._capsules = [(shape.link, *shape.capsule()) for shape in moved]
        self._radii = np.array([radius for _, _, _, radius in self._capsules])

    def at(self, positions: Mapping[str, float]) -> Capsules:
        """Where they are at joint ``positions`` (rad, m) by name; missing ones are 0."""
        poses = self._model.poses(self.links, positions)
        ends = [poses[link].transform(np.stack((begin, end))) for link, begin, end, _ in self._capsules]
        return Capsules(np.array(ends, dtype=np.float64).reshape(-1, 2, 3), self._radii)

    def reaches(self) -> list[tuple[float, float, float]]:
        """Circles on the floor that no position of the joints leaves: x, y (m in ``base_link``) of the first joint
        that moves a link, and the radius (m) to which the rest of the chain could be stretched."""
        circles: list[tuple[float, float, float]] = []
        for link, begin, end, radius in self._capsules:
            chain = self._model.chain(link)
            first = next(number for number, joint in enumerate(chain) if joint.moves)
            stretched = radius + max(float(np.linalg.norm(begin)), float(np.linalg.norm(end)))
            stretched += sum(float(np.linalg.norm(joint.X_PJ.translation)) for joint in chain[first + 1 :])
            stretched += sum(
                max(abs(joint.lower), abs(joint.upper)) for joint in chain[first:] if joint.kind == "prismatic"
            )
            origin = self._model.pose(chain[first].parent) @ chain[first].X_PJ
            circles.append((float(origin.translation[0]), float(origin.translation[1]), stretched))
        return circles


class BodyOutline:
    """The outline of a body on the floor: the convex hull of its ``footprint`` and of what its joints move above it."""

    def __init__(self, footprint: Corners, shapes: MovingShapes) -> None:
        """``footprint`` as ``RobotDescription.footprint``."""
        self._footprint = footprint
        self._shapes = shapes
        #: The joints whose positions change it.
        self.joints = shapes.joints
        corners = np.array(footprint)
        sides = np.roll(corners, -1, axis=0) - corners
        self._normals = np.stack((sides[:, 1], -sides[:, 0]), axis=-1)
        self._offsets = (self._normals * corners).sum(axis=1)
        #: The outline (m, counter-clockwise) around every position of the joints.
        self.widest = self._around(
            np.array([(x, y) for x, y, _ in shapes.reaches()]).reshape(-1, 2),
            np.array([radius for _, _, radius in shapes.reaches()]),
        )

    def at(self, positions: Mapping[str, float]) -> Corners:
        """The outline (m in ``base_link``, convex, counter-clockwise) at joint ``positions`` (rad, m) by name: the
        footprint itself, as long as nothing hangs over it."""
        capsules = self._shapes.at(positions)
        return self._around(capsules.ends[:, :, :2].reshape(-1, 2), np.repeat(capsules.radii, 2))

    def changed(self, before: Mapping[str, float], now: Mapping[str, float]) -> bool:
        """Whether the outline at joint positions ``now`` (rad, m) by name may differ from the one at ``before``."""
        return any(abs(now.get(name, 0.0) - before.get(name, 0.0)) > _MOVED_RAD for name in self.joints)

    def _around(self, centres: NDArray[np.float64], radii: NDArray[np.float64]) -> Corners:
        points = (centres[:, None, :] + radii[:, None, None] * _CIRCLE).reshape(-1, 2)
        beyond = (points @ self._normals.T > self._offsets).any(axis=1)
        if not beyond.any():
            return self._footprint
        return convex_hull([*self._footprint, *((float(x), float(y)) for x, y in points[beyond])])


def convex_hull(points: Collection[tuple[float, float]]) -> Corners:
    """The corners of the convex hull of ``points`` (m, rounded to micrometres), counter-clockwise, none of them in line
    with its neighbours (Andrew's monotone chain)."""
    # On whole numbers every turn is exact: a tolerance would drop the end of a side that is upright but for rounding.
    ordered = sorted({(round(x / _GRAIN_M), round(y / _GRAIN_M)) for x, y in points})

    def half(along: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
        chain: list[tuple[int, int]] = []
        for x, y in along:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0:
                    break
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    return tuple((x * _GRAIN_M, y * _GRAIN_M) for x, y in (*half(ordered), *half(ordered[::-1])))
