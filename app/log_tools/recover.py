"""Reads an MCAP file that may be damaged anywhere: its intact records, and the damaged stretches between them.

MCAP (https://mcap.dev/spec) is a sequence of records, each an opcode, a length and that many bytes; messages are in
chunks, compressed, with a checksum. So one damaged record costs itself alone if its end can still be found: by its
length if a record follows there, else by a search for the next bytes that are certainly a record.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from io import BytesIO
from mmap import mmap
from typing import Any, TypeAlias, TypeVar

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Header, MessageIndex, Metadata, Schema

from app.logs.mcap.decompression import MOST_UNPACKED, amount
from app.logs.mcap.structure import CHUNK_HEAD, MAGIC, RECORD_HEAD

#: Channel (2), sequence (4), log time (8), publish time (8); the payload follows.
MESSAGE = struct.Struct("<HIQQ")

#: No record is a terabyte: bytes that say so are none.
_LONGEST = 1 << 40
#: Bytes unpacked at once: what a piece gives before its damage is lost with it, so small ones keep more.
_PIECE = 1 << 10
_CANDIDATE = re.compile(rb"[\x01-\x0f].{5}\x00\x00\x00", re.DOTALL)
_BAD = (McapError, struct.error, ValueError, OverflowError)


#: A file mapped into memory, or what one would hold.
Buffer: TypeAlias = mmap | bytes


@dataclass(frozen=True, slots=True)
class IntactRecord:
    """An intact record. ``content`` of a chunk is its records, decompressed; of one whose end is missing, the whole
    records that could be."""

    opcode: int
    offset: int
    end: int
    content: bytes
    compression: str = ""


@dataclass(frozen=True, slots=True)
class DamagedStretch:
    """Bytes that are no record. ``begin_ns`` and ``end_ns`` are a damaged chunk's own word on its messages' times.

    ``remains`` is what of a damaged chunk can still be decompressed: good for definitions that nothing else gives.
    """

    offset: int
    end: int
    what: str
    begin_ns: int | None = None
    end_ns: int | None = None
    remains: bytes = b""


def scan(data: Buffer) -> Iterator[IntactRecord | DamagedStretch]:
    """Every record of an MCAP file, in order, and every stretch between them that is none.

    Never raises for what the bytes are. A footer is sound only where the file's end follows it.
    """
    size = len(data)
    if data[: len(MAGIC)] != MAGIC:
        yield DamagedStretch(0, min(len(MAGIC), size), "the mark at the file's begin")
    position = len(MAGIC)
    chunked = False
    while position < size:
        found = _record(data, position)
        if isinstance(found, IntactRecord) and (found.opcode in _CERTAIN or _head_like(data, found.end)):
            chunked = chunked or found.opcode == Opcode.CHUNK
            yield found
            position = found.end
            if found.opcode == Opcode.FOOTER:
                return
            continue
        chunked = chunked or data[position : position + 1] == bytes([Opcode.CHUNK])
        broken = found if isinstance(found, DamagedStretch) else DamagedStretch(position, found.end, "a record")
        by_length = broken.end if position < broken.end < size and _head_like(data, broken.end) else None
        end = by_length or _next_record(data, position + 1, chunked)
        if end == size and broken.remains and broken.end > size:
            # Cut off rather than damaged: the part written is valid.
            yield IntactRecord(Opcode.CHUNK, position, end, _whole_records(broken.remains))
            yield replace(
                broken, end=end, what="the file ends within a chunk, whose readable begin was kept", remains=b""
            )
            return
        yield replace(
            broken, end=end, what="the file ends within a record" if end == size < broken.end else broken.what
        )
        position = end


def records(content: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Opcode, offset and content of each record in a chunk's ``content``. Raises ValueError if it ends within one."""
    position = 0
    while position < len(content):
        if len(content) - position < RECORD_HEAD.size:
            raise ValueError("ends within a record's head")
        opcode, length = RECORD_HEAD.unpack_from(content, position)
        end = position + RECORD_HEAD.size + length
        if end > len(content):
            raise ValueError("ends within a record")
        yield opcode, position, content[position + RECORD_HEAD.size : end]
        position = end


