"""Files that are small and say, or become, gigabytes."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import IO

import lz4.frame
from mcap.writer import CompressionType, Writer

GIB = 1 << 30


def zstd_of_zeros(size: int) -> bytes:
    """A frame of Zstandard that unpacks to ``size`` zeros (a multiple of 128 KiB) and does not say so: 4 bytes for
    each 128 KiB."""
    blocks = size // (128 * 1024)
    heads = [(128 * 1024 << 3 | 1 << 1 | (number == blocks - 1)).to_bytes(3, "little") for number in range(blocks)]
    return b"\x28\xb5\x2f\xfd\x00\x88" + b"".join(head + b"\x00" for head in heads)


def lz4_of_zeros(size: int) -> bytes:
    """A frame of LZ4 that unpacks to ``size`` zeros (a multiple of 4 MiB) and does not say so: a 255th of that."""
    packed = lz4.frame.compress(bytes(4 << 20), block_size=lz4.frame.BLOCKSIZE_MAX4MB, block_linked=False,
                                store_size=False)  # fmt: skip
    head, block = packed[:7], packed[7:-4]
    return head + block * (size // (4 << 20)) + bytes(4)


PACKED = {"zstd": zstd_of_zeros, "lz4": lz4_of_zeros}


def chunk(packed: bytes, compression: str, declared: int) -> bytes:
    """A record of a chunk of MCAP."""
    name = compression.encode()
    content = struct.pack("<QQQII", 1, 2, declared, 0, len(name)) + name + struct.pack("<Q", len(packed)) + packed
    return struct.pack("<BQ", 6, len(content)) + content


def chunk_index(offset: int, length: int, packed: int, compression: str, declared: int) -> bytes:
    """A record of a chunk's index."""
    name = compression.encode()
    content = (
        struct.pack("<QQQQIQI", 1, 2, offset, length, 0, 0, len(name)) + name + struct.pack("<QQ", packed, declared)
    )
    return struct.pack("<BQ", 8, len(content)) + content


def put_chunk(log: Path, compression: str, size: int, declared: int, *, indexed: bool = True) -> Path:
    """Add a chunk that becomes ``size`` bytes, and says it does ``declared``, behind the others of the finished
    recording ``log``."""
    data = log.read_bytes()
    start, offsets, _ = struct.unpack("<QQI", data[-28:-8])
    head, rest = data[:start], data[start:-37]
    data_end = head[-13:]
    assert data_end[0] == 0x0F
    packed = PACKED[compression](size)
    record = chunk(packed, compression, declared)
    head = head[:-13]
    index = chunk_index(len(head), len(record), len(packed), compression, declared) if indexed else b""
    body = head + record + struct.pack("<BQI", 0x0F, 4, 0)
    summary = rest[: offsets - start] if offsets else rest
    footer = struct.pack("<BQQQI", 2, 20, len(body), 0, 0)
    log.write_bytes(body + summary + index + footer + data[-8:])
    return log


def ros_mcap(file: IO[bytes]) -> Writer:
    """The writer of a ROS 2 bag in ``file``."""
    writer = Writer(file, compression=CompressionType.ZSTD)
    writer.start("ros2", "somebody")
    return writer
