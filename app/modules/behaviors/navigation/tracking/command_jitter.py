"""Regularity of a behavior's commands."""

from __future__ import annotations

from collections import deque

#: Number of periods kept: ten seconds at 10 Hz.
_KEPT = 100


class CommandJitter:
    """The last periods (s) between consecutive commands."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._kept: deque[float] = deque(maxlen=_KEPT)

    def commanded(self, now: float) -> None:
        if self._last is not None:
            self._kept.append(now - self._last)
        self._last = now

    def rest(self) -> None:
        """Note a pause: the next command starts a new sequence."""
        self._last = None

    @property
    def longest_s(self) -> float | None:
        """The longest kept period, None before the second command."""
        return max(self._kept, default=None)
