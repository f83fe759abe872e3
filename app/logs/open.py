"""Opens any log that the program can read, recognised by its content: our recordings, ROS bags, CARMEN laser logs."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Sequence
from pathlib import Path

from app.base.plain_file import open_plain
from app.logs.importers.remap import Remap, RemapError
from app.logs.layout import CHANNEL, FACTS, NAME
from app.logs.log import Log, LogError
from app.logs.mcap.open_file import is_being_written
from app.logs.mcap.structure import DAMAGE, MAGIC, RECORD_HEAD, is_closed

_BAG = b"#ROSBAG V"
_SQLITE = b"SQLite format 3\x00"
_GZIP = b"\x1f\x8b"
#: Bytes of a file's head that suffice to recognise every format: the beginning of a CARMEN log is text.
_HEAD = 4096
_NAMED = 3

ACCEPTED = (
    "accepted are recordings of hbba (.mcap), ROS 1 bags (.bag), ROS 2 bags (a folder with metadata.yaml, or its .mcap "
    "or .db3 file) and CARMEN logs (.log, .clf, .gz)"
)


def open_log(path: Path, remap: Remap | None = None) -> Log:
    """The log at ``path``; ``remap`` says which topics of a ROS bag become which channels.

    Raises LogError for a file that cannot be read or is of no accepted format; RemapError, a LogError, if a bag's
    topics are ambiguous, or ``remap`` is given for a log whose channels have their names; ConfigError (file, line) if
    ``remap`` names something that the bag does not have.
    """
    if path.is_dir():
        if not (path / "metadata.yaml").is_file():
            raise LogError(f"{path}: is a folder without metadata.yaml, so no ROS 2 bag; {_instead(path)}{ACCEPTED}")
        return _ros(path, remap)
    head = _head(path)
    if head.startswith(MAGIC):
        return _mcap(path, head, remap)
    if head.startswith((_BAG, _SQLITE)):
        return _ros(path, remap)
    if head.startswith(_GZIP):
        head = _unpacked_head(path)
    from app.logs.importers.carmen import CarmenLog, is_carmen

    if is_carmen(head):
        if remap is not None:
            raise RemapError(f"{path}: is a CARMEN log, which has no topics to remap; leave the remap file away")
        return CarmenLog(path)
    raise LogError(f"{path}: is no log this program can read; {ACCEPTED}")


def _instead(folder: Path) -> str:
    """Of a ROS 2 bag whose recording was cut short, the file itself may be readable."""
    files = [file.name for file in sorted(folder.iterdir()) if file.suffix in (".mcap", ".db3")]
    return f"name one file in it instead: {some(files)}; " if files else ""


def some(names: Sequence[str]) -> str:
    """The first of ``names``, and how many there are besides."""
    more = [f"… and {len(names) - _NAMED} more"] if len(names) > _NAMED else []
    return ", ".join([*names[:_NAMED], *more])


def _head(path: Path) -> bytes:
    try:
        with open_plain(path) as file:
            head = file.read(_HEAD)
    except OSError as failure:
        raise LogError(f"{path}: cannot be read: {failure.strerror or failure}") from None
    if not head:
        raise LogError(f"{path}: is empty; {ACCEPTED}")
    return head


def _unpacked_head(path: Path) -> bytes:
    try:
        with gzip.open(path, "rb") as file:
            return file.read(_HEAD)
    except (OSError, EOFError, zlib.error) as failure:
        raise LogError(f"{path}: is damaged: {failure}") from None


def _ros(path: Path, remap: Remap | None) -> Log:
    from app.logs.importers.ros_bag import RosBag

    return RosBag(path, remap)


def _mcap(path: Path, head: bytes, remap: Remap | None) -> Log:
    with open_plain(path) as file:
        whole = is_closed(file)
    if not _is_ours(path, head, whole):
        if not whole:
            raise LogError(f"{path}: is an MCAP file without its end; hbba log repair {path} saves what is whole in it")
        return _ros(path, remap)
    if not whole:
        if is_being_written(path):
            raise LogError(f"{path}: is still being recorded; stop that first")
        raise LogError(
            f"{path}: was not closed, since its writer was stopped; make it whole with: hbba log repair {path}"
        )
    if remap is not None:
        raise RemapError(f"{path}: is a recording of hbba, whose channels have their names; leave the remap file away")
    from app.logs.mcap.reader import McapLog

    return McapLog(path)


def _is_ours(path: Path, head: bytes, whole: bool) -> bool:
    """Whether hbba wrote it: by the header's library, or, if another tool copied it, by its attachments."""
    at = len(MAGIC) + RECORD_HEAD.size
    for _ in range(2):  # profile, library
        length = int.from_bytes(head[at : at + 4], "little")
        text = head[at + 4 : at + 4 + length]
        at += 4 + length
    if text.startswith(NAME.encode()):
        return True
    if not whole:
        return False
    from app.logs.mcap.bounds import BoundedReader

    try:
        with open_plain(path) as file:
            summary = BoundedReader(file).get_summary()
    except (*DAMAGE, OSError):
        return False
    if summary is None:
        return False
    return any(index.name == FACTS for index in summary.metadata_indexes) and any(
        CHANNEL in channel.metadata for channel in summary.channels.values()
    )
