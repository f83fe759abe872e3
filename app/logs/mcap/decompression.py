"""The unpacked size of compressed data, computed before it is unpacked: 100 kB can hold gigabytes of zeros.

Libraries allocate the size that a frame declares, or as much as comes out of it. So the heads of a frame's blocks are
read first, none of which unpacks to more than a bound of its format (RFC 8878, LZ4 Frame Format).
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from contextlib import suppress
from typing import TypeAlias

import lz4.frame
import zstandard

from app.logs.log import LogError

#: No chunk of messages, and no message, unpacks to more bytes. Our own chunks have some 1 MB.
MOST_UNPACKED = 256_000_000
#: No record that is read whole (an attached file, say) has more bytes.
MOST_RECORD = 1_000_000_000

#: Bytes, or a function of where a piece begins and ends that reads it.
Packed: TypeAlias = Callable[[int, int], bytes]

_ZSTD, _LZ4 = 0xFD2FB528, 0x184D2204
_SKIPPABLE, _SKIPPABLE_BITS = 0x184D2A50, 0xFFFFFFF0
_ZSTD_HEAD, _LZ4_HEAD = 18, 19
_ZSTD_BLOCK = 128 * 1024
#: An empty block counts as this, so that there are not too many to walk through.
_LEAST_BLOCK = 64
_UNKNOWN = zstandard.CONTENTSIZE_UNKNOWN
_WORD = struct.Struct("<I")


#: Exceptions for data that is not a frame; RuntimeError by lz4.
NO_FRAME = (struct.error, zstandard.ZstdError, RuntimeError)


class TooMuch(LogError):
    """Packed data that unpacks to more than is read; the message is for people, its subject the data."""


def check_unpacked(packed: Packed, size: int, compression: str, declared: int, most: int = MOST_UNPACKED) -> None:
    """Raise TooMuch where ``size`` bytes of ``packed`` may unpack to more than ``most`` or say that they do.

    ``declared`` is the unpacked size (bytes) that their record names. Damage passes: the library reports it.
    """
    bound = declared
    with suppress(*NO_FRAME):  # no frame: nothing comes out of it
        bound = max(bound, unpacked_size(packed, size, compression, most))
    if bound > most:
        raise TooMuch(f"may unpack to {amount(bound)}; at most {amount(most)} are unpacked")


def unpacked_size(packed: Packed, size: int, compression: str, most: int) -> int:
    """An upper bound (bytes) of the unpacked size of ``size`` bytes of ``packed``, or, over ``most``, of a part of it.

    Raises one of ``NO_FRAME`` where it is no frame.
    """
    match compression:
        case "zstd":
            return _zstd(packed, size, most)
        case "lz4":
            return _lz4(packed, size, most)
    return size


def amount(size: int) -> str:
    """``size`` (bytes) in words, such as ``256 MB``."""
    return f"{size / 1e9:.1f} GB" if size >= 1e9 else f"{size / 1e6:g} MB"


def _zstd(packed: Packed, size: int, most: int) -> int:
    """The most bytes that frames of Zstandard unpack to, or as much of it as is over ``most``."""
    at = total = 0
    while at + 4 <= size and total <= most:
        head = packed(at, min(at + _ZSTD_HEAD, size))
        (magic,) = _WORD.unpack_from(head)
        if magic & _SKIPPABLE_BITS == _SKIPPABLE:
            at += 8 + _WORD.unpack_from(head, 4)[0]
            continue
        if magic != _ZSTD:
            break
        frame = zstandard.get_frame_parameters(head)
        at += zstandard.frame_header_size(head)
        unpacked, last = 0, False
        while not last and at + 3 <= size and total + unpacked <= most:
            block = int.from_bytes(packed(at, at + 3), "little")
            last, kind, length = bool(block & 1), block >> 1 & 3, block >> 3
            # Of raw and repeated ones the length is that unpacked; the latter take one byte.
            unpacked += max(length, _LEAST_BLOCK) if kind < 2 else _ZSTD_BLOCK
            at += 3 + (1 if kind == 1 else length)
        # The library allocates the declared size, and unpacks no more.
        total += unpacked if frame.content_size == _UNKNOWN else frame.content_size
        at += 4 * frame.has_checksum
    return total


def _lz4(packed: Packed, size: int, most: int) -> int:
    """The same of LZ4's frames."""
    at = total = 0
    while at + 4 <= size and total <= most:
        head = packed(at, min(at + _LZ4_HEAD, size))
        (magic,) = _WORD.unpack_from(head)
        if magic & _SKIPPABLE_BITS == _SKIPPABLE:
            at += 8 + _WORD.unpack_from(head, 4)[0]
            continue
        if magic != _LZ4:
            break
        frame = lz4.frame.get_frame_info(head)
        flags = head[4]
        at += 7 + 8 * bool(flags & 0x08) + 4 * bool(flags & 0x01)
        unpacked = 0
        while at + 4 <= size and total + unpacked <= most:
            (block,) = _WORD.unpack(packed(at, at + 4))
            at += 4
            if not block:
                break
            length = block & 0x7FFFFFFF
            # A packed byte makes 255 at most; the block has a bound of its own.
            unpacked += min(frame["block_size"], 255 * length + 64)
            at += length + 4 * frame["block_checksum"]
        total += frame["content_size"] or unpacked
        at += 4 * frame["content_checksum"]
    return total


def within(data: bytes | memoryview) -> Packed:
    """A function that returns the bytes of ``data`` from ``begin`` to ``end``."""
    return lambda begin, end: bytes(data[begin:end])
