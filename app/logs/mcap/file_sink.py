"""A recording into one file of the library."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

from app.logs.manifest import Manifest
from app.logs.mcap.open_file import McapFile, OpenFile, create
from app.logs.ros.encoder import Encoder


class FileSink:
    """A recording in one file, created under the first free name."""

    def __init__(
        self, paths: Iterable[Path], encoder: Encoder, manifest: Manifest, at: float, open_file: OpenFile = create
    ) -> None:
        """Take the first of ``paths`` that does not exist yet; its folder is made. Raises OSError."""
        self._file = _first_free(paths, lambda path: McapFile(path, encoder, manifest, at, open_file=open_file))
        self.folder = self._file.path.parent
        self.begin = at

    @property
    def name(self) -> str:
        return self._file.path.stem

    @property
    def bytes(self) -> int:
        return self._file.bytes

    @property
    def messages(self) -> int:
        return self._file.messages

    def write(self, at: float, channel: str, message: Any) -> None:
        self._file.write(at, channel, message)

    def flush(self) -> None:
        """End the chunk. Raises OSError, also if the file was deleted meanwhile: it could never be read."""
        self._file.flush()
        if not self._file.path.exists():
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(self._file.path))

    def close(self, discard: bool) -> None:
        """Close the file; of a single file nothing is deleted but an empty one. Raises OSError."""
        self._file.close()
        self._forget_if_empty()

    def abandon(self) -> None:
        self._file.abandon()
        with suppress(OSError):
            self._forget_if_empty()

    def _forget_if_empty(self) -> None:
        if not self.messages:
            self._file.path.unlink(missing_ok=True)


def _first_free(paths: Iterable[Path], make: Callable[[Path], McapFile]) -> McapFile:
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            return make(path)
        except FileExistsError:
            continue
    raise FileExistsError(errno.EEXIST, "every name is taken")
