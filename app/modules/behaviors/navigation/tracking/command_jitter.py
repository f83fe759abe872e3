"""How regularly a behavior commands."""

from __future__ import annotations

from collections import deque

#: So many periods are remembered: ten seconds of them at 10 Hz.
_KEPT = 100


class CommandJitter:
    """The times (s) between commands of late, while they are given one after another."""

    def __init__(self) -> None:
        self._last: float | None = None
        self._kept: deque[float] = deque(maxlen=_KEPT)

    def commanded(self, now: float) -> None:
        """A command was given at ``now``."""
        if self._last is not None:
            self._kept.append(now - self._last)
        self._last = now

    def rest(self) -> None:
        """None will be given for a while: the next one follows no other."""
        self._last = None

    @property
    def longest_s(self) -> float | None:
        """The longest of late, None before there were two commands."""
        return max(self._kept, default=None)
