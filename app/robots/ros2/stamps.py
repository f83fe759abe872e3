"""Stamps of a robot's messages on the clock of the program: pure bookkeeping, stepped by its caller. Times in s."""

from __future__ import annotations

import math
from typing import Literal


class WrongClock(ValueError):
    """A stamp that cannot be a time of the program's clock; its text says why, and what to look at."""


class StampClock:
    """Takes stamps (s) as ``clock`` of :class:`app.robots.ros2.config.GraphConfig` says.

    With ``sim``, a stamp is placed by the newest ``/clock`` (:meth:`tick`): as long before that one's arrival as it is
    before its time. That is exact while simulated time runs as fast as real time.
    """

    def __init__(self, clock: Literal["header", "sim", "arrival"], tolerance_s: float) -> None:
        self._clock = clock
        self._tolerance_s = tolerance_s
        self._ticked: tuple[float, float] | None = None

    def tick(self, simulated: float, arrival: float) -> bool:
        """Note a message of ``/clock``, which arrived at ``arrival``; False where time went back since the last."""
        before, self._ticked = self._ticked, (simulated, arrival)
        return before is None or simulated >= before[0] - self._tolerance_s

    def outgoing(self, now: float) -> float | None:
        """The stamp of what is sent to the robot at ``now``, on its clock; None where that is unknown."""
        if self._clock == "header":
            return now
        if self._clock == "arrival" or self._ticked is None:
            return None
        return self._ticked[0] + now - self._ticked[1]

    def placed(self, stamp: float | None, arrival: float) -> float:
        """The time of a message with ``stamp`` (None: it was left empty) that arrived at ``arrival``.

        Raises WrongClock.
        """
        if self._clock == "arrival" or stamp is None:
            return arrival
        if self._clock == "header":
            self._check(stamp - arrival, "this computer's: synchronize the two (NTP, chrony)")
            return stamp
        if self._ticked is None:
            raise WrongClock("nothing has come on /clock yet, which the mapping takes the time from (clock: sim)")
        simulated, ticked = self._ticked
        self._check(stamp - simulated, "that of /clock: does its node run with use_sim_time?")
        return min(ticked + stamp - simulated, arrival)

    def _check(self, ahead_s: float, other: str) -> None:
        if not math.isfinite(ahead_s) or abs(ahead_s) > self._tolerance_s:
            side = "in the future" if ahead_s > 0 else "in the past"
            raise WrongClock(f"its time lies {abs(ahead_s):.1f} s {side}; the robot's clock is not {other}")
