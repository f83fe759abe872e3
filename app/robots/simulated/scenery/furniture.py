"""Furniture as parts: each kind is a pure function from its size to boxes, cylinders and ellipsoids.

A piece's frame lies on the floor in its middle: x along its length, y along its width (its front looks to -y),
z up. Sizes are full lengths in metres.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.random import Generator

Vector = tuple[float, float, float]
Shape = Literal["box", "cylinder", "ellipsoid"]


@dataclass(frozen=True, slots=True)
class Part:
    """One shape: ``size`` is its full extent along x, y, z (a cylinder's axis is z); ``rpy`` turns it (rad).

    ``material`` names a material of the world or is an RGB colour in 0..1; ``solid`` parts are touched by the physics.
    """

    shape: Shape
    at: Vector
    size: Vector
    material: str | Vector
    rpy: Vector = (0.0, 0.0, 0.0)
    solid: bool = True


@dataclass(frozen=True, slots=True)
class Order:
    """Arguments of a kind: size, material of its main surface, and a random generator for variety."""

    size: Vector
    material: str | Vector
    rng: Generator = field(repr=False)


STEEL: Vector = (0.45, 0.47, 0.50)
DOCK_BLOCK_M, DOCK_CONTACTS_M = 0.09, 0.13
"""How far (m) a dock's block, and the contacts that stand out of it, reach out from where its plates meet."""
BLACK: Vector = (0.10, 0.10, 0.11)
WHITE: Vector = (0.88, 0.88, 0.86)


def furnish(
    kind: str, size: Vector | None, material: str | None, rng: Generator, materials: frozenset[str]
) -> list[Part]:
    """The parts of one piece of a kind in :data:`KINDS`; a surface whose material is missing gets a colour."""
    build, usual_size, usual_material, usual_color = _KINDS[kind]
    surface: str | Vector = material or (usual_material if usual_material in materials else usual_color)
    return build(Order(size or usual_size, surface, rng))


def _table(o: Order) -> list[Part]:
    length, width, height = o.size
    parts = [Part("box", (0, 0, height - 0.02), (length, width, 0.04), o.material)]
    for x in (-1, 1):
        for y in (-1, 1):
            at = (x * (length / 2 - 0.06), y * (width / 2 - 0.06), height / 2 - 0.02)
            parts.append(Part("box", at, (0.05, 0.05, height - 0.04), STEEL))
    return parts


def _desk(o: Order) -> list[Part]:
    length, width, height = o.size
    parts = _table(o)
    parts.append(Part("box", (length / 2 - 0.25, 0.05, 0.35), (0.4, width - 0.15, 0.6), WHITE))
    screen = float(o.rng.uniform(-0.25, 0.05))
    parts += [
        Part("box", (screen, width / 2 - 0.2, height + 0.26), (0.56, 0.03, 0.34), BLACK),
        Part("box", (screen, width / 2 - 0.217, height + 0.26), (0.53, 0.31, 0.004), "screen", (np.pi / 2, 0, 0)),
        Part("box", (screen, width / 2 - 0.18, height + 0.05), (0.05, 0.03, 0.1), BLACK),
        Part("cylinder", (screen, width / 2 - 0.2, height + 0.006), (0.22, 0.22, 0.012), BLACK),
        Part("box", (screen, -0.08, height + 0.01), (0.42, 0.14, 0.02), BLACK),
        Part("cylinder", (screen + 0.4, 0.0, height + 0.05), (0.08, 0.08, 0.1), tuple(o.rng.uniform(0.2, 0.9, 3))),
    ]
    return parts


def _shelf(o: Order) -> list[Part]:
    length, width, height = o.size
    parts = [
        Part("box", (0, width / 2 - 0.01, height / 2), (length, 0.02, height), o.material),
        Part("box", (-length / 2 + 0.015, 0, height / 2), (0.03, width, height), o.material),
        Part("box", (length / 2 - 0.015, 0, height / 2), (0.03, width, height), o.material),
    ]
    boards = max(2, round(height / 0.37) + 1)
    gap = (height - 0.06) / (boards - 1)
    for board in range(boards):
        parts.append(Part("box", (0, 0, 0.04 + board * gap), (length, width, 0.025), o.material))
        if board == boards - 1:
            continue
        share = float(o.rng.uniform(0.45, 0.95)) * (length - 0.1)
        left = -length / 2 + 0.05
        tall = gap * 0.78
        middle = (left + share / 2, 0.02, 0.055 + board * gap + tall / 2)
        parts.append(Part("box", middle, (share, tall, width * 0.7), "books", (np.pi / 2, 0, 0)))
        rest = length - 0.1 - share
        if rest > 0.2:
            at = (left + share + rest / 2 + 0.02, 0.0, 0.052 + board * gap + 0.08)
            parts.append(Part("box", at, (min(rest, 0.3) * 0.7, 0.18, 0.16), tuple(o.rng.uniform(0.2, 0.85, 3))))
    return parts


def _chair(o: Order) -> list[Part]:
    length, width, height = o.size
    seat = 0.45
    parts = [
        Part("box", (0, 0, seat), (length, width, 0.05), o.material),
        Part(
            "box",
            (0, width / 2 - 0.02, (seat + height) / 2 + 0.08),
            (length * 0.9, 0.04, height - seat - 0.1),
            o.material,
        ),
    ]
    for x in (-1, 1):
        parts.append(Part("box", (x * (length / 2 - 0.03), width / 2 - 0.025, height / 2), (0.03, 0.03, height), STEEL))
        parts.append(Part("box", (x * (length / 2 - 0.03), -width / 2 + 0.03, seat / 2), (0.03, 0.03, seat), STEEL))
    return parts


def _office_chair(o: Order) -> list[Part]:
    length, width, height = o.size
    parts = [
        Part("box", (0, 0, 0.48), (length * 0.8, width * 0.8, 0.08), o.material),
        Part(
            "box", (0, width * 0.36, 0.48 + (height - 0.48) / 2 + 0.06), (length * 0.7, 0.06, height - 0.56), o.material
        ),
        Part("cylinder", (0, 0, 0.27), (0.06, 0.06, 0.38), STEEL),
        Part("box", (0, width * 0.38, 0.55), (0.06, 0.04, 0.2), BLACK),
    ]
    for spoke in range(5):
        angle = 2 * np.pi * spoke / 5
        x, y = 0.16 * np.cos(angle), 0.16 * np.sin(angle)
        parts.append(Part("box", (float(x), float(y), 0.085), (0.3, 0.04, 0.03), BLACK, (0, 0, float(angle))))
        parts.append(Part("cylinder", (float(1.8 * x), float(1.8 * y), 0.035), (0.05, 0.05, 0.07), BLACK))
    return parts


def _plant(o: Order) -> list[Part]:
    length, _, height = o.size
    pot = min(0.38, 0.35 * height)
    parts = [
        Part("cylinder", (0, 0, pot / 2), (length * 0.55, length * 0.55, pot), (0.62, 0.33, 0.22)),
        Part("cylinder", (0, 0, pot - 0.005), (length * 0.6, length * 0.6, 0.05), (0.52, 0.27, 0.18)),
        Part("cylinder", (0, 0, (pot + height * 0.7) / 2), (0.035, 0.035, height * 0.7 - pot), (0.33, 0.24, 0.15)),
    ]
    for _ in range(9):
        angle, out = float(o.rng.uniform(0, 2 * np.pi)), float(o.rng.uniform(0.05, 0.3)) * length
        z = float(o.rng.uniform(pot + 0.15, height - 0.1))
        size = float(o.rng.uniform(0.35, 0.6)) * length
        tilt = (float(o.rng.uniform(-0.6, 0.6)), float(o.rng.uniform(-0.6, 0.6)), angle)
        at = (out * float(np.cos(angle)), out * float(np.sin(angle)), z)
        parts.append(Part("ellipsoid", at, (size, size * 0.6, size * 0.5), o.material, tilt, solid=False))
    return parts


def _cabinet(o: Order) -> list[Part]:
    length, width, height = o.size
    parts = [Part("box", (0, 0, height / 2), (length, width, height), o.material)]
    doors = max(1, round(length / 0.5))
    for door in range(doors):
        x = -length / 2 + (door + 0.5) * length / doors
        front = (x, -width / 2 - 0.006, height / 2)
        parts.append(Part("box", front, (length / doors - 0.02, height - 0.06, 0.012), o.material, (np.pi / 2, 0, 0)))
        handle = (x + 0.35 * length / doors, -width / 2 - 0.025, height * 0.55)
        parts.append(Part("box", handle, (0.02, 0.025, 0.14), STEEL))
    return parts


def _sofa(o: Order) -> list[Part]:
    length, width, height = o.size
    parts = [
        Part("box", (0, 0, 0.2), (length, width, 0.28), o.material),
        Part("box", (0, width / 2 - 0.1, height / 2 + 0.1), (length, 0.2, height - 0.2), o.material),
    ]
    for x in (-1, 1):
        parts += [Part("box", (x * (length / 2 - 0.08), 0, 0.3), (0.16, width, 0.5), o.material)]
    seats = max(1, round(length / 0.75))
    cushion = (length - 0.36) / seats
    for seat in range(seats):
        middle = -length / 2 + 0.18 + (seat + 0.5) * cushion
        parts += [Part("box", (middle, -0.05, 0.39), (cushion - 0.02, width - 0.3, 0.12), o.material)]
    return parts


def _box(o: Order) -> list[Part]:
    return [Part("box", (0, 0, o.size[2] / 2), o.size, o.material)]


def _crate(o: Order) -> list[Part]:
    length, width, height = o.size
    parts = [Part("box", (0, 0, height / 2), (length - 0.03, width - 0.03, height - 0.01), o.material)]
    for z in (0.05, height - 0.04):
        parts += [Part("box", (0, 0, z), (length, width, 0.05), (0.45, 0.32, 0.18))]
    return parts


def _cylinder(o: Order) -> list[Part]:
    return [Part("cylinder", (0, 0, o.size[2] / 2), o.size, o.material)]


def _bin(o: Order) -> list[Part]:
    length, _, height = o.size
    rim = (length * 1.08, length * 1.08, 0.03)
    return [*_cylinder(o), Part("cylinder", (0, 0, height), rim, BLACK)]


def _suitcase(o: Order) -> list[Part]:
    length, width, height = o.size
    return [
        Part("box", (0, 0, height / 2 + 0.02), (length, width, height), o.material),
        Part("box", (0, 0, height / 2 + 0.02), (length * 1.01, width * 1.02, 0.02), STEEL),
        Part("box", (0, -width / 2 - 0.02, height / 2 + 0.02), (0.14, 0.03, 0.03), BLACK),
    ]


def _flat(o: Order) -> list[Part]:
    """A picture, board or window: its lower edge at the piece's z, its face to -y."""
    length, depth, height = o.size
    face = (0.0, -depth / 2 - 0.002, height / 2)
    return [
        Part("box", (0, 0, height / 2), o.size, (0.3, 0.3, 0.32), solid=False),
        Part("box", face, (length, height, 0.004), o.material, (np.pi / 2, 0, 0), solid=False),
    ]


def _workbench(o: Order) -> list[Part]:
    length, width, height = o.size
    parts = _table(o)
    parts.append(Part("box", (0, 0, 0.18), (length - 0.1, width - 0.1, 0.03), STEEL))
    for _ in range(6):
        x, y = float(o.rng.uniform(-0.45, 0.45)) * length, float(o.rng.uniform(-0.3, 0.3)) * width
        size = o.rng.uniform(0.06, 0.24, 3)
        color = tuple(o.rng.uniform(0.1, 0.9, 3))
        shape: Shape = "box" if o.rng.uniform() < 0.6 else "cylinder"
        parts.append(Part(shape, (x, y, height + float(size[2]) / 2), (size[0], size[1], size[2]), color))
    return parts


def _robot_arm(o: Order) -> list[Part]:
    orange: Vector = (0.92, 0.45, 0.08)
    height = o.size[2]
    return [
        Part("box", (0, 0, 0.35), (0.5, 0.5, 0.7), o.material),
        Part("cylinder", (0, 0, 0.78), (0.26, 0.26, 0.16), BLACK),
        Part("cylinder", (0.1, 0, 0.8 + 0.3 * (height - 0.8)), (0.14, 0.14, 0.5), orange, (0, 0.35, 0)),
        Part("ellipsoid", (0.2, 0, 1.22), (0.2, 0.2, 0.2), BLACK),
        Part("cylinder", (0.0, 0, 1.35), (0.11, 0.11, 0.5), orange, (0, -1.05, 0)),
        Part("box", (-0.23, 0, 1.47), (0.1, 0.14, 0.1), STEEL),
    ]


def _dock(o: Order) -> list[Part]:
    """A charging dock: two upright plates meet in a V of 120° at the piece's origin, open to its front; below, a block
    with two contacts that stand out of it. ``size``: width of the V's mouth, depth of the block, height."""
    mouth, depth, height = o.size
    half, thick, tall = np.pi / 3, 0.02, 0.2
    plate = mouth / 2 / np.sin(half)
    parts = [
        Part("box", (0, depth / 2 - DOCK_BLOCK_M, 0.12), (0.3, depth, 0.24), STEEL),
        Part("box", (0, 0.06, height / 2), (0.08, 0.08, height), STEEL),
    ]
    for side in (-1, 1):
        # The plate's face is the V's line; its thickness is behind.
        turn = side * (half - np.pi / 2)
        x, y = side * plate / 2 * np.sin(half), -plate / 2 * np.cos(half)
        middle = (x + side * thick / 2 * np.cos(half), y + thick / 2 * np.sin(half), height - tall / 2)
        parts.append(Part("box", middle, (plate, thick, tall), o.material, (0, 0, turn)))
        contact = (side * 0.08, -(DOCK_BLOCK_M + DOCK_CONTACTS_M) / 2, 0.14)
        size = (0.03, DOCK_CONTACTS_M - DOCK_BLOCK_M, 0.02)
        parts.append(Part("box", contact, size, (0.8, 0.6, 0.2), solid=False))
    return parts


def _extinguisher(o: Order) -> list[Part]:
    height = o.size[2]
    return [
        Part("cylinder", (0, 0, height / 2), (0.15, 0.15, height), (0.75, 0.08, 0.07)),
        Part("cylinder", (0, 0, height + 0.04), (0.05, 0.05, 0.08), BLACK),
    ]


_Kind = tuple[Callable[[Order], list[Part]], Vector, str, Vector]
_KINDS: dict[str, _Kind] = {
    "table": (_table, (1.6, 0.8, 0.74), "oak", (0.6, 0.45, 0.3)),
    "desk": (_desk, (1.5, 0.75, 0.74), "oak", (0.6, 0.45, 0.3)),
    "shelf": (_shelf, (1.2, 0.32, 1.9), "oak", (0.55, 0.4, 0.26)),
    "chair": (_chair, (0.44, 0.46, 0.88), "beech", (0.7, 0.5, 0.3)),
    "office_chair": (_office_chair, (0.58, 0.58, 1.05), "fabric", (0.18, 0.24, 0.36)),
    "plant": (_plant, (0.7, 0.7, 1.5), "leaves", (0.2, 0.45, 0.18)),
    "cabinet": (_cabinet, (0.9, 0.45, 1.1), "birch", (0.75, 0.68, 0.55)),
    "sofa": (_sofa, (1.9, 0.85, 0.8), "fabric", (0.5, 0.2, 0.2)),
    "box": (_box, (0.4, 0.3, 0.25), "cardboard", (0.7, 0.55, 0.36)),
    "crate": (_crate, (0.5, 0.35, 0.3), "beech", (0.65, 0.5, 0.3)),
    "pillar": (_cylinder, (0.4, 0.4, 2.7), "concrete", (0.6, 0.6, 0.6)),
    "stool": (_cylinder, (0.4, 0.4, 0.3), "fabric", (0.65, 0.3, 0.15)),
    "bin": (_bin, (0.28, 0.28, 0.36), "bin", (0.25, 0.35, 0.3)),
    "suitcase": (_suitcase, (0.6, 0.4, 0.24), "suitcase", (0.12, 0.3, 0.45)),
    "picture": (_flat, (0.9, 0.03, 0.65), "picture", (0.4, 0.5, 0.6)),
    "whiteboard": (_flat, (1.8, 0.03, 1.0), "whiteboard", (0.95, 0.95, 0.95)),
    "window": (_flat, (1.6, 0.04, 1.3), "window", (0.7, 0.8, 0.9)),
    "workbench": (_workbench, (1.8, 0.75, 0.9), "beech", (0.65, 0.5, 0.3)),
    "robot_arm": (_robot_arm, (0.6, 0.5, 1.6), "dark_steel", (0.3, 0.32, 0.35)),
    "dock": (_dock, (0.433, 0.2, 0.5), "yellow", (0.85, 0.7, 0.2)),
    "extinguisher": (_extinguisher, (0.15, 0.15, 0.45), "red", (0.75, 0.08, 0.07)),
}

KINDS = tuple(sorted(_KINDS))
"""Every kind of furniture there is."""


def usual_size(kind: str) -> tuple[float, float, float]:
    """Length, width and height (m) of a piece of this kind whose size is not given."""
    return _KINDS[kind][1]
