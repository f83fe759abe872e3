"""The guard's own record, for tests and for finding out afterwards: one row per decision, straight to the file."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

_ROW = struct.Struct("<ddd")


@dataclass(frozen=True, slots=True)
class GuardRow:
    """At ``monotonic_s`` the wheels were given this velocity."""

    monotonic_s: float
    linear_mps: float
    angular_radps: float


class GuardLog:
    """Appends rows to a file, unbuffered: what is written stays though the process be killed."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb", buffering=0)

    def write(self, monotonic_s: float, linear_mps: float, angular_radps: float) -> None:
        """Append one row."""
        self._file.write(_ROW.pack(monotonic_s, linear_mps, angular_radps))

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def read_guard_log(path: Path) -> list[GuardRow]:
    """Every whole row of the file, in order."""
    data = path.read_bytes()
    whole = len(data) - len(data) % _ROW.size
    return [GuardRow(*row) for row in _ROW.iter_unpack(data[:whole])]
