"""The shape of a person: meshes of limbs and head, and one texture with colours and the face's photograph.

Lengths are shares of the person's height; a limb's frame is at its upper joint, x forward, y to the left, z up, the
limb hanging down. Shapes are few and coarse: with several people in view, drawing must still keep the camera's rate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from app.robots.simulated.scenery.faces import EYES_PX, FACES, MIDDLE_PX, MOUTH_PX, face_picture
from app.robots.simulated.scenery.gait import EYES_SHARE, FOREARM, MOUTH_SHARE, NECK_SHARE, SHIN, THIGH, UPPER_ARM
from app.robots.simulated.scenery.textures import Texture
from app.robots.simulated.world_config import Color

HEAD_MIDDLE, HEAD_AHEAD = 0.935, 0.006
_HEAD_RADII = (0.056, 0.0495, 0.064)
_HAIR_THICKNESS = 0.004
_AROUND, _UP = 20, 12
_PX_PER_SHARE = (MOUTH_PX - EYES_PX) / (EYES_SHARE - MOUTH_SHARE)
_TEXTURE_SIZE, _PALETTE_ROWS = (224, 384), 32
PaletteColor = Literal["shirt", "trousers", "shoes", "skin"]
PALETTE: tuple[PaletteColor, ...] = ("shirt", "trousers", "shoes", "skin")


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """``vertices`` (V, 3) float64; ``faces`` (F, 3) int of triangles, counter-clockwise from outside; ``texture``
    (V, 2) float64: where in the person's :func:`skin`, from its upper left (0, 0) to its lower right (1, 1).
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.int64]
    texture: NDArray[np.float64]


Ring = tuple[float, float, float, float]
"""One cross-section of a limb: height z, half-extent along x and along y, and how far forward its middle lies."""

TORSO: tuple[Ring, ...] = (
    (-0.040, 0.070, 0.102, 0.000), (0.010, 0.068, 0.099, 0.000), (0.090, 0.060, 0.085, 0.004),
    (0.190, 0.068, 0.104, 0.004), (0.245, 0.060, 0.115, 0.000), (0.276, 0.050, 0.112, -0.002),
    (0.296, 0.040, 0.080, -0.004), (0.312, 0.034, 0.046, -0.004), (0.326, 0.032, 0.036, -0.003),
)  # fmt: skip
HIPS: tuple[Ring, ...] = (
    (-0.080, 0.030, 0.036, 0.000), (-0.052, 0.052, 0.074, 0.000), (-0.030, 0.058, 0.088, 0.000),
    (0.000, 0.060, 0.090, 0.000),
)  # fmt: skip
THIGH_RINGS: tuple[Ring, ...] = (
    (-THIGH - 0.012, 0.026, 0.026, 0.000), (-THIGH, 0.033, 0.032, 0.000), (-0.120, 0.044, 0.042, 0.000),
    (-0.040, 0.050, 0.045, 0.000), (0.010, 0.042, 0.036, 0.000),
)  # fmt: skip
SHIN_RINGS: tuple[Ring, ...] = (
    (-SHIN + 0.010, 0.028, 0.026, 0.000), (-0.150, 0.030, 0.028, -0.002), (-0.080, 0.034, 0.031, -0.004),
    (0.000, 0.033, 0.032, 0.000), (0.014, 0.024, 0.024, 0.000),
)  # fmt: skip
UPPER_ARM_RINGS: tuple[Ring, ...] = (
    (-UPPER_ARM - 0.008, 0.018, 0.018, 0.0), (-UPPER_ARM, 0.023, 0.022, 0.0), (-0.060, 0.028, 0.026, 0.0),
    (-0.020, 0.032, 0.028, 0.0), (0.006, 0.028, 0.024, 0.0), (0.022, 0.016, 0.013, -0.001),
)  # fmt: skip
FOREARM_RINGS: tuple[Ring, ...] = (
    (-FOREARM, 0.017, 0.015, 0.0), (-0.060, 0.022, 0.020, 0.0), (0.000, 0.022, 0.021, 0.0), (0.012, 0.015, 0.014, 0.0),
)  # fmt: skip
HAND_RINGS: tuple[Ring, ...] = (
    (-FOREARM - 0.088, 0.014, 0.006, 0.006), (-FOREARM - 0.055, 0.024, 0.009, 0.004),
    (-FOREARM - 0.022, 0.022, 0.011, 0.000), (-FOREARM + 0.004, 0.013, 0.011, 0.000),
)  # fmt: skip
NECK_RINGS: tuple[Ring, ...] = (
    (-0.040, 0.030, 0.034, -0.008), (0.000, 0.029, 0.032, -0.004), (0.045, 0.030, 0.033, 0.000),
)  # fmt: skip
SHOE_RINGS: tuple[Ring, ...] = (
    (-SHIN - 0.028, 0.076, 0.028, 0.034), (-SHIN - 0.018, 0.078, 0.030, 0.034), (-SHIN - 0.004, 0.060, 0.027, 0.022),
    (-SHIN + 0.016, 0.032, 0.026, 0.000), (-SHIN + 0.030, 0.026, 0.024, 0.000),
)  # fmt: skip


