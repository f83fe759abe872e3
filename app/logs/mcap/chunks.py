"""MCAP files by their chunks, without decoding messages: scan one, complete one that has no end, join several.

Chunks and their message indexes are copied unchanged; only the records that point at them are written again. The order
of records in a file and their layout: MCAP specification, version 0 (https://mcap.dev/spec).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO

from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from app.logs.log import LogError
from app.logs.mcap.bounds import records_of
from app.logs.mcap.structure import CHUNK_HEAD, MAGIC, RECORD_HEAD, is_closed

_INDEX_HEAD = struct.Struct("<HI")
_COPY_BYTES = 1 << 20


@dataclass(frozen=True, slots=True)
class Span:
    """A record's place in a file: its first byte and all its bytes, opcode and length included."""

    opcode: int
    offset: int
    length: int


@dataclass(frozen=True, slots=True)
class ChunkSpan:
    """A chunk with the message indexes right behind it, as its ``index`` record says; ``counts`` of messages by channel
    id."""

    index: ChunkIndex
    counts: dict[int, int]

    @property
    def offset(self) -> int:
        """The chunk's first byte."""
        return self.index.chunk_start_offset

    @property
    def length(self) -> int:
        """Bytes of the chunk and its indexes."""
        return self.index.chunk_length + self.index.message_index_length


@dataclass(slots=True)
class FileContents:
    """The content of a file: ``end`` is the byte after its last whole chunk; ``complete`` files have a summary."""

    header: Header = field(default_factory=lambda: Header("", ""))
    attachments: list[Span] = field(default_factory=list)
    metadata: list[Span] = field(default_factory=list)
    chunks: list[ChunkSpan] = field(default_factory=list)
    end: int = 0
    complete: bool = False

    @property
    def begin_ns(self) -> int:
        """When its first message arrived; 0 in a file without any."""
        return min((chunk.index.message_start_time for chunk in self.chunks), default=0)

    @property
    def messages(self) -> int:
        """Number of message records."""
        return sum(sum(chunk.counts.values()) for chunk in self.chunks)


def spans(file: BinaryIO) -> Iterator[Span]:
    """Every whole record of ``file`` from its beginning. Raises LogError where it is no MCAP file."""
    size = file.seek(0, 2)
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        raise LogError(f"{getattr(file, 'name', 'this file')} is not an MCAP file")
    offset = len(MAGIC)
    while offset + RECORD_HEAD.size <= size:
        file.seek(offset)
        prefix = file.read(RECORD_HEAD.size)
        opcode, length = RECORD_HEAD.unpack(prefix)
        if offset + RECORD_HEAD.size + length > size:
            return
        yield Span(opcode, offset, RECORD_HEAD.size + length)
        offset += RECORD_HEAD.size + length


def scan(file: BinaryIO) -> FileContents:
    """Look through ``file``, skipping what chunks hold. Raises LogError where it is no MCAP file."""
    found = FileContents(end=len(MAGIC))
    pending: ChunkSpan | None = None

    def settle() -> None:
        # A chunk counts once all its messages are indexed: a file cut off in between ends before it.
        nonlocal pending
        if pending is not None:
            found.chunks.append(pending)
            found.end = pending.offset + pending.length
            pending = None

    for span in spans(file):
        if span.opcode == Opcode.MESSAGE_INDEX:
            if pending is not None:
                channel, entries = _INDEX_HEAD.unpack(_head(file, span, _INDEX_HEAD.size))
                pending.index.message_index_offsets[channel] = span.offset
                pending.index.message_index_length += span.length
                pending.counts[channel] = entries // 16
            continue
        settle()
        match span.opcode:
            case Opcode.CHUNK:
                pending = _chunk_span(file, span)
                continue
            case Opcode.HEADER:
                found.header = Header.read(body(file, span))
            case Opcode.ATTACHMENT:
                found.attachments.append(span)
            case Opcode.METADATA:
                found.metadata.append(span)
            case Opcode.DATA_END:
                found.complete = is_closed(file)
                break
        found.end = span.offset + span.length
    if pending is not None and _all_indexed(file, pending):
        settle()
    return found


def complete(path: Path) -> FileContents:
    """Append the summary to a file that has no end, in place, after cutting off an incomplete record.

    Raises LogError where it is no MCAP file, OSError where it cannot be written.
    """
    with open(path, "r+b") as file:
        found = scan(file)
        if found.complete:
            return found
        summary = _Summary()
        summary.take(file, found)
        file.seek(found.end)
        file.truncate()
        file.write(summary.end(found.end))
    return found


