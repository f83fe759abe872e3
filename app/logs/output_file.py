"""Files made from logs: written beside their place under another name, and put there whole or not at all."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from mcap.records import Channel, Schema
from mcap.writer import CompressionType, Writer

from app.logs.layout import CHUNK_SIZE
from app.logs.log import LogError


class DiskTrouble(LogError):
    """The disk is full or refuses; the request itself was valid."""


#: Progress of a long operation: ``(done, total)`` in bytes, or nanoseconds of the log; only their ratio matters.
Progress = Callable[[int, int], None]


def unwatched(done: int, total: int) -> None:
    """A Progress that does nothing."""


def check_new(path: Path, force: bool) -> None:
    """Raise LogError if ``path`` exists and may not be replaced, or its folder does not exist."""
    if path.exists() and not force:
        raise LogError(f"{path} exists already; --force replaces it, -o names another")
    if not path.parent.is_dir():
        raise LogError(f"{path}: there is no folder {path.parent}")


@contextmanager
def replacing(path: Path, force: bool = False) -> Iterator[Path]:
    """A name beside ``path`` to write to; renamed to ``path`` at the end, deleted on any exception.

    If nothing was written there, or the file was deleted, ``path`` is not created. Raises LogError if ``path`` exists
    and ``force`` is not given, DiskTrouble if the disk is full or refuses.
    """
    check_new(path, force)
    # The suffix stays the last part: writers of video choose the container by it.
    part = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        yield part
        if not part.exists():
            return
        if path.exists() and not force:
            raise LogError(f"{path} has come to be meanwhile; nothing was replaced")
        part.replace(path)
    except OSError as failure:
        raise disk_trouble(failure, path) from failure
    finally:
        part.unlink(missing_ok=True)


def disk_trouble(failure: OSError, path: Path) -> DiskTrouble:
    """The exception for people for an OSError under ``path``."""
    if failure.errno in (errno.ENOSPC, errno.EDQUOT):
        return DiskTrouble(f"the disk under {path.parent} is full: {path.name} was not written")
    return DiskTrouble(f"{path} cannot be written: {failure.strerror or failure}")


def durable(stream: IO[bytes]) -> None:
    """Flush the written data to the disk, before the name refers to it."""
    stream.flush()
    os.fsync(stream.fileno())


class McapCopy:
    """A new MCAP file that takes records of another; ids are assigned again, payloads are copied."""

    def __init__(self, stream: IO[bytes], profile: str, library: str, compression: str = "zstd") -> None:
        kinds = {"": CompressionType.NONE, "lz4": CompressionType.LZ4}
        self._writer = Writer(stream, CHUNK_SIZE, kinds.get(compression, CompressionType.ZSTD))
        self._writer.start(profile, library)
        self._schemas: dict[int, int] = {0: 0}
        self._channels: dict[int, int] = {}

    def declare(self, channel: Channel, schema: Schema | None) -> int:
        """Its id here; ``schema`` is that of the channel's ``schema_id``, None where that is 0."""
        if channel.id not in self._channels:
            if schema is not None and schema.id not in self._schemas:
                self._schemas[schema.id] = self._writer.register_schema(schema.name, schema.encoding, schema.data)
            here = self._schemas[channel.schema_id]
            self._channels[channel.id] = self._writer.register_channel(
                channel.topic, channel.message_encoding, here, dict(channel.metadata)
            )
        return self._channels[channel.id]

    def message(self, channel_id: int, log_time: int, data: bytes, publish_time: int, sequence: int) -> None:
        """Copy one message of a declared channel; ``channel_id`` is the one it had in its file."""
        self._writer.add_message(self._channels[channel_id], log_time, data, publish_time, sequence)

    def attachment(self, log_time: int, create_time: int, name: str, media_type: str, data: bytes) -> None:
        """Copy one attached file."""
        self._writer.add_attachment(create_time, log_time, name, media_type, data)

    def metadata(self, name: str, data: dict[str, str]) -> None:
        """Copy one metadata record."""
        self._writer.add_metadata(name, data)

    def finish(self) -> None:
        """Write index, statistics and summary; the stream stays open."""
        self._writer.finish()  # type: ignore[no-untyped-call]
