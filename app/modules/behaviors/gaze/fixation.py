"""Which of several salient directions is looked at, and for how long. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class FixationRules:
    """``hold_s``: so long a direction is looked at, once the eye has reached it, or ``reach_s`` after it was chosen.
    ``same_rad``: a direction that moved no further between two messages is the same."""

    hold_s: float = 1.5
    reach_s: float = 2.0
    same_rad: float = math.radians(15.0)


class Gazing:
    """Looks at one direction after the other; ``v_O``: the present one (3,), of length 1, in odom's axes, or None."""

    def __init__(self, rules: FixationRules) -> None:
        self._rules = rules
        self.v_O: NDArray[np.float64] | None = None
        self._chosen = -math.inf
        self._held_since: float | None = None
        #: What was salient before the last fixation does not count: it was not inhibited yet.
        self._after = -math.inf

    def take(self, stamp: float, directions: Sequence[NDArray[np.float64]]) -> None:
        """The most salient ``directions`` (3,) at ``stamp`` (s), the most salient first. The present one is followed;
        without one, the first is chosen."""
        if stamp <= self._after:
            return
        if self.v_O is None:
            if directions:
                self.v_O, self._chosen, self._held_since = directions[0], stamp, None
            return
        near = max(directions, key=lambda v: float(v @ self.v_O), default=None)  # type: ignore[operator]
        if near is not None and math.acos(min(1.0, float(near @ self.v_O))) <= self._rules.same_rad:
            self.v_O = near

    def step(self, now: float, reached: bool) -> NDArray[np.float64] | None:
        """The direction that has been looked at for long enough at ``now`` (s), whereupon none is present; else None.
        ``reached``: the eye looks at it."""
        if self.v_O is None:
            return None
        if self._held_since is None and (reached or now - self._chosen >= self._rules.reach_s):
            self._held_since = now
        if self._held_since is None or now - self._held_since < self._rules.hold_s:
            return None
        done, self.v_O, self._after = self.v_O, None, now
        return done
