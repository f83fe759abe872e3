"""CPU time, charged to the module that spends it.

The event loop's thread is shared, so each module's tasks run inside :class:`MeteredCoroutine`, which reads the
thread's CPU clock around every step; work in threads is measured around the call. Figures are per cent of one core
over windows of one second.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Coroutine, Generator
from dataclasses import dataclass
from typing import Any, TypeVar

T = TypeVar("T")


class CpuMeter:
    """Accumulates the CPU time charged to one module; the sum never decreases.

    ``stepping``, readable from any thread: whether the event loop is inside a step of this module.
    """

    __slots__ = ("_lock", "_loop_ns", "_threads_ns", "stepping")

    def __init__(self) -> None:
        self.stepping = False
        # `+=` is not atomic: the loop and the threads each have a figure of their own.
        self._loop_ns = 0
        self._threads_ns = 0
        self._lock = threading.Lock()

    @property
    def cpu_ns(self) -> int:
        """CPU time (ns) spent so far: on the event loop and, once they ended, in calls in threads."""
        return self._loop_ns + self._threads_ns

    def step(self, advance: Callable[..., T], *args: Any) -> T:
        """Call ``advance(*args)``, a step on the event loop, and charge its thread CPU time."""
        begin = time.thread_time_ns()
        self.stepping = True
        try:
            return advance(*args)
        finally:
            self.stepping = False
            self._loop_ns += time.thread_time_ns() - begin

    def call(self, function: Callable[..., T], *args: Any) -> T:
        """Call ``function(*args)`` in a thread other than the event loop's and charge its thread CPU time."""
        begin = time.thread_time_ns()
        try:
            return function(*args)
        finally:
            spent = time.thread_time_ns() - begin
            with self._lock:
                self._threads_ns += spent


class MeteredCoroutine(Coroutine[Any, Any, T]):
    """A coroutine that charges the CPU time of each of its steps to a meter; awaitable, and usable as a task."""

    __slots__ = ("_coroutine", "_meter")

    def __init__(self, coroutine: Coroutine[Any, Any, T], meter: CpuMeter) -> None:
        self._coroutine = coroutine
        self._meter = meter

    def send(self, value: Any) -> Any:
        return self._meter.step(self._coroutine.send, value)

    def throw(self, *args: Any) -> Any:
        return self._meter.step(self._coroutine.throw, *args)

    def close(self) -> None:
        self._coroutine.close()

    def __await__(self) -> Generator[Any, Any, T]:
        return (yield from self._coroutine.__await__())


@dataclass(frozen=True, slots=True)
class CpuLoad:
    """CPU use over the last window: per cent of one core, by module and of the whole process."""

    stamp: float
    window_s: float
    modules: dict[str, float]
    process: float


class LoadMeter:
    """Turns the modules' meters into :class:`CpuLoad` figures; call :meth:`sample` once per window."""

    def __init__(self, meters: dict[str, CpuMeter], now: Callable[[], float]) -> None:
        self._meters = meters
        self._now = now
        self._before = {name: meter.cpu_ns for name, meter in meters.items()}
        self._process_before = time.process_time_ns()
        self._wall_before = time.monotonic_ns()
        self.latest = CpuLoad(now(), 0.0, dict.fromkeys(meters, 0.0), 0.0)

    def sample(self) -> CpuLoad:
        """Close the window: the load since the last call, also kept in :attr:`latest`."""
        wall = time.monotonic_ns()
        elapsed = max(1, wall - self._wall_before)
        process = time.process_time_ns()
        counts = {name: meter.cpu_ns for name, meter in self._meters.items()}
        self.latest = CpuLoad(
            stamp=self._now(),
            window_s=elapsed / 1e9,
            modules={n: 100.0 * (c - self._before.get(n, 0)) / elapsed for n, c in counts.items()},
            process=100.0 * (process - self._process_before) / elapsed,
        )
        self._before, self._process_before, self._wall_before = counts, process, wall
        return self.latest
