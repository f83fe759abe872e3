"""Pictures and videos of tours, beside the tours: found, listed, kept wholly or not at all, deleted."""

from __future__ import annotations

import contextlib
import filecmp
import os
import re
import shutil
import stat
import tempfile
import threading
import time
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from app.tours.media_content import Kind, checked, kind_of_name

#: Files that are handed in are kept in this folder in that of tours.
FOLDER = "media"
#: More are not kept, nor listed.
MOST_FILES = 1000
#: So much of the disk is left free.
LEFT_FREE_BYTES = 1024**3

_LONGEST_STEM = 60
#: Beginning of the names of files that are not whole yet; none of a tour's begins so.
_PARTIAL = ".partial-"
#: A partial file that was not written for so long (s) is of a program that was killed.
_ABANDONED_S = 3600.0


class MediaError(Exception):
    """It cannot be done; the message is one sentence."""


class UnknownMedia(MediaError):
    """There is no such file."""


class ShippedMedia(MediaError):
    """A file that comes with the program is not deleted."""


class NoRoom(MediaError):
    """There are as many files as are kept, or the disk is full."""


@dataclass(frozen=True, slots=True)
class MediaFile:
    """A picture or a video: ``file`` as tours name it; ``changed``: Unix time, s; ``shipped``: it came with the
    program."""

    file: str
    kind: Kind
    size: int
    changed: float
    shipped: bool


class MediaLibrary:
    """Media in ``folders``, the user's first; others are the program's. All methods touch the disk, and raise OSError;
    any thread may call them."""

    def __init__(self, folders: Sequence[Path]) -> None:
        self.folders = tuple(folders)
        self._lock = threading.Lock()

    def find(self, file: str) -> tuple[Path, os.stat_result]:
        """The file that tours call ``file``, and its status.

        Raises UnknownMedia where there is none, where it is no plain file within its folder (a link may lead out of
        it) and for a name that is not shown.
        """
        for folder in self.folders if kind_of_name(file) is not None else ():
            try:
                root, path = folder.resolve(strict=True), (folder / file).resolve(strict=True)
                status = path.stat()
            except (OSError, RuntimeError, ValueError):
                continue  # it is not there, links go round, or it is no name
            if path.is_relative_to(root) and stat.S_ISREG(status.st_mode):
                return path, status
            break
        raise UnknownMedia("there is no such picture or video")

    def listing(self) -> tuple[MediaFile, ...]:
        """All files, by name; a file of the user's hides the program's of the same name."""
        found: dict[str, MediaFile] = {}
        for number, folder in enumerate(self.folders):
            for path in _files_in(folder):
                file = path.relative_to(folder).as_posix()
                if file in found or len(found) >= MOST_FILES:
                    continue
                with contextlib.suppress(UnknownMedia):
                    found[file] = self._described(file, shipped=number > 0)
        return tuple(found[file] for file in sorted(found))

    @contextlib.contextmanager
    def partial(self, size: int) -> Iterator[Path]:
        """An empty file to be written, of about ``size`` bytes, which is gone afterwards unless it was kept.

        Raises NoRoom.
        """
        folder = self.folders[0] / FOLDER
        folder.mkdir(parents=True, exist_ok=True)
        _sweep(folder)
        if shutil.disk_usage(folder).free - size < LEFT_FREE_BYTES:
            raise NoRoom("the disk has no room for it")
        number, name = tempfile.mkstemp(prefix=_PARTIAL, dir=folder)
        os.close(number)
        path = Path(name)
        try:
            yield path
        finally:
            path.unlink(missing_ok=True)

    def keep(self, partial: Path, name: str) -> tuple[MediaFile, bool]:
        """Keep what was written to ``partial`` under a name like ``name``, and whether it is new.

        A file of the same content and name is taken instead; where the name is another's, a number is added. Raises
        NotShown, and NoRoom.
        """
        kind = checked(partial)
        with partial.open("rb") as written:
            os.fsync(written.fileno())
        partial.chmod(0o644)
        with self._lock:
            folder = partial.parent
            if sum(1 for _ in _files_in(self.folders[0])) >= MOST_FILES:
                raise NoRoom(f"there are {MOST_FILES} pictures and videos, the most that are kept; delete some first")
            for candidate in _names(name, kind):
                file = f"{FOLDER}/{candidate}"
                taken = next((each / file for each in self.folders if os.path.lexists(each / file)), None)
                if taken is None:
                    partial.rename(folder / candidate)
                    return self._described(file, shipped=False), True
                if taken.is_file() and filecmp.cmp(taken, partial, shallow=False):
                    return self._described(file, shipped=not taken.is_relative_to(self.folders[0])), False
        raise AssertionError("names do not end")

    def delete(self, file: str) -> None:
        """Delete the user's file ``file``. Raises UnknownMedia, and ShippedMedia for one of the program's."""
        with self._lock:
            path, _ = self.find(file)
            if not path.is_relative_to(self.folders[0].resolve()):
                raise ShippedMedia(f"{file} came with the program and is not deleted")
            path.unlink()

    def _described(self, file: str, *, shipped: bool) -> MediaFile:
        _, status = self.find(file)
        kind = kind_of_name(file)
        assert kind is not None
        return MediaFile(file, kind, status.st_size, status.st_mtime, shipped)


def _files_in(folder: Path) -> Iterator[Path]:
    """Plain files in ``folder``, with the ending of a picture or a video; nothing that is hidden."""
    for root, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(files):
            if not name.startswith(".") and kind_of_name(name) is not None:
                yield Path(root, name)


def _sweep(folder: Path) -> None:
    for path in folder.glob(f"{_PARTIAL}*"):
        with contextlib.suppress(FileNotFoundError):
            if time.time() - path.stat().st_mtime > _ABANDONED_S:
                path.unlink()


def _names(name: str, kind: Kind) -> Iterator[str]:
    """Names of files that say ``name``, one after the other: ``arm.jpg``, ``arm-2.jpg``."""
    plain = unicodedata.normalize("NFKD", name.rpartition("/")[2].rpartition("\\")[2])
    plain = plain.encode("ascii", "ignore").decode()
    stem, dot, suffix = plain.rpartition(".")
    named = kind_of_name(plain)
    if not dot or named is None:
        stem, suffix = plain, ""
    # A picture that is called jpeg stays so; what is called otherwise than it is, is not.
    ending = suffix.lower() if named is not None and named.type == kind.type else kind.suffix
    stem = re.sub(r"[^A-Za-z0-9_]+", "-", stem).strip("-")[:_LONGEST_STEM] or ("video" if kind.is_video else "picture")
    yield f"{stem}.{ending}"
    for number in range(2, MOST_FILES + 2):
        yield f"{stem}-{number}.{ending}"
