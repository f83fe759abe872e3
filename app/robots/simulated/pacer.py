"""Pacing of simulated time by real time: number of due steps, and rate of the world."""

from __future__ import annotations

from collections import deque

RATE_WINDOW_S = 1.0
LONGEST_WAIT_S = 0.15
"""Half of the greatest age of a scan to drive by, so that scans stay below it."""
GO_ON_S = 0.05
"""Time for a new scan."""


class Pacer:
    """Pure bookkeeping on the monotonic clock (s), stepped by its caller.

    Up to ``backlog_s`` of lost time is caught up, and up to ``waited_s`` of time lost in waiting for images; more is
    dropped, so an overloaded computer slows the world down instead of making it jump. ``stamp``: the real instant of
    the current simulated time.
    """

    def __init__(
        self, now: float, step_s: float, backlog_s: float = 0.1, waited_s: float = 0.05, burst: int = 12
    ) -> None:
        self._step_s = step_s
        self._backlog_s = backlog_s
        self._waited_s = waited_s
        self._burst = burst
        self._waits_since: float | None = None
        self._goes_on = 0
        self._anchor = now
        self._steps = 0
        self._since_anchor = 0
        self._history: deque[tuple[float, int]] = deque([(now, 0)])

    @property
    def stamp(self) -> float:
        """Monotonic time of the last step."""
        return self._anchor + self._since_anchor * self._step_s

    def due(self, now: float) -> int:
        """Number of steps to take now (0 to ``burst``)."""
        self._give_up_beyond(self._backlog_s, now)
        return max(0, min(self._burst, int((now - self.stamp) / self._step_s)))

    def waits(self, now: float, missing: bool) -> bool:
        """Whether simulated time pauses because sensor data are ``missing``: for at most ``LONGEST_WAIT_S``, then not
        again for ``GO_ON_S``."""
        if not missing:
            self._waits_since, self._goes_on = None, 0
            return False
        if self._goes_on:
            self._goes_on -= 1
            return False
        if self._waits_since is None:
            self._waits_since = now
        if now - self._waits_since >= LONGEST_WAIT_S:
            self._waits_since, self._goes_on = None, round(GO_ON_S / self._step_s) - 1
            return False
        self._give_up_beyond(self._waited_s, now)
        return True

    def go_on(self) -> None:
        """Pause for nothing that is missing during the next ``GO_ON_S`` of simulated time."""
        self._waits_since, self._goes_on = None, round(GO_ON_S / self._step_s)

    def advance(self) -> None:
        self._steps += 1
        self._since_anchor += 1

    def wait_s(self, now: float, steps: int) -> float:
        """Seconds until ``steps`` more steps are due, or during a pause until the next check."""
        if self._waits_since is not None:
            return steps * self._step_s
        return max(0.0, self.stamp + steps * self._step_s - now)

    def rate(self, now: float) -> float:
        """Simulated over real time in the last second (1.0 = real time)."""
        if now - self._history[-1][0] >= 0.05:
            self._history.append((now, self._steps))
        while len(self._history) > 2 and now - self._history[1][0] >= RATE_WINDOW_S:
            self._history.popleft()
        then, steps = self._history[0]
        return 1.0 if now - then < 0.2 else (self._steps - steps) * self._step_s / (now - then)

    def _give_up_beyond(self, backlog_s: float, now: float) -> None:
        if now - self.stamp > backlog_s:
            self._anchor = now - backlog_s
            self._since_anchor = 0
