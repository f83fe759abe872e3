"""Log of the guard for tests and diagnosis: one row per decision.

Writing to a busy disk can block for a second, so a thread writes: the guard only queues rows.
"""

from __future__ import annotations

import queue
import struct
import threading
from dataclasses import dataclass
from pathlib import Path

_HEADER = struct.Struct("<I")


@dataclass(frozen=True, slots=True)
class GuardRow:
    """Velocity of the wheels and set-points (rad) of the joints from ``monotonic_s`` on; NaN: the joint yields."""

    monotonic_s: float
    linear_mps: float
    angular_radps: float
    setpoints: tuple[float, ...] = ()
    lateral_mps: float = 0.0


class GuardLog:
    """Appends rows with the set-points of ``joints`` joints to a file, unbuffered; :meth:`write` never waits."""

    def __init__(self, path: Path, joints: int = 0) -> None:
        self._file = path.open("wb", buffering=0)
        self._file.write(_HEADER.pack(joints))
        self._row = _row(joints)
        self._rows: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="guard log", daemon=True)
        self._thread.start()

    def write(self, row: GuardRow) -> None:
        velocity = (row.linear_mps, row.angular_radps, row.lateral_mps)
        self._rows.put(self._row.pack(row.monotonic_s, *velocity, *row.setpoints))

    def close(self, timeout_s: float = 0.3) -> None:
        """Write the queued rows, for at most ``timeout_s``."""
        self._rows.put(None)
        self._thread.join(timeout_s)

    def _run(self) -> None:
        with self._file:
            while (row := self._rows.get()) is not None:
                self._file.write(row)


class GuardLogReader:
    """Reads a log that is still being written, each time only what is new; one started again, from its start."""

    def __init__(self, path: Path) -> None:
        self._path = path
        #: The header and the first row: another log at this path has others.
        self._begin = b""
        self._read = 0
        self._rows: list[GuardRow] = []

    def rows(self) -> list[GuardRow]:
        """All whole rows so far, in a list of the caller's own. Raises OSError."""
        with self._path.open("rb") as file:
            header = file.read(_HEADER.size)
            if len(header) < _HEADER.size:
                return []
            row = _row(*_HEADER.unpack(header))
            begin = header + file.read(row.size)
            if begin != self._begin or not self._read:
                self._begin, self._read, self._rows = begin, _HEADER.size, []
            file.seek(self._read)
            data = file.read()
        whole = len(data) - len(data) % row.size
        self._read += whole
        self._rows += [
            GuardRow(when, linear, angular, tuple(setpoints), lateral)
            for when, linear, angular, lateral, *setpoints in row.iter_unpack(data[:whole])
        ]
        return list(self._rows)


def read_guard_log(path: Path) -> list[GuardRow]:
    """All whole rows of the log at ``path``. Raises OSError."""
    return GuardLogReader(path).rows()


def _row(joints: int) -> struct.Struct:
    return struct.Struct(f"<{4 + joints}d")
