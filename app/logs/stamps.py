"""Times in logs: seconds of the robot's clock as ROS and MCAP keep them, in nanoseconds, and back."""

from __future__ import annotations

import math

SECOND = 1_000_000_000
#: A stamp that goes back is replaced by the one before plus the last step, which counts as at most this (s).
_LONGEST_STEP_S = 1.0
#: Stamps that go back no farther than this (s) were written a little out of order: they are not reported.
JITTER_S = 0.1
#: Stamps that would be alike differ by this (s).
_LEAST_STEP_S = 1e-6


def to_ns(seconds: float) -> int:
    """Nanoseconds since the epoch of ``seconds``: whole seconds and fraction apart, so that no digit is lost."""
    whole = math.floor(seconds)
    return whole * SECOND + round((seconds - whole) * 1e9)


def from_ns(nanoseconds: int) -> float:
    """Seconds of ``nanoseconds``: exactly those that :func:`to_ns` was given, where they are 2**23 s (97 days) or more.

    From there on neighbouring float64 are further apart than a nanosecond; below, the last digits are rounded to one.
    """
    whole, rest = divmod(nanoseconds, SECOND)
    return whole + rest / 1e9


class Onward:
    """Makes the stamps (s) of one sensor's messages, in the order of a log, increase.

    A log's order is that of arrival, which is right where a stamp is not: a clock that was set, a message with a wrong
    stamp. Such a stamp becomes the one before plus the last step. If the next stamp continues from it, the clock was
    set: stamps follow it then, and wait until it has caught up.
    """

    __slots__ = ("_given", "_last", "_newest", "_step", "back", "first_back", "most_back_s", "seen")

    def __init__(self) -> None:
        self._newest = -math.inf
        self._last = -math.inf
        self._given = -math.inf
        self._step = 0.0
        #: Number of stamps that went back, by how much (s) at most, the index of the first (from 0; -1: none), and the
        #: number of all stamps.
        self.back = 0
        self.most_back_s = 0.0
        self.first_back = -1
        self.seen = 0

    def next(self, stamp: float) -> float:
        """``stamp``, or its replacement: never less than the one before."""
        self.seen += 1
        went_back = stamp < self._newest
        follows = self._last < self._newest and stamp >= self._last
        self._last = stamp
        if went_back and not follows:
            self.back += 1
            self.most_back_s = max(self.most_back_s, self._newest - stamp)
            self.first_back = self.seen - 1 if self.first_back < 0 else self.first_back
            self._given += max(self._step, _LEAST_STEP_S)
            return self._given
        if 0.0 < stamp - self._newest <= _LONGEST_STEP_S:
            self._step = stamp - self._newest
        self._newest = stamp
        self._given = stamp if stamp >= self._given else self._given + _LEAST_STEP_S
        return self._given
