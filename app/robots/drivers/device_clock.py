"""A device's own clock, moved to the robot's: what it says was late by its way, and never early."""

from __future__ import annotations

#: Two clocks of quartz differ in rate by less.
DRIFT = 2e-4
#: Later than that (s), it is taken for another beginning of the device's clock.
LATEST_S = 1.0


class DeviceClock:
    """Times of a counter of ``ticks_per_s`` that begins again after ``modulus`` ticks.

    The difference of both clocks is the least that was seen between a device's time and its arrival, for nothing
    arrives before it is sent; it may grow by :data:`DRIFT`.
    """

    def __init__(self, ticks_per_s: float, modulus: int) -> None:
        self._ticks_per_s = ticks_per_s
        self._modulus = modulus
        self._last: int | None = None
        self._total = 0
        self._offset = 0.0
        self._seen = 0.0

    def placed(self, ticks: int, arrived: float) -> float:
        """The time (s, robot's clock) at which the device's counter was at ``ticks``, said at ``arrived``."""
        passed = 0 if self._last is None else (ticks - self._last) % self._modulus
        began = self._last is None or passed > self._modulus // 2
        self._last = ticks
        self._total += 0 if began else passed
        own = self._total / self._ticks_per_s
        allowed = self._offset + DRIFT * max(arrived - self._seen, 0.0)
        least = arrived - own
        self._offset = least if began or least - allowed > LATEST_S else min(least, allowed)
        self._seen = arrived
        return own + self._offset
