"""Checks that the chunks of an MCAP file are within bounds, by their headers alone, before a library unpacks one."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import IO

from mcap.opcode import Opcode
from mcap.reader import SeekingReader
from mcap.records import Chunk, McapRecord
from mcap.stream_reader import breakup_chunk
from mcap.summary import Summary

from app.logs.log import LogError
from app.logs.mcap.decompression import MOST_RECORD, MOST_UNPACKED, TooMuch, amount, check_unpacked, within
from app.logs.mcap.structure import CHUNK_HEAD, MAGIC, RECORD_HEAD

_LONGEST_NAME = 16
#: Opcode (1), length (8), begin of the summary (8), of its offsets (8), checksum (4).
_FOOTER = struct.Struct("<BQQQI")
#: Upper limit of a file's length: the system's greatest offset is smaller.
_NO_PLACE = 1 << 62


class BoundedReader(SeekingReader):
    """A reader that refuses records of more than ``MOST_RECORD`` bytes, and chunks at places where none may be.

    The MCAP library unpacks a chunk that it finds in place of a summary or an attached file. Chunks that hold messages
    are checked by :func:`check_chunks`.
    """

    def __init__(self, file: IO[bytes], *, validate_crcs: bool = False) -> None:
        """Raises what damage makes the MCAP library raise."""
        super().__init__(file, validate_crcs=validate_crcs, record_size_limit=MOST_RECORD)
        self._checked = False

    def get_summary(self) -> Summary | None:
        """The summary. Raises what damage makes the MCAP library raise; ValueError for a chunk in its place."""
        if not self._checked:
            self._check_summary()
            summary = super().get_summary()
            if summary is not None:
                for index in summary.attachment_indexes:
                    self._check_place(index.offset, Opcode.ATTACHMENT)
                for described in summary.metadata_indexes:
                    self._check_place(described.offset, Opcode.METADATA)
            self._checked = True
        return super().get_summary()

    def _check_summary(self) -> None:
        number = self._stream.fileno()
        size = os.fstat(number).st_size
        footer = os.pread(number, _FOOTER.size, max(0, size - _FOOTER.size - len(MAGIC)))
        at = _FOOTER.unpack(footer)[2] if len(footer) == _FOOTER.size else 0
        while at and at + RECORD_HEAD.size <= size:
            opcode, length = RECORD_HEAD.unpack(os.pread(number, RECORD_HEAD.size, at))
            if opcode == Opcode.CHUNK:
                raise ValueError("there is a chunk of messages in its summary")
            at += RECORD_HEAD.size + length

    def _check_place(self, offset: int, opcode: Opcode) -> None:
        if offset >= _NO_PLACE or os.pread(self._stream.fileno(), 1, offset) != bytes([opcode]):
            raise ValueError(f"its index names a record that is not at byte {offset}")


def check_chunks(path: Path, file: IO[bytes], summary: Summary | None) -> None:
    """Raise LogError where a chunk that reading ``file`` would unpack may become too much.

    By the index in ``summary``; without one, which readers do without too, all of the file is walked through.
    """
    indexes = [] if summary is None else summary.chunk_indexes
    for index in indexes:
        _check(path, file, index.chunk_start_offset)
        # Some readers go by what the index says of a chunk.
        at = index.chunk_start_offset + RECORD_HEAD.size + CHUNK_HEAD.size + len(index.compression.encode()) + 8
        _bounded(
            path, file, index.chunk_start_offset,
            at=at, size=index.compressed_size, compression=index.compression, declared=index.uncompressed_size,
        )  # fmt: skip
    if summary is None or not indexes or summary.statistics is None or not summary.schemas:
        for offset in _offsets(file):
            _check(path, file, offset)


def records_of(chunk: Chunk, *, validate_crc: bool = False) -> Iterable[McapRecord]:
    """The records in ``chunk``. Raises TooMuch, and what damage makes the MCAP library raise."""
    check_unpacked(within(memoryview(chunk.data)), len(chunk.data), chunk.compression, chunk.uncompressed_size)
    return breakup_chunk(chunk, validate_crc=validate_crc)


def _check(path: Path, file: IO[bytes], offset: int) -> None:
    most = RECORD_HEAD.size + CHUNK_HEAD.size + _LONGEST_NAME + 8
    head = os.pread(file.fileno(), most, offset) if offset < _NO_PLACE else b""
    try:
        _, _, size, _, length = CHUNK_HEAD.unpack_from(head, RECORD_HEAD.size)
        at = RECORD_HEAD.size + CHUNK_HEAD.size + length
        name = head[at - length : at].decode("utf-8", "replace")
        (packed,) = struct.unpack_from("<Q", head, at)
    except struct.error:
        return  # the library that reads it reports the damage
    _bounded(path, file, offset, at=offset + at + 8, size=packed, compression=name, declared=size)


def _bounded(path: Path, file: IO[bytes], offset: int, at: int, size: int, compression: str, declared: int) -> None:
    if offset >= _NO_PLACE:
        return
    if size > MOST_UNPACKED:
        said = f"has {amount(size)}; at most {amount(MOST_UNPACKED)} are read"
    else:
        number = file.fileno()
        try:
            check_unpacked(lambda begin, end: os.pread(number, end - begin, at + begin), size, compression, declared)
        except TooMuch as refusal:
            said = str(refusal)
        else:
            return
    raise LogError(f"{path}: the chunk of messages at byte {offset} {said}; `hbba log repair {path}` saves the others")


def _offsets(file: IO[bytes]) -> Iterable[int]:
    """Offsets of the chunks in ``file``; the file's position is restored."""
    number = file.fileno()
    size = os.fstat(number).st_size
    at = len(MAGIC)
    while at + RECORD_HEAD.size <= size:
        opcode, length = RECORD_HEAD.unpack(os.pread(number, RECORD_HEAD.size, at))
        if opcode == Opcode.CHUNK:
            yield at
        at += RECORD_HEAD.size + length
