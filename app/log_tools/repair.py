"""Makes a damaged recording readable: its intact records go into a new file with index and summary."""

from __future__ import annotations

import mmap
import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Header, MessageIndex, Metadata, Schema

from app.base.plain_file import open_plain
from app.log_tools import recover
from app.log_tools.recover import DamagedStretch, IntactRecord
from app.logs.layout import PROFILE, library
from app.logs.log import LogError
from app.logs.mcap.open_file import is_being_written
from app.logs.mcap.structure import MAGIC
from app.logs.output_file import McapCopy, Progress, check_new, durable, replacing, unwatched
from app.logs.stamps import SECOND, from_ns

#: Message about a file that begins as MCAP files do, and holds nothing more.
NOTHING = "nothing in it can be read, nor recovered: it begins as a log does, but holds no message that is whole"

#: A damaged chunk's word on its end is believed no further than this beyond the last message.
_LONGEST_GAP_NS = 3600 * SECOND


@dataclass(frozen=True, slots=True)
class Loss:
    """A damaged stretch of a file: ``bytes`` of it at ``offset``, ``what`` they were.

    ``seconds`` (robot's clock) are between the messages before and after it: at most these are missing; None if
    unknown. ``index`` is True if only an index was damaged, which speeds up reading, so that no message is missing.
    """

    offset: int
    bytes: int
    what: str
    seconds: float | None = None
    index: bool = False


@dataclass(frozen=True, slots=True)
class RepairReport:
    """Result of a repair.

    ``out`` is the new file, None if there was nothing to repair (``healthy``) or nothing was to be written.
    ``finished``: the file has its summary and end. ``ended``: the end of its messages is in it; without that, an
    unknown number of messages is missing. ``begin`` and ``end`` (robot's clock, s) of the ``messages`` recovered, equal
    if there are none; ``orphans`` are messages of an unknown channel. ``unreadable_bytes`` of the file's ``bytes``
    could not be read.
    """

    path: Path
    out: Path | None
    healthy: bool
    finished: bool
    ended: bool
    bytes: int
    messages: int
    channels: int
    attachments: int
    begin: float
    end: float
    orphans: int = 0
    losses: tuple[Loss, ...] = ()

    @property
    def unreadable_bytes(self) -> int:
        """Bytes of records of which nothing could be kept, the index apart."""
        return sum(loss.bytes for loss in self.losses if not loss.index)


def repair(
    path: Path, out: Path | None, *, force: bool = False, progress: Progress = unwatched, in_place: bool = False
) -> RepairReport:
    """Copy the intact records of the MCAP file ``path`` to ``out``; nothing is written if ``path`` is healthy.

    ``in_place`` replaces ``path`` itself (``out`` is ignored). Works on any program's MCAP file. Blocks; ``progress``
    counts bytes. Raises LogError if nothing at all can be recovered, or ``out`` cannot be written.
    """
    target = path if in_place or out is None else out
    if not in_place:
        check_new(target, force)
    _check_closed(path)
    with _mapped(path) as data:
        found = _Examination(data, progress, 2)
        report = _report(path, None, len(data), found)
        if report.healthy:
            return report
        if not report.messages and not report.attachments:
            if data[: len(MAGIC)] != MAGIC:
                raise LogError(f"{path}: is no MCAP file; only these can be repaired")
            raise LogError(f"{path}: {NOTHING}")
        with replacing(target, force or in_place) as part, part.open("wb") as stream:
            _rewrite(data, found, stream, progress)
            durable(stream)
        return _report(path, target, len(data), found)


def examine(path: Path, progress: Progress = unwatched) -> RepairReport:
    """The report that :func:`repair` would give, without writing anything. Raises LogError if ``path`` cannot be
    read."""
    with _mapped(path) as data:
        return _report(path, None, len(data), _Examination(data, progress, 1))


def _check_closed(path: Path) -> None:
    """Raise LogError while ``path`` is being recorded: its last messages are not in it yet, and nothing is damaged."""
    with suppress(OSError):  # reported by the next reader
        if path.is_file() and is_being_written(path):
            raise LogError(f"{path} is being recorded now; there is nothing to repair until that has ended")


@contextmanager
def _mapped(path: Path) -> Iterator[mmap.mmap]:
    try:
        with open_plain(path) as stream:
            if not stream.seek(0, 2):
                raise LogError(f"{path} is empty: nothing was written to it")
            data = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
            try:
                yield data
            finally:
                # An interrupted search still holds it; it is closed when that is forgotten.
                with suppress(BufferError):
                    data.close()
    except OSError as failure:
        raise LogError(f"{path} cannot be read: {failure.strerror or failure}") from failure


def _report(path: Path, out: Path | None, size: int, found: _Examination) -> RepairReport:
    known = {number: count for number, count in found.counts.items() if number in found.channels}
    return RepairReport(
        path=path,
        out=out,
        healthy=found.finished and not found.losses,
        finished=found.finished,
        ended=found.ended,
        bytes=size,
        messages=sum(known.values()),
        channels=len(known),
        attachments=found.attachments,
        begin=from_ns(found.begin or 0),
        end=from_ns(found.end or 0),
        orphans=found.counts.total() - sum(known.values()),
        losses=tuple(sorted(found.losses, key=lambda loss: loss.offset)),
    )


