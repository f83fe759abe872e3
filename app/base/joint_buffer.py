"""The recent past of a body's joints: their positions are looked up at a message's own stamp, as poses are."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
from collections.abc import Mapping


class JointBuffer:
    """Joint positions (rad, m) by name over the last ``span_s`` seconds, interpolated in between.

    A stamp up to ``tolerance_s`` beyond either end takes the nearest positions, since sensors and encoders are not in
    step; further out there is no answer. A joint that jumps by more than half a turn (it counts within ±π) has its
    nearest position.
    """

    def __init__(self, span_s: float = 2.0, tolerance_s: float = 0.1) -> None:
        self._span_s = span_s
        self._tolerance_s = tolerance_s
        self._stamps: deque[float] = deque()
        self._positions: deque[Mapping[str, float]] = deque()

    def add(self, stamp: float, positions: Mapping[str, float]) -> None:
        """Append positions; those that are not newer than the last are ignored."""
        if self._stamps and stamp <= self._stamps[-1]:
            return
        self._stamps.append(stamp)
        self._positions.append(positions)
        while self._stamps[0] < stamp - self._span_s:
            self._stamps.popleft()
            self._positions.popleft()

    @property
    def newest(self) -> Mapping[str, float] | None:
        """The positions added last; None before the first."""
        return self._positions[-1] if self._positions else None

    @property
    def newest_stamp(self) -> float | None:
        """The stamp of the positions added last; None before the first."""
        return self._stamps[-1] if self._stamps else None

    def speed(self) -> float:
        """The speed (rad/s, m/s) of the fastest joint between the two newest positions; 0 without two."""
        if len(self._stamps) < 2:
            return 0.0
        old, new = self._positions[-2], self._positions[-1]
        moves = (abs(math.remainder(new[name] - old[name], math.tau)) for name in old.keys() & new.keys())
        return max(moves, default=0.0) / (self._stamps[-1] - self._stamps[-2])

    def at(self, stamp: float) -> Mapping[str, float] | None:
        """The positions at ``stamp``, of the joints known on both sides of it; None where the buffer does not reach."""
        if not self._stamps:
            return None
        after = bisect_right(self._stamps, stamp)
        if after == 0:
            return self._positions[0] if self._stamps[0] - stamp <= self._tolerance_s else None
        if after == len(self._stamps):
            return self._positions[-1] if stamp - self._stamps[-1] <= self._tolerance_s else None
        begin, end = self._stamps[after - 1], self._stamps[after]
        old, new = self._positions[after - 1], self._positions[after]
        share = (stamp - begin) / (end - begin)
        return {name: _between(old[name], new[name], share) for name in old.keys() & new.keys()}


def _between(old: float, new: float, share: float) -> float:
    if abs(new - old) > math.pi:
        return old if share < 0.5 else new
    return old + share * (new - old)
