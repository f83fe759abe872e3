"""Bytes of each channel of an MCAP file, read from its index alone."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import IO

import numpy as np
from mcap.records import ChunkIndex

from app.base.plain_file import open_plain
from app.logs import layout
from app.logs.mcap.bounds import BoundedReader
from app.logs.mcap.structure import DAMAGE, RECORD_HEAD

_HEAD = struct.Struct("<BQHI")


def channel_bytes(path: Path) -> Mapping[str, int]:
    """Bytes of the records of each channel before compression; empty for a file without a message index.

    ``path`` is a finished MCAP file. A channel of our recordings includes all topics that are read back for it; in a
    file of another program, channels are topics. Raises OSError.
    """
    total: Counter[str] = Counter()
    with open_plain(path) as stream:
        try:
            summary = BoundedReader(stream).get_summary()
            if summary is None:
                return {}
            names = {
                number: channel.metadata.get(layout.CHANNEL, channel.topic)
                for number, channel in summary.channels.items()
            }
            for index in summary.chunk_indexes:
                for number, size in _of_chunk(stream, index).items():
                    total[names[number]] += size
        except (*DAMAGE, OSError):  # an offset beyond the file is the latter
            return {}
    return total


def _of_chunk(stream: IO[bytes], index: ChunkIndex) -> dict[int, int]:
    """Bytes by channel id: a record extends from its offset to that of the next record, of any channel."""
    stream.seek(index.chunk_start_offset + index.chunk_length)
    data = stream.read(index.message_index_length)
    offsets, owners = [], []
    position = 0
    while position + _HEAD.size <= len(data):
        _, length, channel, entries = _HEAD.unpack_from(data, position)
        pairs = np.frombuffer(data, "<u8", entries // 8, position + _HEAD.size)
        offsets.append(pairs[1::2])
        owners.append(np.full(len(pairs) // 2, channel))
        position += RECORD_HEAD.size + length
    if not offsets:
        return {}
    begins = np.concatenate(offsets).astype(np.int64)
    order = np.argsort(begins)
    sizes = np.diff(begins[order], append=index.uncompressed_size)
    numbers, where = np.unique(np.concatenate(owners)[order], return_inverse=True)
    totals = np.bincount(where, weights=sizes)
    return {int(number): int(size) for number, size in zip(numbers, totals, strict=True)}
