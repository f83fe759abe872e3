"""Thinning at the source: which periods of a stream a body leaves out where less than its own rate is demanded."""

from __future__ import annotations

import math

_ROUNDING = 1e-6


class Thinning:
    """Periods of a stream of ``rate_hz``, of which one in so many gives a message; all of them until a demand."""

    def __init__(self, rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self._divisor = 1
        #: Periods since the last message; None after a rest.
        self._since: int | None = None

    def demand(self, rate_hz: float) -> None:
        """Give at most ``rate_hz`` from now on; 0: rest, after which the first period gives a message."""
        if rate_hz <= 0:
            self._since = None
        else:
            self._divisor = max(1, math.ceil(self._rate_hz / rate_hz - _ROUNDING))

    @property
    def gives(self) -> bool:
        """Whether the next period gives a message."""
        return self._since is None or self._since + 1 >= self._divisor

    def period(self) -> int:
        """Count a period: 0 if it is left out, else the number of periods that its message ends."""
        if self._since is None:
            self._since = 0
            return 1
        self._since += 1
        if self._since < self._divisor:
            return 0
        ended, self._since = self._since, 0
        return ended
