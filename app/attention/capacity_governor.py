"""How much of a budget attention may give while others press on the same computer.

The program's share of the budget falls by what it waited for a core beyond what is ordinary, rises as far as its cores
had room, and tries a little more from time to time where nothing presses though others leave no room. Falling needs two
windows in a row, rising a while, a try that had to be taken back the longer (:class:`Reluctance`): constant pressure
gives a constant share.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from app.attention.reluctance import Patience, Reluctance

#: Of the time that runnable threads want, what may be waiting though nobody presses: they wait for each other.
ORDINARY: Final = 0.2
#: A loop that is late by this (s) on average has as little time as one that waits half of it.
_LATE_S: Final = 0.1
#: Room (% of one core) that is no room, and the part of it that is given.
_NO_ROOM: Final = 8.0
_GIVEN: Final = 0.8
#: Steps of the share, and the least change of it that is worth one.
_STEP: Final = 0.05
_WORTH: Final = 0.05
_TRY: Final = 0.1
#: What is kept at least of the CPU that was had.
_KEPT: Final = 0.8


@dataclass(frozen=True, slots=True)
class Pressure:
    """The computer in one window.

    ``waiting``: of the time that the program's threads ran or could have run, the share in which they had no core
    (Linux, ``schedstat``). ``room``: idle time of the cores that it may use, % of one core. ``stalled``: the share of
    the time in which some task of the computer had none (PSI, ``cpu some``). ``runnable``: tasks that could run, over
    those cores.
    ``late_s``: how late the event loop was on average. NaN: not known here.
    """

    waiting: float = math.nan
    room: float = math.nan
    stalled: float = math.nan
    runnable: float = math.nan
    late_s: float = math.nan

    @property
    def lack(self) -> float:
        """The share of the wanted time that was not there, by the best witness there is, or by the loop's lateness if
        that says more: 0 to 1."""
        late = 0.0 if math.isnan(self.late_s) else self.late_s / (self.late_s + _LATE_S)
        return max(late, self._waiting())

    @property
    def has_room(self) -> bool:
        """Whether the program's cores were idle for a while."""
        return self.room > _NO_ROOM

    def _waiting(self) -> float:
        if not math.isnan(self.waiting):
            return self.waiting
        if not math.isnan(self.stalled):
            # Of the whole computer, so an upper bound of ours: it counts where the cores are taken without a break.
            return max(0.0, self.stalled - 0.5)
        return 0.0 if math.isnan(self.runnable) else max(0.0, 1 - 1 / max(1.0, self.runnable))


class CapacityGovernor:
    """The share of a budget, from ``least`` to 1."""

    def __init__(self, least: float) -> None:
        """Raises ValueError for a least share that is not over 0 and at most 1."""
        if not 0 < least <= 1:
            raise ValueError(f"the least share is over 0 and at most 1, not {least!r}")
        self.share = 1.0
        self._least = least
        self._pressed = 0
        self._relief = Reluctance(Patience(least_s=1.0, most_s=8.0, regret_s=10.0))
        self._probe = Reluctance(Patience(least_s=15.0, most_s=240.0, regret_s=30.0))

    @property
    def suspects(self) -> bool:
        """Whether the last window was under pressure, of which the next may make something."""
        return self._pressed > 0

    def take(self, now: float, pressure: Pressure, budget: float, used: float) -> bool:
        """A window closed at ``now``, in which attention's modules used ``used`` of the declared ``budget``. Returns
        whether the share changed."""
        before = self.share
        excess = pressure.lack - ORDINARY
        if excess > 0 and not pressure.has_room:
            self._pressed += 1
            if self._pressed >= 2:
                self._lower(now, excess, used / budget if budget > 0 else 0.0)
        else:
            self._pressed = 0
        self._raise(now, pressure, excess, budget, used)
        return self.share != before

    def _lower(self, now: float, excess: float, had: float) -> None:
        # What was had under pressure is there, nearly.
        lower = max(self._least, _stepped(self.share * (1 - min(excess, 0.5))), _stepped(_KEPT * min(had, self.share)))
        if lower >= self.share:
            return
        self.share = lower
        self._relief.take_back(now)
        self._probe.take_back(now)

    def _raise(self, now: float, pressure: Pressure, excess: float, budget: float, used: float) -> None:
        higher = self.share
        if pressure.has_room and budget > 0:
            in_use = max(used / budget, self.share)
            higher = min(1.0, _stepped(in_use + _GIVEN * pressure.room / budget))
        if self._relief.want(now, higher >= self.share + _WORTH - 1e-9):
            self.share = higher
            self._relief.give(now)
        calm = self.share < 1 and excess < -ORDINARY / 2 and not pressure.has_room
        if self._probe.want(now, calm):
            self.share = min(1.0, _stepped(self.share + _TRY))
            self._probe.give(now)


def _stepped(share: float) -> float:
    return round(math.floor(share / _STEP + 1e-6) * _STEP, 6)
