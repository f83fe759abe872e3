"""Pictures through memory that two processes share: a small ring of slots, each guarded by its sequence number.

The memory has no name, only a file descriptor that the link's process inherits: it vanishes with its last user,
however that ends. The writer marks a slot with an odd number while it writes and an even one when done; a reader
copies and then checks that the number is still the one it was told.
"""

from __future__ import annotations

import mmap
import os
import tempfile
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.messages import read_only

SLOTS = 4
_HEADER_BYTES = 64


def create_memory(size: int) -> int:
    """A file descriptor of ``size`` bytes of nameless memory."""
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("hbba-images", os.MFD_CLOEXEC)
    else:
        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.ftruncate(descriptor, size)
    return descriptor


class ImageRing:
    """Colour (H, W, 3) uint8 and depth (H, W) uint16 pictures in the ``memory`` of :func:`create_memory`."""

    def __init__(self, memory: int, width: int, height: int) -> None:
        self._map = mmap.mmap(memory, ring_bytes(width, height))
        slot = ring_bytes(width, height) // SLOTS
        self._sequences: list[NDArray[np.int64]] = []
        self.colors: list[NDArray[np.uint8]] = []
        self.depths: list[NDArray[np.uint16]] = []
        for start in range(0, slot * SLOTS, slot):
            color = start + _HEADER_BYTES
            depth = color + 3 * width * height
            self._sequences.append(self._view(start, np.int64, (1,)))
            self.colors.append(self._view(color, np.uint8, (height, width, 3)))
            self.depths.append(self._view(depth, np.uint16, (height, width)))

    def _view(self, offset: int, dtype: Any, shape: tuple[int, ...]) -> NDArray[Any]:
        return np.ndarray(shape, dtype, self._map, offset)

    def begin(self, slot: int) -> tuple[NDArray[np.uint8], NDArray[np.uint16]]:
        """Writer: mark ``slot`` as being written; return its colour and depth arrays to fill."""
        self._sequences[slot][0] |= 1
        return self.colors[slot], self.depths[slot]

    def finish(self, slot: int, sequence: int) -> None:
        """Writer: mark ``slot`` as whole, holding picture number ``sequence`` (even)."""
        self._sequences[slot][0] = sequence

    def read(self, slot: int, sequence: int) -> tuple[NDArray[np.uint8], NDArray[np.uint16]] | None:
        """Reader: a read-only copy of picture ``sequence``, None if it has been overwritten."""
        if self._sequences[slot][0] != sequence:
            return None
        color, depth = self.colors[slot].copy(), self.depths[slot].copy()
        if self._sequences[slot][0] != sequence:
            return None
        return read_only(color), read_only(depth)

    def close(self) -> None:
        """Let go of the memory."""
        self._sequences.clear()
        self.colors.clear()
        self.depths.clear()
        self._map.close()


def ring_bytes(width: int, height: int) -> int:
    """Bytes of a ring for pictures of ``width`` x ``height``."""
    return SLOTS * (_HEADER_BYTES + -(-5 * width * height // 64) * 64)