RecordT = TypeVar("RecordT", Schema, Channel, Header, Metadata, MessageIndex, Attachment)


def strict(kind: type[RecordT], content: bytes) -> RecordT | None:
    """The record in ``content``, or None where the bytes are not exactly one."""
    try:
        record = kind.read(ReadDataStream(BytesIO(content)))
        builder = RecordBuilder()
        record.write(builder)
    except _BAD:
        return None
    written: bytes = builder.end()[RECORD_HEAD.size :]  # type: ignore[no-untyped-call]
    unchecked = kind is Attachment and written[:-4] + bytes(4) == content  # a checksum of 0 is none
    return record if written == content or unchecked else None


# --- One record ----------------------------------------------------------------------------------------------------


def _record(data: Buffer, position: int) -> IntactRecord | DamagedStretch:
    """The record at ``position``, or a damaged stretch there, whose ``end`` is as its length field says."""
    size = len(data)
    head = data[position : position + RECORD_HEAD.size]
    if len(head) < RECORD_HEAD.size:
        return DamagedStretch(position, size, "a record")
    opcode, length = RECORD_HEAD.unpack(head)
    begin = position + RECORD_HEAD.size
    end = begin + length
    if opcode == Opcode.CHUNK:
        return _chunk(data, position, min(end, size + 1))
    if opcode == Opcode.ATTACHMENT:
        return _attachment(data, position, min(end, size + 1))
    if end > size:
        return DamagedStretch(position, size + 1, "a record")
    if not _known(opcode):
        return DamagedStretch(position, end, "a record of no known kind")
    if opcode == Opcode.FOOTER and (length != 20 or data[end : end + len(MAGIC) + 1] != MAGIC):
        return DamagedStretch(position, end, "the footer")
    content = data[begin:end]
    return (
        IntactRecord(opcode, position, end, content)
        if _holds(opcode, content)
        else DamagedStretch(position, end, "a record")
    )


def _holds(opcode: int, content: bytes) -> bool:
    """Whether ``content`` can be that of a record of this kind."""
    if (kind := _KINDS.get(opcode)) is not None:
        return strict(kind, content) is not None
    return len(content) >= MESSAGE.size if opcode == Opcode.MESSAGE else opcode != Opcode.DATA_END or len(content) == 4


_KINDS: Mapping[int, Any] = {
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.HEADER: Header,
    Opcode.METADATA: Metadata,
    Opcode.MESSAGE_INDEX: MessageIndex,
}
#: Sound records of these kinds are surely records: nothing needs to follow them.
_CERTAIN = frozenset({*_KINDS, Opcode.CHUNK, Opcode.ATTACHMENT, Opcode.FOOTER})


def _chunk(data: Buffer, position: int, end: int) -> IntactRecord | DamagedStretch:
    """The chunk at ``position``. Its length is written twice; where they differ, the one that the checksum proves."""
    begin = position + RECORD_HEAD.size
    head = data[begin : begin + CHUNK_HEAD.size + 4 + 8]
    try:
        first, last, size, crc, name_length = CHUNK_HEAD.unpack_from(head)
        compression = {b"": "", b"lz4": "lz4", b"zstd": "zstd"}[head[CHUNK_HEAD.size : CHUNK_HEAD.size + name_length]]
        (inner,) = struct.unpack_from("<Q", head, CHUNK_HEAD.size + name_length)
    except (struct.error, KeyError):
        return DamagedStretch(position, end, "a chunk's head")
    if size > MOST_UNPACKED:
        return DamagedStretch(position, end, f"a chunk that says it unpacks to {amount(size)}", first, last)
    payload = begin + CHUNK_HEAD.size + name_length + 8
    remains = b""
    for stop in dict.fromkeys((payload + inner, end)):
        if payload <= stop <= len(data):
            content = _decompress(data[payload:stop], compression, size)
            remains = remains or content
            if _proven(content, size, crc):
                return IntactRecord(Opcode.CHUNK, position, stop, content, compression)
    if not remains and payload + inner > len(data):
        remains = _decompress(data[payload:], compression, size)
    return DamagedStretch(position, end, what="a chunk", begin_ns=first, end_ns=last, remains=remains)


