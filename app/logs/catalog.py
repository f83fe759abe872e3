"""The recordings in a folder: sizes and lengths, read from each file once.

A file's length is in its summary at the end. Reading that of hundreds of files at every listing is too slow; so it is
cached until the file's size or modification time changes.
"""

from __future__ import annotations

import os
import struct
import threading
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import BinaryIO, Literal

from mcap.opcode import Opcode
from mcap.records import Metadata

from app.base.plain_file import open_plain
from app.logs.layout import FACTS
from app.logs.library import RecordingLibrary
from app.logs.log import LogError
from app.logs.mcap.bounds import BoundedReader
from app.logs.mcap.chunks import body, spans
from app.logs.mcap.open_file import is_being_written
from app.logs.mcap.structure import DAMAGE, RECORD_HEAD, is_closed
from app.logs.stamps import from_ns

_STAMP = struct.Struct("<Q")


@dataclass(frozen=True, slots=True)
class Recording:
    """A recording's file.

    ``complete``: it was closed properly; if not, its ``end`` is not known. ``written``: it is being written. ``begin``
    and ``end`` (robot's clock, s) of its messages, None if unknown. ``robot`` is the name in its facts, "" without.
    ``modified`` is the file's own time (s, Unix).
    """

    name: str
    bytes: int
    modified: float
    complete: bool
    written: bool = False
    begin: float | None = None
    end: float | None = None
    robot: str = ""

    @property
    def state(self) -> Literal["complete", "recording", "unfinished"]:
        """``unfinished``: neither closed nor being written; `hbba log repair` makes it readable."""
        return "complete" if self.complete else "recording" if self.written else "unfinished"

    @property
    def duration_s(self) -> float | None:
        """Seconds from the first message to the last."""
        return None if self.begin is None or self.end is None else self.end - self.begin


class Catalog:
    """The recordings of a library. All methods touch the disk: call them off the event loop, from any thread."""

    def __init__(self, library: RecordingLibrary) -> None:
        self._library = library
        self._known: dict[str, tuple[tuple[int, int], Recording]] = {}
        self._lock = threading.Lock()

    def recordings(self) -> list[Recording]:
        """Every recording, the newest first; none where there is no folder yet. Raises OSError if it cannot be read."""
        known = {}
        with self._lock:
            for name, path in self._library.entries():
                # Another program may delete it meanwhile.
                with suppress(FileNotFoundError):
                    if path.is_file():
                        known[name] = self._look(name, path, path.stat())
            self._known = known
        found = [recording for _, recording in known.values()]
        return sorted(found, key=lambda r: (r.modified if r.begin is None else r.begin, r.name), reverse=True)

    def has(self, name: str) -> bool:
        """Whether there is a recording of this name. Raises ValueError for an invalid name."""
        return self._library.path(name).is_file()

    def written(self, name: str) -> bool:
        """Whether a program writes the recording now. Raises ValueError for a bad name, FileNotFoundError, OSError."""
        return is_being_written(self._library.path(name))

    def delete(self, name: str) -> None:
        """Remove a recording for good. Raises ValueError for a bad name, FileNotFoundError, or another OSError."""
        self._library.path(name).unlink()

    def _look(self, name: str, path: Path, status: os.stat_result) -> tuple[tuple[int, int], Recording]:
        sign = (status.st_mtime_ns, status.st_size)
        known = self._known.get(name)
        if known is not None and known[0] == sign and not known[1].written:
            return known
        return sign, read(name, path, status)


def read(name: str, path: Path, status: os.stat_result) -> Recording:
    """Facts of the file at ``path``, from its summary or, where it has none, from its first records."""
    blank = Recording(name, status.st_size, status.st_mtime, complete=False)
    try:
        with open_plain(path) as file:
            if is_closed(file):
                return _summarized(file, blank)
            return replace(_with_start(file, blank), written=is_being_written(path))
    except OSError:
        return blank


def _summarized(file: BinaryIO, blank: Recording) -> Recording:
    try:
        file.seek(0)
        reader = BoundedReader(file)
        summary = reader.get_summary()
        if summary is None or summary.statistics is None:
            return replace(blank, complete=True)
        statistics = summary.statistics
        robot = next((m.metadata.get("robot", "") for m in reader.iter_metadata() if m.name == FACTS), "")
    except DAMAGE:
        return blank
    if statistics.message_count == 0:
        return replace(blank, complete=True, robot=robot)
    begin, end = from_ns(statistics.message_start_time), from_ns(statistics.message_end_time)
    return replace(blank, complete=True, begin=begin, end=end, robot=robot)


def _with_start(file: BinaryIO, blank: Recording) -> Recording:
    """Facts from the records before the first message."""
    robot = ""
    with suppress(LogError, *DAMAGE):
        for span in spans(file):
            if span.opcode == Opcode.CHUNK:
                file.seek(span.offset + RECORD_HEAD.size)
                return replace(blank, begin=from_ns(_STAMP.unpack(file.read(_STAMP.size))[0]), robot=robot)
            if span.opcode == Opcode.METADATA:
                metadata = Metadata.read(body(file, span))
                if metadata.name == FACTS:
                    robot = metadata.metadata.get("robot", "")
    return replace(blank, robot=robot)
