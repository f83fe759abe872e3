"""Pictures of unknown origin: the size that one declares is read before it is decoded.

A few hundred bytes can declare a picture of gigabytes, and a decoder would allocate them first.
"""

from __future__ import annotations

import re
import struct
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

#: A photograph of more pixels (three bytes each, and as much again while it is worked on) is not decoded.
MOST_PIXELS = 128_000_000
#: Limit of an encoded image's size: four bytes for each pixel.
MOST_BYTES = 4 * MOST_PIXELS

#: First bytes of the image formats that are decoded.
BEGINNINGS: dict[str, re.Pattern[bytes]] = {
    "JPEG": re.compile(rb"\xff\xd8\xff"),
    "PNG": re.compile(rb"\x89PNG\r\n\x1a\n"),
    "WebP": re.compile(rb"RIFF....WEBP", re.DOTALL),
    "BMP": re.compile(rb"BM"),
    "TIFF": re.compile(rb"II\*\0|MM\0\*"),
    "GIF": re.compile(rb"GIF8[79]a"),
    "PNM": re.compile(rb"P[1-6]\s"),
}
#: JPEG's markers that begin a frame, and those without a content.
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_BARE = frozenset({0x01, *range(0xD0, 0xD9)})
_TIFF_WIDTH, _TIFF_HEIGHT = 256, 257
#: White space and comments, then a number, in the head of a PNM.
_PNM_NUMBER = re.compile(rb"(?:\s+|#[^\r\n]*[\r\n])*([0-9]{1,10})(?=[\s#]|$)")
#: A PNM's head is no longer; comments may be long.
_PNM_HEAD = 65_536


class TooLarge(ValueError):
    """A picture of more pixels than are decoded; the message is for people, its subject the picture."""


def kind_of(data: bytes | memoryview) -> str | None:
    """``JPEG``, ``PNG``, ``WebP``, ``BMP``, ``TIFF``, ``GIF`` or ``PNM``, by how ``data`` begins; else None."""
    return next((kind for kind, beginning in BEGINNINGS.items() if beginning.match(data)), None)


def declared_size(data: bytes | memoryview) -> tuple[int, int] | None:
    """Width and height (pixels) declared in the encoded picture ``data``; None without."""
    view = memoryview(data)
    kind = kind_of(view)
    try:
        match kind:
            case "JPEG":
                return _jpeg(view)
            case "PNG":
                return struct.unpack_from(">II", view, 16) if bytes(view[12:16]) == b"IHDR" else None
            case "WebP":
                return _webp(view)
            case "BMP":
                return _bmp(view)
            case "TIFF":
                return _tiff(view)
            case "GIF":
                return struct.unpack_from("<HH", view, 6)
            case "PNM":
                return _pnm(bytes(view[:_PNM_HEAD]))
    except struct.error:  # it ends before
        return None
    return None


def decoded(data: bytes | NDArray[np.uint8], flags: int, most: int = MOST_PIXELS) -> NDArray[Any] | None:
    """The picture that ``data`` is, as ``cv2.imdecode`` makes it with ``flags``; None where it is damaged or none.

    Raises TooLarge, before it is decoded, for more than ``most`` pixels.
    """
    array = np.frombuffer(data, np.uint8) if isinstance(data, bytes) else np.ascontiguousarray(data)
    size = declared_size(array.data) if array.size else None
    if size is None:
        return None
    width, height = size
    if width * height > most:
        raise TooLarge(f"has {width} x {height} pixels; at most {most / 1e6:g} million are decoded")
    try:
        return cv2.imdecode(array, flags)
    except cv2.error:
        return None


def _jpeg(view: memoryview) -> tuple[int, int] | None:
    at = 2
    while True:
        (mark, marker) = struct.unpack_from("BB", view, at)
        if mark != 0xFF:
            return None
        if marker == 0xFF:  # filling
            at += 1
        elif marker in _BARE:
            at += 2
        elif marker in _FRAMES:
            height, width = struct.unpack_from(">HH", view, at + 5)
            return width, height
        else:
            (length,) = struct.unpack_from(">H", view, at + 2)
            at += 2 + max(length, 2)


def _webp(view: memoryview) -> tuple[int, int] | None:
    match bytes(view[12:16]):
        case b"VP8X":
            low = struct.unpack_from("<HBHB", view, 24)
            return low[0] + (low[1] << 16) + 1, low[2] + (low[3] << 16) + 1
        case b"VP8L":
            (bits,) = struct.unpack_from("<I", view, 21)
            return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
        case b"VP8 ":
            width, height = struct.unpack_from("<HH", view, 26)
            return width & 0x3FFF, height & 0x3FFF
    return None


def _bmp(view: memoryview) -> tuple[int, int]:
    (head,) = struct.unpack_from("<I", view, 14)
    if head == 12:
        width, height = struct.unpack_from("<HH", view, 18)
    else:
        width, height = struct.unpack_from("<ii", view, 18)
    return abs(width), abs(height)  # a height below 0: the top row comes first


def _tiff(view: memoryview) -> tuple[int, int] | None:
    order = "<" if bytes(view[:2]) == b"II" else ">"
    (at,) = struct.unpack_from(f"{order}I", view, 4)
    (count,) = struct.unpack_from(f"{order}H", view, at)
    found: dict[int, int] = {}
    for entry in range(count):
        tag, kind = struct.unpack_from(f"{order}HH", view, at + 2 + 12 * entry)
        if tag in (_TIFF_WIDTH, _TIFF_HEIGHT):
            (value,) = struct.unpack_from(f"{order}{'H' if kind == 3 else 'I'}", view, at + 10 + 12 * entry)
            found[tag] = value
    if len(found) < 2:
        return None
    return found[_TIFF_WIDTH], found[_TIFF_HEIGHT]


def _pnm(head: bytes) -> tuple[int, int] | None:
    numbers: list[int] = []
    at = 2
    for _ in range(2):
        found = _PNM_NUMBER.match(head, at)
        if found is None:
            return None
        numbers.append(int(found[1]))
        at = found.end()
    return numbers[0], numbers[1]