class _Examination:
    """One pass through all records: definitions, counts, and damage."""

    def __init__(self, data: mmap.mmap, progress: Progress, rounds: int) -> None:
        self.header: Header | None = None
        self.compression = "zstd"
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.counts: Counter[int] = Counter()
        self.attachments = 0
        self.begin: int | None = None
        self.end: int | None = None
        self.losses: list[Loss] = []
        self.finished = False
        self._data = data
        self._data_ended = False
        #: Stretches that may have held messages, until it is known what time comes after them.
        self._open: list[DamagedStretch] = []
        #: Offsets of each channel's messages in the last chunk, which its index must agree with.
        self._offsets: dict[int, list[int]] = {}
        doubtful = []
        for part in recover.scan(data):
            progress(part.end, rounds * len(data))
            if isinstance(part, IntactRecord):
                self._sound(part)
            else:
                self._broken(part)
                doubtful.append(part.remains)
        self._settle(None)
        for remains in doubtful:
            self._adopt(remains)
        for number, channel in list(self.channels.items()):
            if channel.schema_id and channel.schema_id not in self.schemas:
                del self.channels[number]

    @property
    def ended(self) -> bool:
        """Whether the messages come to their end within the file: what ends them is there, or the file's own end."""
        return self._data_ended or (len(self._data) >= 2 * len(MAGIC) and self._data[-len(MAGIC) :] == MAGIC)

    def _sound(self, part: IntactRecord) -> None:
        match part.opcode:
            case Opcode.CHUNK:
                self._chunk(part)
            case Opcode.MESSAGE_INDEX:
                self._index(part)
            case Opcode.ATTACHMENT:
                self.attachments += 1
            case Opcode.HEADER:
                self.header = self.header or recover.strict(Header, part.content)
            case Opcode.DATA_END:
                self._data_ended = True
            case Opcode.FOOTER:
                self.finished = self._summary_holds(part)
                if not self.finished:
                    self._hurt_index(part, "the summary")
            case Opcode.MESSAGE:
                self._message(part.content)
            case _:
                self._define(part.opcode, part.content)

    def _broken(self, part: DamagedStretch) -> None:
        helpers = (Opcode.MESSAGE_INDEX, Opcode.DATA_END, Opcode.FOOTER)
        if self._data_ended or part.offset == 0 or self._data[part.offset] in helpers:
            self._hurt_index(part, part.what)
        else:
            self._open.append(part)

    def _hurt_index(self, part: IntactRecord | DamagedStretch, what: str) -> None:
        self.losses.append(Loss(part.offset, part.end - part.offset, what, 0.0, index=True))

    def _chunk(self, part: IntactRecord) -> None:
        self._offsets = {}
        if not self.counts:
            self.compression = part.compression
        for opcode, offset, content in recover.records(part.content):
            if opcode == Opcode.MESSAGE:
                channel = self._message(content)
                self._offsets.setdefault(channel, []).append(offset)
            else:
                self._define(opcode, content)

    def _message(self, content: bytes) -> int:
        channel, _, log_time, _ = recover.MESSAGE.unpack_from(content)
        self._settle(log_time)
        self.counts[channel] += 1
        self.begin = log_time if self.begin is None else min(self.begin, log_time)
        self.end = log_time if self.end is None else max(self.end, log_time)
        return int(channel)

    def _index(self, part: IntactRecord) -> None:
        index = recover.strict(MessageIndex, part.content)
        if index is not None and sorted(at for _, at in index.records) != self._offsets.get(index.channel_id, []):
            self._hurt_index(part, "an index")

    def _define(self, opcode: int, content: bytes) -> None:
        if opcode == Opcode.SCHEMA and (schema := recover.strict(Schema, content)) is not None:
            self.schemas.setdefault(schema.id, schema)
        elif opcode == Opcode.CHANNEL and (channel := recover.strict(Channel, content)) is not None:
            self.channels.setdefault(channel.id, channel)

    def _adopt(self, remains: bytes) -> None:
        """Take from a damaged chunk the definitions that stand nowhere else: better doubtful than none."""
        with suppress(ValueError):  # where the remains end
            for opcode, _, content in recover.records(remains):
                self._define(opcode, content)

    def _summary_holds(self, footer: IntactRecord) -> bool:
        start, _, crc = struct.unpack("<QQI", footer.content)
        if not len(MAGIC) <= start < footer.offset:
            return False
        return not crc or zlib.crc32(self._data[start : footer.end - 4]) == crc

    def _settle(self, after: int | None) -> None:
        """Set the duration of the open losses: the next readable message came at ``after`` (None: there is none)."""
        for part in self._open:
            since = self.end if self.end is not None else part.begin_ns
            until = after if after is not None else part.end_ns
            seconds = None
            if since is not None and until is not None and 0 <= until - since < _LONGEST_GAP_NS:
                seconds = (until - since) / SECOND
            self.losses.append(Loss(part.offset, part.end - part.offset, part.what, seconds))
        self._open.clear()


def _rewrite(data: mmap.mmap, found: _Examination, stream: IO[bytes], progress: Progress) -> None:
    """Write everything sound to ``stream``."""
    header = found.header or Header(PROFILE, library())
    copy = McapCopy(stream, header.profile, header.library, found.compression)
    for channel in found.channels.values():
        copy.declare(channel, found.schemas.get(channel.schema_id))

    for part in recover.scan(data):
        progress(len(data) + part.end, 2 * len(data))
        if isinstance(part, DamagedStretch):
            continue
        inside = recover.records(part.content) if part.opcode == Opcode.CHUNK else [(part.opcode, 0, part.content)]
        for opcode, _, content in inside:
            if opcode == Opcode.MESSAGE:
                number, sequence, log_time, publish_time = recover.MESSAGE.unpack_from(content)
                if number in found.channels:
                    copy.message(number, log_time, content[recover.MESSAGE.size :], publish_time, sequence)
            elif opcode == Opcode.ATTACHMENT and (file := recover.strict(Attachment, content)) is not None:
                copy.attachment(file.log_time, file.create_time, file.name, file.media_type, file.data)
            elif opcode == Opcode.METADATA and (metadata := recover.strict(Metadata, content)) is not None:
                copy.metadata(metadata.name, metadata.metadata)
    copy.finish()
