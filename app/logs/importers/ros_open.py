"""ROS bags opened by rosbags, within bounds: nothing in them is unpacked to more than is read of a message."""

from __future__ import annotations

import bz2
import os
import shutil
import struct
import sys
import tempfile
import zlib
from collections.abc import Callable, Collection, Generator, Mapping
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, cast

import apsw
import lz4.frame
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Bag1
from rosbags.rosbag1 import ReaderError as Bag1Error
from rosbags.rosbag1.reader import Chunk, decompressors
from rosbags.rosbag2 import Reader as Bag2
from rosbags.rosbag2 import ReaderError as Bag2Error
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, TypesysError, get_typestore

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

from app.base.errors import ConfigError
from app.base.plain_file import check_plain, open_plain
from app.base.yaml_source import load_yaml
from app.logs.importers.ros_topics import COLOR_TYPES, INFO_TYPE, PLAIN, TF_TYPES
from app.logs.log import LogError
from app.logs.mcap.bounds import BoundedReader, check_chunks
from app.logs.mcap.decompression import MOST_UNPACKED, NO_FRAME, TooMuch, amount, check_unpacked, unpacked_size, within
from app.logs.mcap.structure import DAMAGE as MCAP_DAMAGE

if TYPE_CHECKING:
    from rosbags.rosbag2.reader import ReaderProtocol

#: Exceptions of rosbags for damaged bags.
DAMAGE = (
    AnyReaderError,
    Bag1Error,
    Bag2Error,
    SerdeError,
    TypesysError,
    OSError,
    EOFError,
    ValueError,
    LookupError,
    AssertionError,
    MemoryError,
    OverflowError,
    RuntimeError,  # of the lz4 library
    zstd.ZstdError,
    apsw.Error,
    struct.error,
    zlib.error,
)
_TYPES = COLOR_TYPES | TF_TYPES | {INFO_TYPE, *PLAIN}
#: Of the disk, so much (bytes) is left free where a bag's files are unpacked.
_LEFT_FREE = 1_000_000_000


def opened(path: Path) -> tuple[AnyReader, list[Connection], tempfile.TemporaryDirectory[str] | None]:
    """The bag, opened, and its connections of types that are not read.

    rosbags goes by a file's ending; one that is named otherwise gets a name of its own. Raises LogError.
    """
    named: tempfile.TemporaryDirectory[str] | None = None
    shown = path
    if path.is_file():
        ending = _ending(path)
        if path.suffix != ending:
            named = tempfile.TemporaryDirectory(prefix="hbba-bag-")
            shown = Path(named.name) / f"bag{ending}"
            os.symlink(path.resolve(), shown)
    try:
        reader = AnyReader([shown], default_typestore=get_typestore(Stores.ROS2_HUMBLE))
        reader.readers = [_Bag2(shown)] if reader.is2 else [_Bag1(shown)]
        reader.open()
    except (TooMuch, ConfigError, *DAMAGE) as failure:
        if named is not None:
            named.cleanup()
        said = words(failure)
        hint = "; 'rosbag reindex' of ROS 1 makes it whole" if "reindex" in said or "index" in said.lower() else ""
        raise LogError(f"{path}: is a bag that cannot be read: {said}{hint}") from None
    others = [connection for bag in reader.readers for connection in bag.others]
    return reader, others, named


def _ending(path: Path) -> str:
    with open_plain(path) as file:
        head = file.read(16)
    if head.startswith(b"#ROSBAG"):
        return ".bag"
    return ".db3" if head.startswith(b"SQLite") else ".mcap"


def words(failure: BaseException) -> str:
    """The message of an exception of rosbags."""
    return str(failure) or type(failure).__name__


class _Bag1(Bag1):
    """Shows the connections that can be read alone: no other type's definition need be understood."""

    others: list[Connection]

    def open(self) -> None:
        super().open()
        self.connections, self.others = _sorted_out(self.connections)

    def read_chunk(self) -> Chunk:
        chunk = super().read_chunk()
        name = next(name for name, unpack in decompressors.items() if unpack is chunk.decompressor)
        return chunk._replace(decompressor=_BOUNDED[name])


