"""What all who read MCAP files share: how such a file begins and ends, and what damage makes the library raise."""

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
#: What every record begins with: opcode (1), length of the content (8).
RECORD_HEAD = struct.Struct("<BQ")

#: What a file that is not what it should be makes the MCAP library raise; RuntimeError is lz4's. Offsets beyond the
#: file are OSErrors besides, which whoever only reads may count among them.
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
