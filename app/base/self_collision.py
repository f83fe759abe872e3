"""Self-collision: how far the links that some joints move are from the rest of the body. Pure functions on the model.

The moving links' shapes are covered by spheres along their longest sides; the others are the solids that they are. What
overlaps at position 0 (a link and the one it is mounted in) does not count, nor does a moving link beside another.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.collision_shapes import CollisionShape
from app.base.kinematic_model import KinematicModel

Array = NDArray[np.float64]

#: Between spheres of a moving shape (m): half of it is what a flat surface may sink between two of them, squared, over
#: twice the radius: 1 mm for an arm of 5 cm.
_SPACING_M = 0.02


@dataclass(frozen=True, slots=True)
class Clearance:
    """The least distance (m) of a posture, 0 or less where links touch, and the two links."""

    distance_m: float
    moving: str
    other: str


class SelfCollision:
    """Clearance of the links of ``model`` that ``joints`` move, by name, from all other links with ``shapes``."""

    def __init__(self, model: KinematicModel, shapes: Sequence[CollisionShape], joints: Collection[str]) -> None:
        self._model = model
        self._joints = tuple(joints)
        moved = {shape.link: bool(set(model.moved_by(shape.link)).intersection(joints)) for shape in shapes}
        self._links = tuple(dict.fromkeys(shape.link for shape in shapes if moved[shape.link]))
        self._chains = {link: model.chain(link) for link in self._links}
        self._spheres = {link: [_spheres(shape) for shape in shapes if shape.link == link] for link in self._links}
        self._others = tuple(shape for shape in shapes if not moved[shape.link])
        self._ignored: frozenset[tuple[str, str]] = frozenset()
        distances, pairs = self._distances(np.zeros((1, len(self._joints))), {})
        self._ignored = frozenset(pair for pair, distance in zip(pairs, distances[:, 0], strict=True) if distance < 0)

    def clearances(self, postures: Array, measured: Mapping[str, float]) -> list[Clearance]:
        """The clearance of each of ``postures`` (N, J) rad of the joints, in their order; all other joints are where
        they are ``measured``, by name (missing ones at 0)."""
        distances, pairs = self._distances(postures, measured)
        if not pairs:
            return [Clearance(np.inf, "", "")] * len(postures)
        nearest = np.argmin(distances, axis=0)
        return [Clearance(float(distances[pair, n]), *pairs[pair]) for n, pair in enumerate(nearest)]

    def _distances(self, postures: Array, measured: Mapping[str, float]) -> tuple[Array, list[tuple[str, str]]]:
        """Distances (P, N) of the pairs of links, and the pairs."""
        columns = {name: postures[:, column] for column, name in enumerate(self._joints)}
        others = [(shape, (self._model.pose(shape.link, measured) @ shape.X_LS).inverse()) for shape in self._others]
        distances: list[Array] = []
        pairs: list[tuple[str, str]] = []
        for link, spheres in self._spheres.items():
            rotation, translation = self._poses(link, columns, measured, len(postures))
            for centres, radius in spheres:
                p_B = np.einsum("nij,kj->nki", rotation, centres) + translation[:, None, :]
                for shape, X_SB in others:
                    if (link, shape.link) not in self._ignored:
                        distances.append(shape.distance(X_SB.transform(p_B)).min(axis=1) - radius)
                        pairs.append((link, shape.link))
        return np.array(distances).reshape(len(pairs), len(postures)), pairs

    def _poses(
        self, link: str, columns: Mapping[str, Array], measured: Mapping[str, float], number: int
    ) -> tuple[Array, Array]:
        """Rotations (N, 3, 3) and translations (N, 3) of ``link`` in the root link."""
        rotation, translation = np.broadcast_to(np.eye(3), (number, 3, 3)), np.zeros((number, 3))
        for joint in self._chains[link]:
            if joint.name not in columns:
                X_PC = joint.pose(self._model.position(joint.name, measured))
                translation = translation + rotation @ X_PC.translation
                rotation = rotation @ X_PC.rotation
                continue
            translation = translation + rotation @ joint.X_PJ.translation
            rotation = rotation @ joint.X_PJ.rotation
            if joint.kind == "prismatic":
                translation = translation + (rotation @ joint.axis) * columns[joint.name][:, None]
            else:
                rotation = rotation @ _rotations(joint.axis, columns[joint.name])
        return np.asarray(rotation), translation


def _spheres(shape: CollisionShape) -> tuple[Array, float]:
    """Centres (K, 3) in the link and the radius (m) of spheres that cover the shape."""
    begin, end, radius = shape.capsule()
    number = 1 + int(np.ceil(np.linalg.norm(end - begin) / _SPACING_M))
    return np.linspace(begin, end, number), radius


def _rotations(axis: Array, angles: Array) -> Array:
    """Rotation matrices (N, 3, 3) by ``angles`` (N,) rad about the unit vector ``axis`` (Rodrigues' formula)."""
    x, y, z = (float(value) for value in axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, versine = np.sin(angles)[:, None, None], 1.0 - np.cos(angles)[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + versine * (cross @ cross))
