"""A tour with its pictures and videos as one file: a ZIP archive of ``ID.yaml`` and the media, named as the tour does.

What is read may be of unknown origin: sizes are counted as they come, whatever the archive says of them, and nothing is
written by a name of its own.
"""

from __future__ import annotations

import contextlib
import filecmp
import io
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

from app.base.errors import ConfigError
from app.tours.checks import media_of
from app.tours.consistency import tour_of
from app.tours.media import MediaLibrary, UnknownMedia
from app.tours.media_content import NotShown, kind_of_name
from app.tours.model import Tour
from app.tours.tour_file import MOST_BYTES, read_tour, tour_text

T = TypeVar("T")
#: An archive has no more bytes, packed and unpacked.
LARGEST_BYTES = 2 * 1024**3
#: How it begins.
SIGNATURE = b"PK\x03\x04"

_MOST_ENTRIES = 2000
_PIECE = 1024**2


class BadArchive(ValueError):
    """It is no archive of a tour; the message is one sentence."""


def packed(tour: Tour, media: MediaLibrary) -> Iterator[bytes]:
    """The archive of ``tour``, piece by piece; media that are not there are left out. Blocking. Raises OSError."""
    pieces = _Pieces()
    with zipfile.ZipFile(pieces, "w") as archive:
        archive.writestr(f"{tour.id}.yaml", tour_text(tour), zipfile.ZIP_DEFLATED)
        for file in dict.fromkeys(file for _, file in media_of(tour)):
            try:
                path, _ = media.find(file)
            except UnknownMedia:
                continue
            # Pictures and videos are packed already.
            with (
                path.open("rb") as source,
                archive.open(zipfile.ZipInfo.from_file(path, file, strict_timestamps=False), "w") as target,
            ):
                while piece := source.read(_PIECE):
                    target.write(piece)
                    yield pieces.taken()
    yield pieces.taken()


def unpacked(path: Path, media: MediaLibrary, use: Callable[[Tour], T]) -> T:
    """What ``use`` makes of the tour in the archive ``path``, whose media are kept in ``media`` then; of what it names
    alone, and none where anything is refused, by ``use`` too.

    Where a name is taken by another picture, the tour names the new one. Blocking. Raises BadArchive, ConfigError for
    the tour's file, NoRoom and OSError.
    """
    try:
        with zipfile.ZipFile(path) as archive, ExitStack() as stack:
            tour, entries = _contents(archive)
            kept: list[str] = []
            with _taken_back(media, kept):
                names: dict[str, str] = {}
                total = 0
                for file in dict.fromkeys(file for _, file in media_of(tour) if file in entries):
                    partial = stack.enter_context(media.partial(entries[file].file_size))
                    total += _unpack(archive, entries[file], partial, LARGEST_BYTES - total)
                    names[file] = _keep(media, file, partial, kept)
                return use(_with_names(tour, names))
    except (zipfile.BadZipFile, zlib.error, EOFError) as damage:
        raise BadArchive(f"the archive is damaged: {damage}") from None


def _contents(archive: zipfile.ZipFile) -> tuple[Tour, Mapping[str, zipfile.ZipInfo]]:
    """The tour, and the files beside it by their names."""
    entries = [each for each in archive.infolist() if not each.is_dir() and not each.filename.startswith("__MACOSX/")]
    if len(entries) > _MOST_ENTRIES:
        raise BadArchive(f"the archive has {len(entries)} files; at most {_MOST_ENTRIES} are read")
    for entry in entries:
        if entry.flag_bits & 1 or entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise BadArchive(f"{entry.filename} is encrypted or packed in a manner that is not read: pack it as ZIP")
    files = [each for each in entries if each.filename.endswith((".yaml", ".yml", ".json"))]
    if len(files) != 1:
        found = ", ".join(each.filename for each in files[:5]) or "none"
        raise BadArchive(f"the archive must have one file of a tour (.yaml) and its media, not {found}")
    (file,) = files
    with archive.open(file) as source:
        content = source.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise BadArchive(f"{file.filename} has more than {MOST_BYTES // 1000} kB, the most that is read")
    try:
        tour, _ = read_tour(content.decode("utf-8"), file.filename)
    except UnicodeDecodeError:
        raise ConfigError("is not a text file in UTF-8", file.filename) from None
    root = PurePosixPath(file.filename).parent
    paths = ((PurePosixPath(each.filename), each) for each in entries)
    return tour, {path.relative_to(root).as_posix(): each for path, each in paths if path.is_relative_to(root)}


def _unpack(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, target: Path, most: int) -> int:
    """Its size (bytes)."""
    kind = kind_of_name(entry.filename)
    size = 0
    with archive.open(entry) as source, target.open("wb") as out:
        while piece := source.read(_PIECE):
            size += len(piece)
            if size > most:
                raise BadArchive(f"the archive's media have more than the {LARGEST_BYTES // 1024**2} MB that are read")
            try:
                if kind is not None:
                    kind.check_size(size)
            except NotShown as refusal:
                raise BadArchive(f"{entry.filename} {refusal}") from None
            out.write(piece)
    return size


def _keep(media: MediaLibrary, file: str, partial: Path, kept: list[str]) -> str:
    """The name under which the media has what ``partial`` has, a new one being noted in ``kept``."""
    try:
        with contextlib.suppress(UnknownMedia):
            if filecmp.cmp(media.find(file)[0], partial, shallow=False):
                return file
        found, is_new = media.keep(partial, PurePosixPath(file).name)
    except NotShown as refusal:
        raise BadArchive(f"{file} {refusal}") from None
    if is_new:
        kept.append(found.file)
    return found.file


@contextlib.contextmanager
def _taken_back(media: MediaLibrary, kept: list[str]) -> Iterator[None]:
    """Deletes the files ``kept`` where anything fails."""
    try:
        yield
    except BaseException:
        for file in kept:
            with contextlib.suppress(UnknownMedia):
                media.delete(file)
        raise


def _with_names(tour: Tour, names: Mapping[str, str]) -> Tour:
    """``tour`` with other names of its media."""

    def renamed(value: Any) -> Any:
        match value:
            case {"file": str(file), "alt": _}:
                return {**value, "file": names.get(file, file)}
            case dict():
                return {key: renamed(each) for key, each in value.items()}
            case list():
                return [renamed(each) for each in value]
        return value

    return tour_of(renamed(tour.model_dump(mode="json", by_alias=True)))


class _Pieces(io.RawIOBase):
    """What was written and not taken yet; it is written from its beginning to its end."""

    def __init__(self) -> None:
        super().__init__()
        self._waiting = bytearray()

    def writable(self) -> bool:
        return True

    def write(self, data: Any) -> int:
        self._waiting += data
        return len(data)

    def taken(self) -> bytes:
        """All that was written since the last call."""
        content = bytes(self._waiting)
        self._waiting.clear()
        return content
