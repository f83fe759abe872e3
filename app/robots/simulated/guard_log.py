"""Log of the guard for tests and diagnosis: one row per decision.

Writing to a busy disk can block for a second, so a thread writes: the guard only queues rows.
"""

from __future__ import annotations

import queue
import struct
import threading
from dataclasses import dataclass
from pathlib import Path

_ROW = struct.Struct("<ddd")


@dataclass(frozen=True, slots=True)
class GuardRow:
    """Velocity of the wheels from ``monotonic_s`` on."""

    monotonic_s: float
    linear_mps: float
    angular_radps: float


class GuardLog:
    """Appends rows to a file, unbuffered; :meth:`write` never waits."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb", buffering=0)
        self._rows: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="guard log", daemon=True)
        self._thread.start()

    def write(self, monotonic_s: float, linear_mps: float, angular_radps: float) -> None:
        self._rows.put(_ROW.pack(monotonic_s, linear_mps, angular_radps))

    def close(self, timeout_s: float = 0.3) -> None:
        """Write the queued rows, for at most ``timeout_s``."""
        self._rows.put(None)
        self._thread.join(timeout_s)

    def _run(self) -> None:
        with self._file:
            while (row := self._rows.get()) is not None:
                self._file.write(row)


def read_guard_log(path: Path) -> list[GuardRow]:
    data = path.read_bytes()
    whole = len(data) - len(data) % _ROW.size
    return [GuardRow(*row) for row in _ROW.iter_unpack(data[:whole])]
