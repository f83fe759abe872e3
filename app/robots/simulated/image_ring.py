"""Images in memory shared by two processes: a ring of slots with sequence numbers (seqlock).

The memory has no name, only a file descriptor that the link's process inherits: it vanishes with its last user,
however that ends. Each camera has a ring of its own in it. The writer marks a slot with an odd number while it writes
and an even one when done; a reader copies and then checks that the number is still that of the notice.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.messages import read_only

SLOTS = 4
_HEADER_BYTES = 64


@dataclass(frozen=True, slots=True)
class PictureFormat:
    """The size (px) of a camera's pictures, and whether depth comes with them."""

    width: int
    height: int
    has_depth: bool

    @property
    def slot_bytes(self) -> int:
        return _HEADER_BYTES + -(-(5 if self.has_depth else 3) * self.width * self.height // 64) * 64


def memory_bytes(formats: Mapping[str, PictureFormat]) -> int:
    """Bytes of the memory for the rings of these cameras; never 0."""
    return max(SLOTS * sum(picture.slot_bytes for picture in formats.values()), 64)


def create_memory(size: int) -> int:
    """A file descriptor of ``size`` bytes of nameless memory."""
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("hbba-images", os.MFD_CLOEXEC)
    else:
        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.ftruncate(descriptor, size)
    return descriptor


class ImageRings:
    """The rings of all cameras, by stream, in the ``memory`` of :func:`create_memory` and :func:`memory_bytes`.

    Both processes give the same ``formats`` in the same order.
    """

    def __init__(self, memory: int, formats: Mapping[str, PictureFormat]) -> None:
        self._map = mmap.mmap(memory, memory_bytes(formats))
        self.rings: dict[str, ImageRing] = {}
        offset = 0
        for stream, picture in formats.items():
            self.rings[stream] = ImageRing(self._map, offset, picture)
            offset += SLOTS * picture.slot_bytes

    def read(self, stream: str, slot: int, sequence: int) -> tuple[NDArray[np.uint8], NDArray[np.uint16] | None] | None:
        return self.rings[stream].read(slot, sequence)

    def close(self) -> None:
        for ring in self.rings.values():
            ring.release()
        self._map.close()


class ImageRing:
    """Pictures in ``memory`` from ``offset``: colour (H, W, 3) uint8 and, if the camera has it, depth (H, W) uint16."""

    def __init__(self, memory: mmap.mmap, offset: int, picture: PictureFormat) -> None:
        self._sequences: list[NDArray[np.int64]] = []
        self.colors: list[NDArray[np.uint8]] = []
        self.depths: list[NDArray[np.uint16] | None] = []
        size = (picture.height, picture.width)
        for start in range(offset, offset + SLOTS * picture.slot_bytes, picture.slot_bytes):
            color = start + _HEADER_BYTES
            depth = color + 3 * picture.width * picture.height

            def view(at: int, dtype: Any, shape: tuple[int, ...]) -> NDArray[Any]:
                return np.ndarray(shape, dtype, memory, at)

            self._sequences.append(view(start, np.int64, (1,)))
            self.colors.append(view(color, np.uint8, (*size, 3)))
            self.depths.append(view(depth, np.uint16, size) if picture.has_depth else None)

    def begin(self, slot: int) -> tuple[NDArray[np.uint8], NDArray[np.uint16] | None]:
        """Writer: mark ``slot`` as being written; return its colour and depth arrays to fill."""
        self._sequences[slot][0] |= 1
        return self.colors[slot], self.depths[slot]

    def finish(self, slot: int, sequence: int) -> None:
        """Writer: mark ``slot`` as whole, holding picture number ``sequence`` (even)."""
        self._sequences[slot][0] = sequence

    def read(self, slot: int, sequence: int) -> tuple[NDArray[np.uint8], NDArray[np.uint16] | None] | None:
        """Reader: a read-only copy of picture ``sequence``, None if it has been overwritten."""
        if self._sequences[slot][0] != sequence:
            return None
        color, depth = self.colors[slot].copy(), self.depths[slot]
        if depth is not None:
            depth = read_only(depth.copy())
        if self._sequences[slot][0] != sequence:
            return None
        return read_only(color), depth

    def release(self) -> None:
        """Release the arrays, so that the memory can be closed."""
        self._sequences.clear()
        self.colors.clear()
        self.depths.clear()