def lathe(rings: Sequence[Ring], color: PaletteColor, around: int = 8) -> Mesh:
    """A closed body of one color through elliptic ``rings``, from the lowest up, each of ``around`` corners."""
    angles = 2 * math.pi * np.arange(around) / around
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    layers = [
        np.column_stack([ahead + x * circle[:, 0], y * circle[:, 1], np.full(around, z)]) for z, x, y, ahead in rings
    ]
    ends = [[rings[0][3], 0.0, rings[0][0]], [rings[-1][3], 0.0, rings[-1][0]]]
    vertices = np.concatenate([*layers, np.array(ends)])
    bottom, top, last = len(vertices) - 2, len(vertices) - 1, (len(rings) - 1) * around
    faces: list[tuple[int, int, int]] = []
    for i in range(around):
        j = (i + 1) % around
        for layer in range(0, last, around):
            a, b, c, d = layer + i, layer + j, layer + around + i, layer + around + j
            faces += [(a, b, d), (a, d, c)]
        faces += [(bottom, j, i), (top, last + i, last + j)]
    middle = [(PALETTE.index(color) + 0.5) / len(PALETTE), 1.0 - _PALETTE_ROWS / (2 * _TEXTURE_SIZE[0])]
    return Mesh(vertices, np.array(faces), np.tile(middle, (len(vertices), 1)))


def joined(*meshes: Mesh) -> Mesh:
    """Several meshes as one: each drawn shape has a cost."""
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)]),
        np.concatenate([mesh.texture for mesh in meshes]),
    )


def head(face: str) -> Mesh:
    """The head in the neck's frame, with hair as in ``face``."""
    azimuths = 2 * math.pi * (np.arange(_AROUND + 1) / _AROUND - 0.5)
    levels = np.sin(math.pi * (np.arange(_UP + 1) / _UP - 0.5))
    level, azimuth = np.meshgrid(levels, azimuths, indexing="ij")
    x, y, z = head_surface(azimuth, level)
    thick = _HAIR_THICKNESS * hairiness(face, azimuth, level)
    grow = 1 + thick / np.maximum(np.hypot(x, y), 1e-3)
    vertices = np.stack([x * grow + HEAD_AHEAD, y * grow, z + thick * (level > 0.6) + HEAD_MIDDLE - NECK_SHARE], -1)
    head_rows = _TEXTURE_SIZE[0] - _PALETTE_ROWS
    down = np.clip((1 - level) / 2 * head_rows, 1, head_rows - 2) / _TEXTURE_SIZE[0]  # off the palette below
    texture = np.stack([azimuth / (2 * math.pi) + 0.5, down], axis=-1)
    rows = _AROUND + 1
    triangles: list[tuple[int, int, int]] = []
    for k in range(_UP):
        for i in range(_AROUND):
            a, b, c, d = k * rows + i, k * rows + i + 1, (k + 1) * rows + i, (k + 1) * rows + i + 1
            if k != 0:  # at the poles, one of the two has no area
                triangles.append((a, b, d))
            if k != _UP - 1:
                triangles.append((a, d, c))
    return Mesh(vertices.reshape(-1, 3), np.array(triangles), texture.reshape(-1, 2))


