"""How pressed this computer is, from what Linux says of it; each figure is NaN where it cannot be read.

Blocking (well under a millisecond for some forty threads): for a thread.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

_TICKS: Final = 100.0
"""Of /proc/stat in a second (USER_HZ, the same on every architecture that matters here)."""


@dataclass(frozen=True, slots=True)
class ComputerPressure:
    """Over one window: ``waiting``, the share of the wanted time in which this process's threads had no core; ``room``,
    idle time of the cores it may use, % of one core; ``stalled``, the share of the time in which some task of the
    computer had none (PSI); ``runnable``, tasks that could run at its end, over those cores."""

    waiting: float
    room: float
    stalled: float
    runnable: float


@dataclass(frozen=True, slots=True)
class _Counts:
    wall: float
    threads: Mapping[str, tuple[int, int]] | None
    idle: int | None
    stalled_us: int | None


class PressureMeter:
    """Turns Linux's counters into :class:`ComputerPressure`; ``proc`` is where they are."""

    def __init__(self, proc: Path = Path("/proc")) -> None:
        self._proc = proc
        self._before = self._read()

    def sample(self) -> ComputerPressure:
        """Close the window: what was since the last call, or since the start."""
        before, now = self._before, self._read()
        self._before = now
        elapsed = max(1e-6, now.wall - before.wall)
        stalled = _less(now.stalled_us, before.stalled_us) / (1e6 * elapsed)
        room = 100.0 * _less(now.idle, before.idle) / (_TICKS * elapsed)
        return ComputerPressure(
            waiting=_waiting(before.threads, now.threads),
            room=room,
            stalled=min(stalled, 1.0) if not math.isnan(stalled) else stalled,
            runnable=self._runnable(),
        )

    def _read(self) -> _Counts:
        return _Counts(time.monotonic(), self._threads(), self._idle(), self._stalled())

    def _threads(self) -> dict[str, tuple[int, int]] | None:
        """By thread: ns it ran, ns it waited for a core; None where Linux was built without."""
        try:
            threads = os.listdir(self._proc / "self/task")
        except OSError:
            return None
        found = {}
        for thread in threads:
            fields = _text(self._proc / "self/task" / thread / "schedstat").split()
            if len(fields) >= 2:
                found[thread] = int(fields[0]), int(fields[1])
        return found or None

    def _idle(self) -> int | None:
        """Ticks in which the cores that this process may use had nothing to do."""
        cores = {f"cpu{core}" for core in _cores()}
        rows = [line.split() for line in _text(self._proc / "stat").splitlines() if line.startswith("cpu")]
        idle = [int(row[4]) for row in rows if row[0] in cores and len(row) > 4]
        return sum(idle) if idle else None

    def _stalled(self) -> int | None:
        """µs in which some task had no core."""
        for line in _text(self._proc / "pressure/cpu").splitlines():
            if line.startswith("some ") and (total := line.rpartition("total=")[2]).isdigit():
                return int(total)
        return None

    def _runnable(self) -> float:
        fields = _text(self._proc / "loadavg").split()
        tasks = fields[3].partition("/")[0] if len(fields) > 3 else ""
        return int(tasks) / max(1, len(_cores())) if tasks.isdigit() else math.nan


def _cores() -> Collection[int]:
    return os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else range(os.cpu_count() or 1)


def _waiting(before: Mapping[str, tuple[int, int]] | None, now: Mapping[str, tuple[int, int]] | None) -> float:
    """Of the threads that there were all the time."""
    if before is None or now is None:
        return math.nan
    both = before.keys() & now.keys()
    ran = sum(now[thread][0] - before[thread][0] for thread in both)
    waited = sum(now[thread][1] - before[thread][1] for thread in both)
    return waited / (ran + waited) if ran + waited > 0 else math.nan


def _less(now: int | None, before: int | None) -> float:
    return math.nan if now is None or before is None else float(now - before)


def _text(path: Path) -> str:
    """The text of a file of Linux; empty where there is none, or none any more."""
    try:
        return path.read_text()
    except OSError:
        return ""
