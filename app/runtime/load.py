"""CPU time, charged to the module that spends it.

The event loop's thread is shared, so each module's tasks run inside :class:`MeteredCoroutine`, which reads the
thread's CPU clock around every step; work in threads is measured around the call. Figures are per cent of one core
over windows of one second.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Coroutine, Generator
from dataclasses import dataclass
from typing import Any, TypeVar

T = TypeVar("T")


class CpuMeter:
    """Accumulates the CPU time (ns) charged to one module; only ever grows."""

    __slots__ = ("cpu_ns",)

    def __init__(self) -> None:
        self.cpu_ns = 0

    def call(self, function: Callable[..., T], *args: Any) -> T:
        """Call ``function(*args)`` in this thread and charge its thread CPU time."""
        begin = time.thread_time_ns()
        try:
            return function(*args)
        finally:
            self.cpu_ns += time.thread_time_ns() - begin


class MeteredCoroutine(Coroutine[Any, Any, T]):
    """A coroutine that charges the CPU time of each of its steps to a meter; awaitable, and usable as a task."""

    __slots__ = ("_coroutine", "_meter")

    def __init__(self, coroutine: Coroutine[Any, Any, T], meter: CpuMeter) -> None:
        self._coroutine = coroutine
        self._meter = meter

    def send(self, value: Any) -> Any:
        """One step."""
        begin = time.thread_time_ns()
        try:
            return self._coroutine.send(value)
        finally:
            self._meter.cpu_ns += time.thread_time_ns() - begin

    def throw(self, *args: Any) -> Any:
        """One step, entered by an exception."""
        begin = time.thread_time_ns()
        try:
            return self._coroutine.throw(*args)
        finally:
            self._meter.cpu_ns += time.thread_time_ns() - begin

    def close(self) -> None:
        """End it without another step."""
        self._coroutine.close()

    def __await__(self) -> Generator[Any, Any, T]:
        return (yield from self._coroutine.__await__())


@dataclass(frozen=True, slots=True)
class Load:
    """CPU use over the last window: per cent of one core, by module and of the whole process."""

    stamp: float
    window_s: float
    modules: dict[str, float]
    process: float


class LoadMeter:
    """Turns the modules' meters into :class:`Load` figures; call :meth:`sample` once per window."""

    def __init__(self, meters: dict[str, CpuMeter], now: Callable[[], float]) -> None:
        self._meters = meters
        self._now = now
        self._before = {name: meter.cpu_ns for name, meter in meters.items()}
        self._process_before = time.process_time_ns()
        self._wall_before = time.monotonic_ns()
        self.latest = Load(now(), 0.0, dict.fromkeys(meters, 0.0), 0.0)

    def sample(self) -> Load:
        """Close the window: the load since the last call, also kept in :attr:`latest`."""
        wall = time.monotonic_ns()
        elapsed = max(1, wall - self._wall_before)
        process = time.process_time_ns()
        counts = {name: meter.cpu_ns for name, meter in self._meters.items()}
        self.latest = Load(
            stamp=self._now(),
            window_s=elapsed / 1e9,
            modules={n: 100.0 * (c - self._before.get(n, 0)) / elapsed for n, c in counts.items()},
            process=100.0 * (process - self._process_before) / elapsed,
        )
        self._before, self._process_before, self._wall_before = counts, process, wall
        return self.latest
