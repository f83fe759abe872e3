"""How many bytes each topic of an MCAP file takes, read from its index alone."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import IO

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import SeekingReader
from mcap.records import ChunkIndex

from app.recording import mcap_layout as layout

_HEAD = struct.Struct("<BQHI")


def topic_bytes(path: Path) -> Mapping[str, int]:
    """Bytes of the records of each topic before compression; empty where the file has no index that tells.

    ``path`` is a finished MCAP file. Raises OSError.
    """
    with path.open("rb") as stream:
        try:
            summary = SeekingReader(stream).get_summary()
        except (McapError, ValueError, struct.error):
            return {}
        if summary is None:
            return {}
        total: Counter[str] = Counter()
        for index in summary.chunk_indexes:
            for number, size in _of_chunk(stream, index).items():
                if number in summary.channels:
                    total[summary.channels[number].topic] += size
        return total


def channel_bytes(path: Path) -> Mapping[str, int]:
    """:func:`topic_bytes` of a recording of ours by channel: all topics that are read back for it."""
    topics = topic_bytes(path)
    with path.open("rb") as stream:
        summary = SeekingReader(stream).get_summary()
    total: Counter[str] = Counter()
    for channel in {} if summary is None else summary.channels.values():
        total[channel.metadata.get(layout.CHANNEL, channel.topic)] += topics.get(channel.topic, 0)
    return total


def _of_chunk(stream: IO[bytes], index: ChunkIndex) -> dict[int, int]:
    """Bytes by channel id: a record reaches from its offset to that of the next, whoever's that is."""
    stream.seek(index.chunk_start_offset + index.chunk_length)
    data = stream.read(index.message_index_length)
    offsets, owners = [], []
    position = 0
    while position + _HEAD.size <= len(data):
        _, length, channel, entries = _HEAD.unpack_from(data, position)
        pairs = np.frombuffer(data, "<u8", entries // 8, position + _HEAD.size)
        offsets.append(pairs[1::2])
        owners.append(np.full(len(pairs) // 2, channel))
        position += 9 + length
    if not offsets:
        return {}
    begins = np.concatenate(offsets).astype(np.int64)
    order = np.argsort(begins)
    sizes = np.diff(begins[order], append=index.uncompressed_size)
    numbers, where = np.unique(np.concatenate(owners)[order], return_inverse=True)
    totals = np.bincount(where, weights=sizes)
    return {int(number): int(size) for number, size in zip(numbers, totals, strict=True)}
