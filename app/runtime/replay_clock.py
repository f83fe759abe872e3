"""The clock of a recording that is played on a real event loop: it runs at any speed, pauses and jumps.

Modules use it as any other clock. :class:`VirtualClock` serves headless replays: with this one, the console goes on in
real time while the recording is paused.
"""

from __future__ import annotations

import asyncio
import heapq
import math
import time
from collections.abc import Callable
from itertools import count
from typing import NamedTuple

from app.runtime.clock import RealClock

#: A heap with fewer sleepers that gave up than this is not worth tidying.
_FEW = 64
#: Least delay (s) of the next check after a timer of the loop that came early by its resolution.
_SHORTEST_WAIT_S = 1e-4


class _ClockRun(NamedTuple):
    """The reading was ``base`` at the real moment ``mark`` and has grown by ``rate`` s a second since."""

    base: float
    mark: float
    rate: float


class ReplayClock:
    """Paused at ``start`` (s) until :meth:`run`; its reading is at most ``end``.

    ``real`` gives real seconds. The reading never decreases except by :meth:`jump`. Sleepers that are due are woken in
    the order of their stamps, then of their calls. Sleeping takes O(log n).
    """

    def __init__(self, start: float, end: float = math.inf, *, real: Callable[[], float] = time.monotonic) -> None:
        self._real = real
        #: It never reads more than this (s).
        self.end = end
        # Replaced as a whole: read in other threads too.
        self._state = _ClockRun(start, real(), 0.0)
        self._sleepers: list[tuple[float, int, asyncio.Future[None]]] = []
        self._order = count()
        self._given_up = 0
        self._timer: asyncio.TimerHandle | None = None
        #: Real time, for work that goes on while the recording is paused.
        self.pace = RealClock()

    # --- As modules see it -------------------------------------------------------------------------------------------

    def now(self) -> float:
        """Seconds of the recording (Unix epoch). May be read in any thread."""
        base, mark, rate = self._state
        return min(base + (self._real() - mark) * rate, self.end) if rate else base

    async def sleep(self, seconds: float) -> None:
        """Let ``seconds`` of the recording pass; zero or less yields to other tasks once."""
        await self.sleep_until(self.now() + seconds) if seconds > 0 else await asyncio.sleep(0)

    async def sleep_until(self, stamp: float) -> None:
        """Wait until ``now() >= stamp``, or until the next jump to any time: read the clock afterwards."""
        if stamp <= self.now():
            await asyncio.sleep(0)
            return
        woken = asyncio.get_running_loop().create_future()
        heapq.heappush(self._sleepers, (stamp, next(self._order), woken))
        if self._sleepers[0][2] is woken:
            self._set_timer()
        try:
            await woken
        except asyncio.CancelledError:
            self._given_up += 1
            self._tidy()
            raise

    # --- As playback moves it ----------------------------------------------------------------------------------------

    @property
    def rate(self) -> float:
        """Seconds of the recording in a real second; 0 while it is paused."""
        return self._state.rate

    @property
    def next_due(self) -> float | None:
        """The stamp that the first sleeper waits for; None without a sleeper."""
        while self._sleepers and self._sleepers[0][2].done():
            heapq.heappop(self._sleepers)
            self._given_up = max(0, self._given_up - 1)
        return self._sleepers[0][0] if self._sleepers else None

    def run(self, rate: float) -> None:
        """Run at ``rate`` times real time; 0: pause. Raises ValueError for a rate below 0 or infinite."""
        if not 0 <= rate < math.inf:
            raise ValueError(f"a recording's time runs at a finite rate from 0, not {rate!r}")
        now = self.now()
        self._state = _ClockRun(now, self._real(), rate)
        self._wake()

    def jump(self, stamp: float) -> None:
        """Read ``stamp`` from now on, be it earlier or later, at the same rate, and release every sleeper."""
        self._state = _ClockRun(min(stamp, self.end), self._real(), self.rate)
        sleepers, self._sleepers, self._given_up = sorted(self._sleepers), [], 0
        for _, _, woken in sleepers:
            _resolve(woken)
        self._set_timer()

    def advance_to(self, stamp: float) -> None:
        """Advance to ``stamp`` and wake the sleepers that are due; an earlier stamp changes nothing."""
        now = self.now()
        self._state = _ClockRun(min(max(stamp, now), max(self.end, now)), self._real(), self.rate)
        self._wake()

    # --- Inside ------------------------------------------------------------------------------------------------------

    def _wake(self) -> None:
        now = self.now()
        while (due := self.next_due) is not None and due <= now:
            _resolve(heapq.heappop(self._sleepers)[2])
        self._set_timer()

    def _set_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        due, rate = self.next_due, self.rate
        if due is not None and rate > 0 and due <= self.end:
            wait_s = max((due - self.now()) / rate, _SHORTEST_WAIT_S)
            self._timer = asyncio.get_running_loop().call_later(wait_s, self._wake)

    def _tidy(self) -> None:
        """Drop sleepers that were cancelled once they are the greater part."""
        if self._given_up > _FEW and 2 * self._given_up > len(self._sleepers):
            self._sleepers = [sleeper for sleeper in self._sleepers if not sleeper[2].done()]
            heapq.heapify(self._sleepers)
            self._given_up = 0


def _resolve(woken: asyncio.Future[None]) -> None:
    if not woken.done():
        woken.set_result(None)