class _Mcap(McapReader):
    def open(self) -> None:
        """Raises LogError for chunks that become too much."""
        path = Path(str(self.path))
        with open_plain(path) as file:
            try:
                summary = BoundedReader(file).get_summary()
            except MCAP_DAMAGE:  # rosbags may do without it
                summary = None
            check_chunks(path, file, summary)
        super().open()


class _Sqlite(Sqlite3Reader):
    def open(self) -> None:
        check_plain(str(self.path))
        super().open()
        if self.dbconn is not None:
            self.dbconn.limit(apsw.SQLITE_LIMIT_LENGTH, MOST_UNPACKED)


class _Folder(DirectoryReader):
    STORAGE_PLUGINS: Mapping[str, type[ReaderProtocol]] = {"mcap": _Mcap, "sqlite3": _Sqlite}
    _messages_packed = False

    def open(self) -> None:
        """Raises LogError for files that become too much, ConfigError for a description that does."""
        said = load_yaml(Path(str(self.path)) / "metadata.yaml").data
        about = said.get("rosbag2_bagfile_information") if isinstance(said, dict) else None
        if isinstance(about, dict) and str(about.get("compression_mode", "")).lower() == "file":
            _check_room(Path(str(self.path)), about.get("relative_file_paths"))
        super().open()
        if self.metadata.compression_mode == "message":
            self._messages_packed = True
            self.metadata = self.metadata._replace(compression_mode=None)

    def messages(
        self, connections: Collection[Connection] = (), start: int | None = None, stop: int | None = None
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        for connection, at, data in super().messages(connections, start, stop):
            yield connection, at, _unpacked_zstd(data) if self._messages_packed else data


class _Bag2(Bag2):
    """The same of ROS 2."""

    STORAGE_PLUGINS: Mapping[str, type[ReaderProtocol]] = {"dir": _Folder, ".mcap": _Mcap, ".db3": _Sqlite}
    others: list[Connection]

    def open(self) -> None:
        super().open()
        self.storage.connections, self.others = _sorted_out(self.storage.connections)


def _sorted_out(connections: list[Connection]) -> tuple[list[Connection], list[Connection]]:
    read = [connection for connection in connections if connection.msgtype in _TYPES]
    return read, [connection for connection in connections if connection.msgtype not in _TYPES]


def _check_room(folder: Path, names: object) -> None:
    """Raise LogError where the packed files ``names`` of a bag may become more than there is room for."""
    total = 0
    free = max(0, shutil.disk_usage(tempfile.gettempdir()).free - _LEFT_FREE)
    for name in names if isinstance(names, list) else ():
        path = folder / PurePath(str(name)).name
        total += _unpacked_file(path, free)
        if total > free:
            raise LogError(
                f"{path}: may unpack to {amount(total)}; {tempfile.gettempdir()} has room for {amount(free)}"
            )


def _unpacked_file(path: Path, most: int) -> int:
    """A bound (bytes) of what the packed file unpacks to, or, over ``most``, of a part of it; 0 for damage."""
    with open_plain(path) as file:
        number = file.fileno()
        size = os.fstat(number).st_size
        try:
            return unpacked_size(lambda begin, end: os.pread(number, end - begin, begin), size, "zstd", most)
        except NO_FRAME:
            return 0  # rosbags will say so


def _unpacked_zstd(data: bytes) -> bytes:
    check_unpacked(within(data), len(data), "zstd", 0, MOST_UNPACKED)
    return zstd.decompress(data)


def _unpacked_lz4(data: bytes) -> bytes:
    check_unpacked(within(data), len(data), "lz4", 0, MOST_UNPACKED)
    return cast(bytes, lz4.frame.decompress(data))


def _unpacked_bz2(data: bytes) -> bytes:
    machine = bz2.BZ2Decompressor()
    unpacked = machine.decompress(data, max_length=MOST_UNPACKED + 1)
    if len(unpacked) > MOST_UNPACKED:
        raise TooMuch(f"unpacks to more than {amount(MOST_UNPACKED)}, the most that are unpacked")
    if not machine.eof:
        raise EOFError("a packed chunk of messages is cut off")
    return unpacked


_BOUNDED: Mapping[str, Callable[[bytes], bytes]] = {
    "none": lambda data: data,
    "bz2": _unpacked_bz2,
    "lz4": _unpacked_lz4,
}