def join(
    sources: Sequence[Path],
    target: BinaryIO,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Write the chunks of ``sources`` one behind the other into ``target``.

    The sources were written with the same ids for channels and schemas; attachments and metadata are those of the
    first. Calls ``progress(done, total)`` with bytes. Returns the number of message records. Raises LogError, OSError.
    """
    files = [open(path, "rb") for path in sources]  # noqa: SIM115  # closed below
    try:
        contents = [scan(file) for file in files]
        for found in contents[1:]:
            found.attachments, found.metadata = [], []
        total = sum(chunk.length for found in contents for chunk in found.chunks)
        summary = _Summary()
        builder = RecordBuilder()
        contents[0].header.write(builder)
        position = target.write(MAGIC) + target.write(_taken(builder))
        for file, found in zip(files, contents, strict=True):
            placed = [(span.offset, span.length) for span in (*found.attachments, *found.metadata)]
            shift: dict[int, int] = {}
            for offset, length in [*placed, *((chunk.offset, chunk.length) for chunk in found.chunks)]:
                shift[offset] = position - offset
                position += _copy(file, offset, length, target)
                progress(min(position, total), total)
            summary.take(file, found, shift)
        target.write(summary.end(position))
        return summary.messages
    finally:
        for file in files:
            file.close()


class _Summary:
    """The end section of a file, computed from the records before it."""

    def __init__(self) -> None:
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._chunks: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._counts: dict[int, int] = {}

    @property
    def messages(self) -> int:
        """Number of message records."""
        return sum(self._counts.values())

    def take(self, file: BinaryIO, found: FileContents, shift: Mapping[int, int] = MappingProxyType({})) -> None:
        """Add the contents of ``file``; a record that was copied is ``shift[offset]`` bytes further now."""
        for span in found.attachments:
            self._attachments.append(_attachment_index(file, span, span.offset + shift.get(span.offset, 0)))
        for span in found.metadata:
            name = Metadata.read(body(file, span)).name
            self._metadata.append(MetadataIndex(span.offset + shift.get(span.offset, 0), span.length, name))
        for chunk in found.chunks:
            self._definitions(file, chunk)
            by = shift.get(chunk.offset, 0)
            offsets = {channel: offset + by for channel, offset in chunk.index.message_index_offsets.items()}
            self._chunks.append(
                replace(chunk.index, chunk_start_offset=chunk.offset + by, message_index_offsets=offsets)
            )
            for channel, count in chunk.counts.items():
                self._counts[channel] = self._counts.get(channel, 0) + count

    def _definitions(self, file: BinaryIO, chunk: ChunkSpan) -> None:
        """Schemas and channels stand in the chunk before their first message; only then is it looked into."""
        if chunk.counts.keys() <= self._channels.keys():
            return
        for record in records_of(_chunk(file, chunk), validate_crc=True):
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._channels[record.id] = record

    def end(self, position: int) -> bytes:
        """Write the end of a file whose data section ends at ``position``, up to its last byte."""
        data_end = RecordBuilder()
        DataEnd(0).write(data_end)
        head = _taken(data_end)
        start = position + len(head)
        statistics = Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=self.messages,
            metadata_count=len(self._metadata),
            message_start_time=min((c.message_start_time for c in self._chunks), default=0),
            message_end_time=max((c.message_end_time for c in self._chunks), default=0),
            schema_count=len(self._schemas),
        )
        groups = (
            (Opcode.SCHEMA, self._schemas.values()),
            (Opcode.CHANNEL, self._channels.values()),
            (Opcode.STATISTICS, (statistics,)),
            (Opcode.CHUNK_INDEX, self._chunks),
            (Opcode.ATTACHMENT_INDEX, self._attachments),
            (Opcode.METADATA_INDEX, self._metadata),
        )
        summary = RecordBuilder()
        offsets = []
        for opcode, records in groups:
            begin = summary.count
            for record in records:
                record.write(summary)
            if summary.count > begin:
                offsets.append(SummaryOffset(opcode, start + begin, summary.count - begin))
        offset_start = start + summary.count
        for offset in offsets:
            offset.write(summary)
        body = _taken(summary)
        crc = zlib.crc32(struct.pack("<BQQQ", Opcode.FOOTER, 20, start, offset_start), zlib.crc32(body))
        footer = RecordBuilder()
        Footer(summary_start=start, summary_offset_start=offset_start, summary_crc=crc).write(footer)
        return head + body + _taken(footer) + MAGIC


def _taken(builder: RecordBuilder) -> bytes:
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


def body(file: BinaryIO, span: Span) -> ReadDataStream:
    """The content of the record at ``span``."""
    file.seek(span.offset + RECORD_HEAD.size)
    return ReadDataStream(BytesIO(file.read(span.length - RECORD_HEAD.size)))


def _head(file: BinaryIO, span: Span, size: int) -> bytes:
    file.seek(span.offset + RECORD_HEAD.size)
    return file.read(size)


def _chunk_span(file: BinaryIO, span: Span) -> ChunkSpan:
    begin_ns, end_ns, uncompressed, _, name_length = CHUNK_HEAD.unpack(_head(file, span, CHUNK_HEAD.size))
    compression = file.read(name_length).decode()
    (compressed,) = struct.unpack("<Q", file.read(8))
    index = ChunkIndex(
        chunk_length=span.length,
        chunk_start_offset=span.offset,
        compression=compression,
        compressed_size=compressed,
        message_end_time=end_ns,
        message_index_length=0,
        message_index_offsets={},
        message_start_time=begin_ns,
        uncompressed_size=uncompressed,
    )
    return ChunkSpan(index, {})


def _chunk(file: BinaryIO, chunk: ChunkSpan) -> Chunk:
    record: Chunk = Chunk.read(body(file, Span(Opcode.CHUNK, chunk.offset, chunk.index.chunk_length)))
    return record


def _all_indexed(file: BinaryIO, chunk: ChunkSpan) -> bool:
    """Whether the last chunk of a file has an index of each of its messages."""
    records = records_of(_chunk(file, chunk))
    return sum(chunk.counts.values()) == sum(not isinstance(record, Schema | Channel) for record in records)


def _attachment_index(file: BinaryIO, span: Span, offset: int) -> AttachmentIndex:
    stream = body(file, span)
    log_time, create_time = stream.read8(), stream.read8()
    name, media_type = stream.read_prefixed_string(), stream.read_prefixed_string()
    return AttachmentIndex(offset, span.length, log_time, create_time, stream.read8(), name, media_type)


def _copy(file: BinaryIO, offset: int, length: int, target: BinaryIO) -> int:
    file.seek(offset)
    left = length
    while left:
        data = file.read(min(left, _COPY_BYTES))
        target.write(data)
        left -= len(data)
    return length
