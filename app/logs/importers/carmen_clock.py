"""When the lines of a CARMEN log were written: by their stamps, or by their order where these cannot be used."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from app.logs.importers.carmen_lines import CarmenTimes
from app.logs.stamps import Onward

#: A line of a log that goes back further than this (s), or on further, was not written at the time that it says.
_BACK_S = 10.0
_ON_S = 86400.0
#: Least time (s) of a line that was measured: programs write smaller ones for an unknown time. Zero itself is the time
#: of the first lines, before any later one.
_NO_TIME_S = 1e-9
#: Lines of a log without times are so far apart that its scans are (s).
ASSUMED_PERIOD_S = 0.2
#: Times are of use where so large a share of the laser's lines says a later one than all before, ...
_ADVANCING = 0.5
#: ... and at most this share of invalid ones.
_UNTIMED = 0.2


@dataclass(slots=True)
class CarmenClock:
    """Times of the lines read so far, by their stamps. ``shift`` converts logger times to the captures' clock."""

    at: float
    shift: float
    started: bool = False
    stamps: dict[str, Onward] = field(default_factory=dict)

    def next(self, kind: str, times: CarmenTimes) -> tuple[float, float] | None:
        """Arrival and capture (s) of a line; None for times that cannot be.

        Arrivals never go back: the lines of a log are in the order of their arrival, though some loggers wrote times a
        little out of order. Nor do the captures of one kind of lines (:class:`Onward`).
        """
        captured, logged = times.captured, times.logged + self.shift
        never = captured < 0.0 or (0.0 < captured <= _NO_TIME_S)
        if never or (captured == 0.0 and self.started and self.at > _NO_TIME_S):
            return None
        if not all(self.at - _BACK_S <= time <= self.at + _ON_S for time in (captured, logged)):
            return None
        self.at = max(self.at, logged) if self.started else logged
        self.started = True
        return self.at, self.stamps.setdefault(kind, Onward()).next(captured)

    @property
    def back(self) -> int:
        """Number of captures that went back."""
        return sum(stamps.back for stamps in self.stamps.values())

    @property
    def most_back_s(self) -> float:
        """Greatest step back (s) of a capture."""
        return max((stamps.most_back_s for stamps in self.stamps.values()), default=0.0)


@dataclass(slots=True)
class OrderClock:
    """Times of lines at a fixed period of ``period_s``, without regard to their stamps."""

    period_s: float
    lines: int = 0

    @property
    def at(self) -> float:
        """The time (s) of the last line."""
        return max(self.lines - 1, 0) * self.period_s

    def next(self, kind: str, times: CarmenTimes) -> tuple[float, float]:
        """Arrival and capture (s) of a line: the same."""
        self.lines += 1
        return self.at, self.at


Clock = CarmenClock | OrderClock


@dataclass(slots=True)
class Advance:
    """Whether the times of a log can be used: counted line by line, by the kind of the line."""

    lines: Counter[str] = field(default_factory=Counter)
    untimed: Counter[str] = field(default_factory=Counter)
    advancing: Counter[str] = field(default_factory=Counter)
    greatest: dict[str, float] = field(default_factory=dict)

    def count(self, kind: str, times: CarmenTimes, timed: bool) -> None:
        """Count a line; ``timed``: whether its times are possible."""
        self.lines[kind] += 1
        if not timed:
            self.untimed[kind] += 1
        elif kind not in self.greatest or times.captured > self.greatest[kind]:
            self.greatest[kind] = times.captured
            self.advancing[kind] += 1

    def by_order(self, main: str) -> OrderClock | None:
        """The clock by the order of lines, where the times of ``main``'s lines are of no use; None where they are."""
        lines = self.lines[main]
        usable = self.advancing[main] >= _ADVANCING * lines and self.untimed[main] <= _UNTIMED * lines
        if usable or lines < 2:
            return None
        return OrderClock(ASSUMED_PERIOD_S * lines / self.lines.total())
