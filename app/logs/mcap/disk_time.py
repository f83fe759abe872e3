"""Time that writing waits for the disk; the rest of a delay is caused by the computer's load."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.logs.mcap.open_file import OpenFile, RawFile


class DiskTime:
    """Adds up the time that one thread spends in calls of the files that :meth:`timed` opens; others may read it."""

    def __init__(self) -> None:
        self._before_s = 0.0
        self._since: float | None = None

    @property
    def waited_s(self) -> float:
        """Seconds spent in calls until now, the one in progress included."""
        since = self._since
        return self._before_s + (0.0 if since is None else time.monotonic() - since)

    def timed(self, open_file: OpenFile) -> OpenFile:
        """``open_file``, its own time and that of its files added up here."""

        def open_timed(path: Path) -> RawFile:
            with self._adding():
                return _TimedFile(open_file(path), self)

        return open_timed

    @contextmanager
    def _adding(self) -> Iterator[None]:
        begin = self._since = time.monotonic()
        try:
            yield
        finally:
            self._before_s += time.monotonic() - begin
            self._since = None


class _TimedFile:
    def __init__(self, file: RawFile, time_: DiskTime) -> None:
        self._file = file
        self._time = time_

    def write(self, data: memoryview, /) -> int | None:
        with self._time._adding():
            return self._file.write(data)

    def truncate(self, size: int, /) -> int:
        with self._time._adding():
            return self._file.truncate(size)

    def close(self) -> None:
        with self._time._adding():
            self._file.close()
