"""The structure of MCAP files that all readers share: begin, end, and the exceptions that damage raises."""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import IO

import zstandard
from mcap.exceptions import McapError

from app.base.plain_file import open_plain

#: The first bytes of an MCAP file, and the last of one that was closed.
MAGIC = b"\x89MCAP0\r\n"
#: Head of every record: opcode (1), length of the content (8).
RECORD_HEAD = struct.Struct("<BQ")
#: Fields before a chunk's records: begin (8), end (8), size and checksum of the records (8, 4), length of the
#: compression's name (4).
CHUNK_HEAD = struct.Struct("<QQQII")

#: Exceptions of the MCAP library for damaged files; RuntimeError is lz4's. Offsets beyond the file raise OSError
#: besides, which a reader may treat as damage.
DAMAGE = (
    McapError,
    zstandard.ZstdError,
    RuntimeError,
    ValueError,
    LookupError,
    struct.error,
    EOFError,
    MemoryError,
    OverflowError,
)


def is_mcap(path: Path) -> bool:
    """Whether ``path`` is a file that begins as MCAP files do; False where it cannot be read."""
    if not path.is_file():
        return False
    try:
        with open_plain(path) as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def is_closed(file: IO[bytes]) -> bool:
    """Whether ``file`` ends as an MCAP file that was closed does. Moves its position. Raises OSError."""
    if file.seek(0, os.SEEK_END) < 2 * len(MAGIC):
        return False
    file.seek(-len(MAGIC), os.SEEK_END)
    return file.read() == MAGIC
