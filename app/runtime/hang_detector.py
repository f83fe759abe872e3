"""Whether a running module gets anywhere, judged in time that the event loop really gave it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from app.runtime.clock import Clock
from app.runtime.ports import Input

#: At most this much time counts between two checks. While one module blocks the loop, the others are not at fault.
LONGEST_STEP_S = 0.2
#: A periodic handler is hung after this many of its periods.
HUNG_PERIODS = 10


class LoopTime:
    """Time available to modules: the lesser of the times that both clocks passed.

    ``clock`` is the modules' clock, which in a recording may be paused or run faster than any computer; ``pace`` is
    real time there and the same clock elsewhere.
    """

    def __init__(self, clock: Clock, pace: Clock) -> None:
        self._clock = clock
        self._pace = pace
        self._read = (clock.now(), pace.now())
        self._given_s = 0.0

    def now(self) -> float:
        """Seconds, from any beginning; never decreasing."""
        if self._pace is self._clock:
            return self._clock.now()
        (clock, pace), self._read = self._read, (self._clock.now(), self._pace.now())
        self._given_s += max(0.0, min(self._read[0] - clock, self._read[1] - pace))
        return self._given_s


class HangDetector:
    """Watches one run of a module; call :meth:`look` about every 0.1 s.

    While none of :attr:`signs` is true there is nothing to see: it need not be called then.

    A module makes no progress when an input has messages waiting and none is taken for ``limit_s``, or when a
    periodic handler does not come round for ten of its periods (at least ``limit_s``).
    """

    def __init__(
        self, inputs: Collection[Input[Any]], ticks: Mapping[str, tuple[float, float]], limit_s: float, now: float
    ) -> None:
        self._inputs = inputs
        self._ticks = ticks
        self._limit_s = limit_s
        self._looked_at = now
        self._given_s = 0.0
        #: By what may be stuck: a mark that changes with its progress, when that mark was first seen, and the time
        #: given until then.
        self._seen: dict[str, tuple[float, float, float]] = {}
        #: Live collections, of which none contains anything while the module is idle: messages that wait, and periodic
        #: handlers.
        self.wakes: tuple[Collection[object], ...] = (
            ticks,
            *(port.subscription.inbox for port in inputs if port.connected),
        )
        #: These, and what the last look saw.
        self.signs: tuple[Collection[object], ...] = (self._seen, *self.wakes)

    def look(self, now: float) -> str | None:
        """A description of what blocks the module, or None."""
        self._given_s += min(now - self._looked_at, LONGEST_STEP_S)
        self._looked_at = now
        seen: dict[str, tuple[float, float, float]] = {}
        stuck = None
        for what, mark, limit_s in self._marks():
            before = self._seen.get(what)
            seen[what] = before if before is not None and before[0] == mark else (mark, now, self._given_s)
            _, since, given_s = seen[what]
            if stuck is None and self._given_s - given_s > limit_s:
                stuck = f"{what} for {now - since:.1f} s"
        self._seen.clear()
        self._seen.update(seen)
        return stuck

    def _marks(self) -> Iterator[tuple[str, float, float]]:
        for port in self._inputs:
            if port.connected and port.subscription.waiting:
                yield f"messages wait at {port.name} and none was taken", port.subscription.taken, self._limit_s
        for name, (stamp, period_s) in self._ticks.items():
            yield f"its periodic {name} did not come round", stamp, max(HUNG_PERIODS * period_s, self._limit_s)
