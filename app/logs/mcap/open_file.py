"""One MCAP file while it is written: complete at any time up to its last chunk, and closed as far as the disk permits.

For one thread. Files and facts of the manifest are at the beginning, since a file whose writer was killed has no end.
"""

from __future__ import annotations

import fcntl
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from mcap.writer import CompressionType, Writer

from app.logs import layout
from app.logs.manifest import Manifest
from app.logs.mcap.chunks import complete
from app.logs.ros.encoder import Encoder
from app.logs.ros.record import Record
from app.logs.ros.robot_description import METADATA as ROBOT_METADATA
from app.logs.ros.robot_description import robot_description
from app.logs.stamps import to_ns


class RawFile(Protocol):
    """A file opened for writing without a buffer (``open(path, "xb", buffering=0)``)."""

    def write(self, data: memoryview, /) -> int | None:
        """Write from the beginning of ``data``; returns how many bytes were taken. Raises OSError."""
        ...

    def truncate(self, size: int, /) -> int:
        """Cut the file to ``size`` bytes. Raises OSError."""
        ...

    def close(self) -> None:
        """Close it."""
        ...


#: Creates a file that must not exist yet. Raises FileExistsError, OSError.
OpenFile = Callable[[Path], RawFile]


def create(path: Path) -> RawFile:
    """A new file at ``path``, locked as long as it is open, so that others see that it is being written."""
    file = open(path, "x+b", buffering=0)  # noqa: SIM115  # closed by the caller
    with suppress(OSError):  # a file system without locks
        fcntl.flock(file, fcntl.LOCK_EX)
    return file


def is_being_written(path: Path) -> bool:
    """Whether a program has the file open through :func:`create`, this one or another. Raises OSError."""
    with open(path, "rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:  # a file system without locks
            return False
    return False


class UnrecordableMessage(Exception):
    """A message that is not what its channel says, or one that no file could hold; the message says which and why."""


@dataclass(frozen=True, slots=True)
class FileTopic:
    """A topic in a file: ``definition`` is its type's text, ``metadata`` is in its channel record."""

    name: str
    type: str
    definition: str
    metadata: Mapping[str, str]


class _Output:
    """The file as mcap's Writer wants it: whole writes and a position that costs no system call."""

    def __init__(self, file: RawFile) -> None:
        self.file = file
        self.position = 0

    def write(self, data: bytes) -> int:
        rest = memoryview(data)
        while rest:
            taken = self.file.write(rest)
            if not taken:
                raise OSError("the disk takes nothing")
            self.position += taken
            rest = rest[taken:]
        return len(data)

    def tell(self) -> int:
        return self.position

    def flush(self) -> None:
        """Nothing is kept back."""


class McapFile:
    """An MCAP file being written."""

    def __init__(
        self, path: Path, encoder: Encoder, manifest: Manifest, at: float,
        topics: dict[str, FileTopic] | None = None, open_file: OpenFile = create,
    ) -> None:  # fmt: skip
        """Create ``path`` and begin it with ``manifest``, recorded ``at`` (robot's clock, s).

        ``encoder`` is for this file alone. ``topics`` are those met so far, in the order that gives them their ids, to
        which this file adds its own: files that share them can be joined raw. Raises FileExistsError where there is a
        file already, OSError where it cannot be written.
        """
        self.path = path
        #: Messages taken.
        self.messages = 0
        self._encoder = encoder
        self._records = 0
        self._topics: dict[str, FileTopic] = {} if topics is None else topics
        self._ids: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._closed = False
        self._output = _Output(open_file(path))
        self._good = 0
        # The mcap library calls nothing of a stream but ``write``, ``tell`` and ``flush``.
        self._writer = Writer(self._output, chunk_size=layout.CHUNK_SIZE, compression=CompressionType.ZSTD)  # type: ignore[arg-type]
        try:
            self._writer.start(layout.PROFILE, layout.library())
            self._writer.add_metadata(layout.FACTS, dict(manifest.facts))
            for attached in manifest.files:
                self._writer.add_attachment(to_ns(at), to_ns(at), attached.name, attached.media_type, attached.data)
            self._good = self._output.position
            for topic in self._topics.values():
                self._register(topic)
            self._describe_robot(manifest, to_ns(at))
        except BaseException:
            self._output.file.close()
            with suppress(OSError):
                path.unlink()
            raise

    @property
    def bytes(self) -> int:
        """Bytes on disk."""
        return self._output.position

    def write(self, at: float, channel: str, message: Any) -> None:
        """Take a message that arrived ``at`` (robot's clock, s).

        Raises UnrecordableMessage, having written nothing of it, or OSError; then only :meth:`abandon` is left.
        """
        log_time = to_ns(at)
        try:
            records = self._encoder.encode(channel, message)
        except Exception as error:
            raise UnrecordableMessage(f"{channel}: {type(error).__name__}: {error}") from error
        for record in records:
            channel_id = self._ids.get(record.topic)
            if channel_id is None:
                channel_id = self._meet(record)
            self._records += 1
            self._writer.add_message(channel_id, log_time, record.data, record.stamp_ns, self._records)
            self._good = self._output.position
        self.messages += 1

    def flush(self) -> None:
        """End the chunk in progress and write it. Raises OSError; then only :meth:`abandon` is left."""
        self._writer.flush()  # type: ignore[no-untyped-call]
        self._good = self._output.position

    def close(self) -> None:
        """Write the summary and close. Raises OSError; then only :meth:`abandon` is left."""
        self._writer.finish()  # type: ignore[no-untyped-call]
        self._release()

    def abandon(self) -> None:
        """After a failed write: cut off the incomplete record, and close the file properly if the disk has room for
        that."""
        if self._closed:
            return
        with suppress(OSError):
            self._output.file.truncate(self._good)
        self._release()
        with suppress(OSError):
            complete(self.path)

    def _release(self) -> None:
        self._closed = True
        self._output.file.close()

    def _describe_robot(self, manifest: Manifest, at_ns: int) -> None:
        record = robot_description(manifest, at_ns)
        if record is not None:
            channel_id = self._ids.get(record.topic) or self._meet(record, ROBOT_METADATA)
            self._records += 1
            self._writer.add_message(channel_id, at_ns, record.data, at_ns, self._records)

    def _meet(self, record: Record, metadata: Mapping[str, str] | None = None) -> int:
        # A topic's schema and channel must stand in one chunk, the one of its first message.
        self.flush()
        topic = self._topics.get(record.topic)
        if topic is None:
            if metadata is None:
                metadata = self._encoder.channel_metadata(record.topic)
            topic = FileTopic(record.topic, record.type, self._encoder.definition(record.type), metadata)
            self._topics[record.topic] = topic
        return self._register(topic)

    def _register(self, topic: FileTopic) -> int:
        schema = self._schemas.get(topic.type)
        if schema is None:
            schema = self._writer.register_schema(topic.type, layout.SCHEMA_ENCODING, topic.definition.encode())
            self._schemas[topic.type] = schema
        channel = self._writer.register_channel(topic.name, layout.MESSAGE_ENCODING, schema, dict(topic.metadata))
        self._ids[topic.name] = channel
        return channel