def head_surface(
    azimuth: NDArray[np.float64], level: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Points of the bald head about its middle: ``azimuth`` from the nose to the left, ``level`` -1 (chin) to 1."""
    rx, ry, rz = _HEAD_RADII
    low = np.minimum(level, 0.0)
    depth = (1 - np.abs(level) ** 2.6) ** (1 / 2.6)
    width = (1 - np.abs(level) ** 2.3) ** (1 / 2.3) * (1 + 0.10 * low)
    behind = np.cos(azimuth) < 0
    x = rx * depth * np.cos(azimuth) * np.where(behind, 1 + 0.35 * low, 1.0)
    return np.asarray(x), np.asarray(ry * width * np.sin(azimuth)), np.asarray(rz * level)


def hairiness(face: str, azimuth: NDArray[np.float64], level: NDArray[np.float64]) -> NDArray[np.float64]:
    """0 on skin, 1 on hair, beyond the photograph."""
    aside = np.abs(azimuth)
    down = FACES[face].hair_to
    line = np.interp(aside, np.radians([0, 55, 75, 100, 125, 180]), [0.72, 0.55, 0.2, 0.02, down, down])
    return np.asarray(_smooth((level - line) / 0.12))


def skin(face: str, clothes: Mapping[PaletteColor, Color], rng: np.random.Generator) -> Texture:
    """All of a person's colours in one picture (224, 384, 3) uint8: the head unrolled, and below it the palette."""
    palette = {**clothes, "skin": FACES[face].skin}
    width = _TEXTURE_SIZE[1]
    columns = np.array([palette[color] for color in PALETTE], dtype=np.uint8)
    below = np.repeat(columns[None], width // len(PALETTE), axis=1)
    return np.concatenate([_head_texture(face, rng), np.repeat(below, _PALETTE_ROWS, axis=0)])


def _head_texture(face: str, rng: np.random.Generator) -> Texture:
    """The photograph in front, skin and hair in its colours at the sides and behind."""
    look, picture = FACES[face], face_picture(face).astype(np.float64)
    height, width = _TEXTURE_SIZE[0] - _PALETTE_ROWS, _TEXTURE_SIZE[1]
    azimuth, level = np.meshgrid(
        2 * math.pi * ((np.arange(width) + 0.5) / width - 0.5), 1 - 2 * (np.arange(height) + 0.5) / height
    )
    _, y, z = head_surface(azimuth, level)
    hair = hairiness(face, azimuth, level)[..., None]
    strands = 1 + 0.10 * rng.standard_normal((1, width, 1)) + 0.04 * rng.standard_normal((height, width, 1))
    around = hair * np.array(look.hair) * strands + (1 - hair) * np.array(look.skin)
    column = MIDDLE_PX + _PX_PER_SHARE * y
    row = EYES_PX + _PX_PER_SHARE * (EYES_SHARE - HEAD_MIDDLE - z)
    photograph = _sample(picture, column, row)
    front = 1 - _smooth((np.abs(azimuth) - math.radians(62)) / math.radians(18))
    front *= 1 - _smooth((level - 0.80) / 0.12)
    mixed = front[..., None] * photograph + (1 - front[..., None]) * around
    return np.asarray(np.clip(mixed, 0, 255), dtype=np.uint8)


def _sample(picture: NDArray[np.float64], column: NDArray[np.float64], row: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bilinear."""
    rows, columns, _ = picture.shape
    c = np.clip(column, 0, columns - 1.001)
    r = np.clip(row, 0, rows - 1.001)
    i, j = r.astype(int), c.astype(int)
    a, b = (r - i)[..., None], (c - j)[..., None]
    upper = (1 - b) * picture[i, j] + b * picture[i, j + 1]
    lower = (1 - b) * picture[i + 1, j] + b * picture[i + 1, j + 1]
    return np.asarray((1 - a) * upper + a * lower)


def _smooth(x: NDArray[np.float64]) -> NDArray[np.float64]:
    t = np.clip(x, 0.0, 1.0)
    return np.asarray(t * t * (3 - 2 * t))