def _proven(content: bytes, size: int, crc: int) -> bool:
    if len(content) != size or (crc and zlib.crc32(content) != crc):
        return False
    try:
        return all(_holds(opcode, record) for opcode, _, record in records(content))
    except ValueError:
        return False


def _decompress(data: bytes, compression: str, size: int) -> bytes:
    """All of ``data`` that can be decompressed, little more than ``size`` bytes."""
    if not compression:
        return data
    machine: Any = (
        lz4.frame.LZ4FrameFile(BytesIO(data))
        if compression == "lz4"
        else zstandard.ZstdDecompressor().stream_reader(data, read_size=_PIECE)
    )
    content = bytearray()
    with suppress(zstandard.ZstdError, RuntimeError, EOFError, MemoryError):
        while len(content) <= size and (piece := machine.read1(_PIECE)):
            content += piece
    return bytes(content)


def _whole_records(content: bytes) -> bytes:
    """The begin of ``content``, up to the last record that is all there."""
    end = 0
    with suppress(ValueError):
        for _, offset, record in records(content):
            end = offset + RECORD_HEAD.size + len(record)
    return content[:end]


def _attachment(data: Buffer, position: int, end: int) -> IntactRecord | DamagedStretch:
    begin = position + RECORD_HEAD.size
    for stop in (end, begin + (_attachment_length(data[begin : begin + 4096]) or 0)):
        if begin < stop <= len(data):
            content = data[begin:stop]
            if strict(Attachment, content) is not None:
                return IntactRecord(Opcode.ATTACHMENT, position, stop, content)
    return DamagedStretch(position, end, "an attached file")


def _attachment_length(content: bytes) -> int | None:
    """Length of the attachment at the begin of ``content``, by its own fields."""
    position = 16  # behind two times
    try:
        for _ in range(2):
            (size,) = struct.unpack_from("<I", content, position)
            position += 4 + size
        (size,) = struct.unpack_from("<Q", content, position)
    except struct.error:
        return None
    return int(position + 8 + size + 4)


# --- Finding the next one -----------------------------------------------------------------------------------------


def _head_like(data: Buffer, position: int) -> bool:
    """Whether a record could begin here, or the file rightly ends."""
    rest = data[position : position + RECORD_HEAD.size]
    if len(rest) < RECORD_HEAD.size:
        return not rest or rest == MAGIC
    opcode, length = RECORD_HEAD.unpack(rest)
    return _known(opcode) and length < _LONGEST


def _known(opcode: int) -> bool:
    """Whether the specification has this kind of record, or leaves it to other programs (0x80 and up)."""
    return 0 < opcode <= Opcode.DATA_END or opcode >= 0x80


def _next_record(data: Buffer, position: int, chunked: bool) -> int:
    """Offset of the next certain record at or after ``position``; the file's end if there is none.

    In a file of chunks, messages are in chunks alone: bytes that look like one are the content of a damaged chunk.
    """
    while found := _CANDIDATE.search(data, position):
        position = found.start()
        opcode = found[0][0]
        inside = (Opcode.MESSAGE, Opcode.SCHEMA, Opcode.CHANNEL)
        record = _record(data, position) if not (chunked and opcode in inside) else None
        if isinstance(record, IntactRecord) and (_head_like(data, record.end) or record.opcode == Opcode.FOOTER):
            return position
        position += 1
    return len(data)
