"""Keeps simulated time on real time: how many steps are due, and how fast the world has run."""

from __future__ import annotations

from collections import deque

RATE_WINDOW_S = 1.0


class Pacer:
    """Pure bookkeeping on the monotonic clock (s), stepped by its caller.

    Up to ``backlog_s`` of lost time is made up for; what is lost beyond is given up, so an overloaded computer slows
    the world down instead of making it jump. ``stamp`` names the real instant that simulated time stands for.
    """

    def __init__(self, now: float, step_s: float, backlog_s: float = 0.1, burst: int = 12) -> None:
        self._step_s = step_s
        self._backlog_s = backlog_s
        self._burst = burst
        self._anchor = now
        self._steps = 0
        self._since_anchor = 0
        self._history: deque[tuple[float, int]] = deque([(now, 0)])

    @property
    def stamp(self) -> float:
        """The monotonic time that the last step stands for."""
        return self._anchor + self._since_anchor * self._step_s

    def due(self, now: float) -> int:
        """How many steps to take now (0 to ``burst``); they count as taken."""
        lag = now - self.stamp
        if lag > self._backlog_s:
            self._anchor = now - self._backlog_s
            self._since_anchor = 0
            lag = self._backlog_s
        return max(0, min(self._burst, int(lag / self._step_s)))

    def advance(self) -> None:
        """One step was taken."""
        self._steps += 1
        self._since_anchor += 1

    def wait_s(self, now: float, steps: int) -> float:
        """Seconds until ``steps`` more steps are due."""
        return max(0.0, self.stamp + steps * self._step_s - now)

    def rate(self, now: float) -> float:
        """Simulated over real time in the last second (1.0 = real time)."""
        if now - self._history[-1][0] >= 0.05:
            self._history.append((now, self._steps))
        while len(self._history) > 2 and now - self._history[1][0] >= RATE_WINDOW_S:
            self._history.popleft()
        then, steps = self._history[0]
        return 1.0 if now - then < 0.2 else (self._steps - steps) * self._step_s / (now - then)
