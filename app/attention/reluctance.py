"""Ease that is given with growing patience, so that nothing swings: what had to be taken back soon waits longer."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Patience:
    """Seconds: what is wanted for ``least_s`` is given; each gift that is taken back within ``regret_s`` doubles that,
    up to ``most_s``; one that is not ends it."""

    least_s: float = 2.0
    most_s: float = 120.0
    regret_s: float = 20.0


class Reluctance:
    """When ease may be given: once it is wanted without a break for as long as the past demands."""

    def __init__(self, patience: Patience | None = None) -> None:
        self._patience = patience or Patience()
        self.hold_s = self._patience.least_s
        self._wanted: float | None = None
        self._given: float | None = None

    def want(self, now: float, wanted: bool) -> bool:
        """Whether it may be given now; ``wanted`` whether it would be."""
        if not wanted:
            self._wanted = None
            return False
        if self._wanted is None:
            self._wanted = now
        return now - self._wanted >= self.hold_s - 1e-9

    def give(self, now: float) -> None:
        """It is given at ``now``."""
        self._given, self._wanted = now, None

    def take_back(self, now: float) -> None:
        """It is taken away at ``now``."""
        soon = self._given is not None and now - self._given < max(self._patience.regret_s, self.hold_s)
        self.hold_s = min(2 * self.hold_s, self._patience.most_s) if soon else self._patience.least_s
        self._given = self._wanted = None
