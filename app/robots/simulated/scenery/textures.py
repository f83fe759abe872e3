"""Procedural textures of walls, floors and furniture. Pure functions of a seed.

Every pattern returns (H, W, 3) uint8 RGB, row 0 at the top. All but the pictures tile without a seam.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import segno
from numpy.random import Generator
from numpy.typing import NDArray

from app.robots.simulated.world_config import CODE_RISE_M, CODE_SIDE_M, LETTER_HEIGHT_M, LETTER_WIDTH_M, MaterialConfig

Texture = NDArray[np.uint8]
Plane = NDArray[np.float32]
_Pattern = Callable[[Generator, NDArray[np.float32], NDArray[np.float32]], Texture]
SIZE = 256


def texture(material: MaterialConfig, seed: int) -> Texture:
    """The texture of ``material``; the same seed gives the same pixels."""
    rng = np.random.default_rng(seed)
    first = np.array(material.color, dtype=np.float32)
    second = np.array(material.second if material.second is not None else material.color, dtype=np.float32) * (
        1.0 if material.second is not None else 0.8
    )
    return _PATTERNS[material.pattern](rng, first, second)


def poster_page(text: str, title: str, pixels_per_m: float = 2400.0) -> Texture:
    """A US-Letter page: the QR code of ``text``, below it ``title``; the code lies as ``world_config`` says."""
    width, height = round(LETTER_WIDTH_M * pixels_per_m), round(LETTER_HEIGHT_M * pixels_per_m)
    page = np.full((height, width, 3), 250, dtype=np.uint8)
    code = segno.make(text, error="l", micro=False, boost_error=False)
    modules = np.array([list(row) for row in code.matrix], dtype=np.uint8)
    side = round(CODE_SIDE_M * pixels_per_m)
    bits = cv2.resize(np.where(modules > 0, 18, 250).astype(np.uint8), (side, side), interpolation=cv2.INTER_NEAREST)
    top = round((height - side) / 2 - CODE_RISE_M * pixels_per_m)
    left = (width - side) // 2
    page[top : top + side, left : left + side] = bits[:, :, None]
    scale = 1.0
    font = cv2.FONT_HERSHEY_DUPLEX
    (wide, tall), _ = cv2.getTextSize(title, font, scale, 2)
    scale = min(0.9 * width / wide, 1.6)
    (wide, tall), _ = cv2.getTextSize(title, font, scale, 2)
    cv2.putText(page, title, ((width - wide) // 2, height - tall - 14), font, scale, (30, 60, 110), 2, cv2.LINE_AA)
    return page


def noise(rng: Generator, scale: tuple[int, int], shape: tuple[int, int] = (SIZE, SIZE), octaves: int = 4) -> Plane:
    """Tiling cloud noise (H, W) float32 in about [-1, 1]; ``scale``: cells down and across in the coarsest octave."""
    total = np.zeros(shape, dtype=np.float32)
    for octave in range(octaves):
        cells = tuple(min(n, s * 2**octave) for s, n in zip(scale, shape, strict=True))
        grid = rng.uniform(-1, 1, cells).astype(np.float32)
        wrapped = np.pad(grid, 2, mode="wrap")
        factor = tuple(n / c for n, c in zip(shape, cells, strict=True))
        big = cv2.resize(
            wrapped, (round(wrapped.shape[1] * factor[1]), round(wrapped.shape[0] * factor[0])),
            interpolation=cv2.INTER_CUBIC,
        )  # fmt: skip
        top, left = round(2 * factor[0]), round(2 * factor[1])
        total += big[top : top + shape[0], left : left + shape[1]] * 0.55**octave
    return total / 1.6


def _shade(color: NDArray[np.float32], amount: Plane) -> NDArray[np.float32]:
    return np.asarray(color[None, None, :] * (1.0 + amount[:, :, None]), dtype=np.float32)


def _flat(color: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.broadcast_to(color, (SIZE, SIZE, 3))


def _bytes(image: NDArray[Any]) -> Texture:
    return np.asarray(np.clip(image, 0, 255), dtype=np.uint8)


def _mix(a: NDArray[np.float32], b: NDArray[np.float32], weight: Plane) -> NDArray[np.float32]:
    w = np.clip(weight, 0, 1)[:, :, None]
    return np.asarray(a * (1 - w) + b * w, dtype=np.float32)


def _plain(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    return _bytes(_shade(first, 0.03 * noise(rng, (16, 16), (64, 64), 2)))


def _plaster(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    blotches = _mix(_flat(first), _flat(second),
                    0.35 + 0.5 * noise(rng, (3, 3), octaves=5))  # fmt: skip
    return _bytes(blotches + 6.0 * noise(rng, (64, 64), octaves=2)[:, :, None])


def _brick(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    rows, columns, joint = 8, 4, 3
    image = _shade(second, 0.15 * noise(rng, (64, 64), octaves=2))
    height, width = SIZE // rows, SIZE // columns
    for row in range(rows):
        for column in range(columns):
            shade = first * float(rng.uniform(0.78, 1.12)) + rng.uniform(-8, 8, 3).astype(np.float32)
            brick = shade[None, None, :] * (
                1 + 0.1 * noise(rng, (6, 6), (height - joint, width - joint), 3)[:, :, None]
            )
            across = (column * width + (width // 2 if row % 2 else 0) + np.arange(width - joint)) % SIZE
            image[row * height : row * height + height - joint, across] = brick
    return _bytes(image)


def _grain(
    rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32], shape: tuple[int, int]
) -> NDArray[np.float32]:
    rings: Plane = np.sin(14.0 * noise(rng, (6, 1), shape, 3) + 3.0 * noise(rng, (24, 2), shape, 2))
    fine = noise(rng, (64, 2), shape, 2)
    return _mix(_shade(first, 0.06 * fine), _shade(second, 0.06 * fine), 0.5 + 0.4 * rings)


def _wood(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    return _bytes(_grain(rng, first, second, (SIZE, SIZE)))


def _planks(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    rows = 6
    height = SIZE // rows
    image = np.zeros((height * rows, SIZE, 3), dtype=np.float32)
    for row in range(rows):
        plank = _grain(rng, first, second, (height, SIZE)) * float(rng.uniform(0.82, 1.08))
        plank[:1] *= 0.55
        plank[:, int(rng.integers(0, SIZE - 2)) :][:, :2] *= 0.55
        image[row * height : (row + 1) * height] = plank
    return _bytes(image)


def _carpet(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    speckle = rng.uniform(0, 1, (SIZE, SIZE)).astype(np.float32)
    cloud = noise(rng, (4, 4), octaves=3)
    return _bytes(
        _mix(_shade(first, 0.06 * cloud), _shade(second, 0.06 * cloud), np.float32(1.3) * speckle - np.float32(0.4))
    )


def _tiles(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    count = 4
    side = SIZE // count
    image = np.zeros((SIZE, SIZE, 3), dtype=np.float32)
    for row in range(count):
        for column in range(count):
            color = first if (row + column) % 2 else second
            shade = 0.05 * noise(rng, (3, 3), (side, side), 3) + float(rng.uniform(-0.03, 0.03))
            image[row * side : (row + 1) * side, column * side : (column + 1) * side] = _shade(color, shade)
    image[::side] = image[1::side] = 110
    image[:, ::side] = image[:, 1::side] = 110
    return _bytes(image)


def _terrazzo(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    image = _bytes(_shade(first, 0.05 * noise(rng, (4, 4), octaves=4)))
    palette = [second, second * 0.6, first * 0.7, np.minimum(first * 1.12, 255)]
    for _ in range(380):
        center = rng.integers(8, SIZE - 8, 2)
        axes = rng.integers(1, 5, 2)
        color = [int(c) for c in palette[int(rng.integers(len(palette)))]]
        angle = float(rng.uniform(0, 180))
        cv2.ellipse(image, center.tolist(), axes.tolist(), angle, 0, 360, color, -1, cv2.LINE_AA)
    image[:2] = image[:2] // 2
    image[:, :2] = image[:, :2] // 2
    return image


def _concrete(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    image = _mix(_flat(first), _flat(second),
                 0.5 + 0.8 * noise(rng, (3, 3), octaves=5))  # fmt: skip
    image += 7.0 * rng.standard_normal((SIZE, SIZE, 1)).astype(np.float32)
    for y, x in ((64, 48), (64, 208), (192, 48), (192, 208)):
        cv2.circle(image, (x, y), 4, (60.0, 60.0, 60.0), -1, cv2.LINE_AA)
    image[:2] *= 0.7
    return _bytes(image)


def _ceiling(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    image = _shade(first, 0.02 * noise(rng, (64, 64), octaves=2))
    side = SIZE // 4
    for y, x in rng.integers(0, SIZE, (700, 2)):
        image[y, x] *= 0.85
    image[::side] *= 0.72
    image[:, ::side] *= 0.72
    image[side + 4 : 2 * side - 3, 4 : 2 * side - 3] = second
    return _bytes(image)


def _books(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    image = np.full((SIZE, SIZE, 3), 35, dtype=np.float32)
    x = 0
    while x < SIZE:
        width = int(rng.integers(9, 24))
        color = cv2.cvtColor(
            np.array([[[rng.integers(0, 180), rng.integers(60, 190), rng.integers(70, 215)]]], dtype=np.uint8),
            cv2.COLOR_HSV2RGB,
        )[0, 0].astype(np.float32)
        top = int(rng.integers(0, 70))
        book = image[top:, x : x + width - 1]
        book[:] = color * np.sin(np.linspace(0.7, 2.4, book.shape[1], dtype=np.float32))[None, :, None]
        band = top + int(rng.integers(25, 60))
        image[band : band + 14, x + 2 : x + width - 3] = 225
        x += width
    return _bytes(image)


def _leaves(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    image = _bytes(_shade(second, 0.2 * noise(rng, (8, 8))))
    for _ in range(340):
        weight = float(rng.uniform(0, 1))
        color = [int(c) for c in (first * weight + second * (1 - weight)) * rng.uniform(0.8, 1.15)]
        center = rng.integers(0, SIZE, 2).tolist()
        cv2.ellipse(image, center, (14, 5), float(rng.uniform(0, 180)), 0, 360, color, -1, cv2.LINE_AA)
    return image


def _picture(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    cloud, down = noise(rng, (2, 2)), np.linspace(-0.2, 1.2, SIZE, dtype=np.float32)[:, None]
    image = _bytes(_mix(_shade(first, 0.1 * cloud), _shade(second, -0.1 * cloud), down + 0.5 * noise(rng, (2, 2))))
    for _ in range(9):
        color = rng.integers(20, 245, 3).tolist()
        center = rng.integers(20, SIZE - 20, 2).tolist()
        if rng.uniform() < 0.5:
            cv2.circle(image, center, int(rng.integers(10, 60)), color, -1, cv2.LINE_AA)
        else:
            cv2.line(image, center, rng.integers(0, SIZE, 2).tolist(), color, int(rng.integers(3, 16)), cv2.LINE_AA)
    cv2.rectangle(image, (0, 0), (SIZE - 1, SIZE - 1), (45, 38, 32), 14)
    return image


def _whiteboard(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    image = np.full((SIZE, 2 * SIZE, 3), 238, dtype=np.uint8)
    inks = ((25, 45, 140), (160, 30, 30), (20, 110, 60), (40, 40, 40))
    for line in range(7):
        y = 34 + 26 * line
        length = int(rng.integers(120, 230))
        x = np.arange(30, 30 + length, 4)
        points = np.stack([x, y + 6 * rng.standard_normal(x.size)], axis=-1).astype(np.int32)
        cv2.polylines(image, [points[:, None]], False, inks[line % 4], 2, cv2.LINE_AA)
    for left, top in ((286, 50), (386, 50), (336, 140)):
        cv2.rectangle(image, (left, top), (left + 68, top + 40), inks[0], 2, cv2.LINE_AA)
    cv2.arrowedLine(image, (354, 70), (386, 70), inks[1], 2, cv2.LINE_AA)
    cv2.arrowedLine(image, (420, 90), (380, 140), inks[1], 2, cv2.LINE_AA)
    cv2.rectangle(image, (0, 0), (2 * SIZE - 1, SIZE - 1), (120, 124, 130), 10)
    return image


def _window(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    down = np.linspace(0, 1, SIZE, dtype=np.float32)[:, None] + np.zeros((SIZE, SIZE), dtype=np.float32)
    sky = _mix(_shade(first, down * 0), np.full((SIZE, SIZE, 3), 250, dtype=np.float32),
               0.7 * down + 0.5 * noise(rng, (3, 2), octaves=5))  # fmt: skip
    hills = (170 + 22 * noise(rng, (2, 2), octaves=4)[0]).astype(int)
    for x in range(SIZE):
        sky[hills[x] :, x] = second * float(rng.uniform(0.85, 1.1))
    image = _bytes(sky)
    cv2.rectangle(image, (0, 0), (SIZE - 1, SIZE - 1), (225, 225, 222), 16)
    cv2.line(image, (SIZE // 2, 0), (SIZE // 2, SIZE), (225, 225, 222), 10)
    cv2.line(image, (0, SIZE // 3), (SIZE, SIZE // 3), (225, 225, 222), 8)
    return image


def _screen(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    image = np.full((SIZE, SIZE, 3), 22, dtype=np.uint8)
    image[12:-12, 12:-12] = (28, 36, 52)
    for line in range(17):
        y = 26 + 12 * line
        x = 22 + 10 * int(rng.integers(0, 4))
        while x < 200 and rng.uniform() < 0.85:
            length = int(rng.integers(10, 44))
            color = rng.choice([[120, 190, 240], [240, 190, 110], [170, 220, 140], [205, 205, 210]]).tolist()
            cv2.line(image, (x, y), (min(x + length, 236), y), color, 4)
            x += length + 8
    return image


def _cardboard(rng: Generator, first: NDArray[np.float32], second: NDArray[np.float32]) -> Texture:
    image = _shade(first, 0.05 * noise(rng, (48, 2)) + 0.04 * noise(rng, (3, 3)))
    middle = SIZE // 2
    image[middle - 16 : middle + 16] = _shade(second, 0.03 * noise(rng, (8, 8)))[middle - 16 : middle + 16]
    image[:3] *= 0.7
    image[-3:] *= 0.7
    image[:, :3] *= 0.7
    image[:, -3:] *= 0.7
    return _bytes(image)


_PATTERNS: dict[str, _Pattern] = {
    "plain": _plain, "plaster": _plaster, "brick": _brick, "wood": _wood, "planks": _planks, "carpet": _carpet,
    "tiles": _tiles, "terrazzo": _terrazzo, "concrete": _concrete, "ceiling": _ceiling, "books": _books,
    "leaves": _leaves, "picture": _picture, "whiteboard": _whiteboard, "window": _window, "screen": _screen,
    "cardboard": _cardboard,
}  # fmt: skip
