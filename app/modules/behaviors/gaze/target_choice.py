"""Which of several percepts is looked at, where it is, and when it is given up. Pure.

The percept that is followed stays the one until it has not been seen for ``keep_s`` or another is better by ``margin``.
While it is unseen, its last place is looked at. Without any for ``give_up_s`` the search is over, until one is seen.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A percept that could be looked at: its ``name``, its place ``p_OP`` (3,) m in odom, and its ``rank``: the lower,
    the better."""

    name: str
    p_OP: NDArray[np.float64]
    rank: float


@dataclass(frozen=True, slots=True)
class ChoiceRules:
    """``keep_s``: so long an unseen percept stays the one. ``give_up_s``: without any for so long, the search is over.
    ``margin``: of rank, by which another must be better. ``smoothing_s``: time constant of places; one that is further
    from the last than ``jump_m`` is taken at once."""

    keep_s: float = 2.0
    give_up_s: float = 10.0
    margin: float = math.inf
    smoothing_s: float = 0.15
    jump_m: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """The percept that is looked at: ``name``, its smoothed place (3,) m in odom, and when it was seen last (s)."""

    name: str
    p_OP: NDArray[np.float64]
    seen: float


class TargetChoice:
    """Follows one percept. ``what``: the kind, for the reasons in words ("a face"); ``wanted``: the only name that
    counts, "" for any."""

    def __init__(self, what: str, wanted: str, rules: ChoiceRules, now: float) -> None:
        self.what = what
        self.wanted = wanted
        self._rules = rules
        self._since = now
        self.target: Target | None = None

    def see(self, stamp: float, candidates: Sequence[Candidate]) -> None:
        """Take what was perceived at ``stamp`` (s), perhaps nothing."""
        usable = [each for each in candidates if self.wanted in ("", each.name)]
        target = self.target
        best = min(usable, key=lambda each: each.rank, default=None)
        if best is None or (target is not None and stamp < target.seen):
            return
        same = None if target is None else next((each for each in usable if each.name == target.name), None)
        if target is None or stamp - target.seen > self._rules.keep_s:
            self.target = Target(best.name, best.p_OP, stamp)
        elif same is not None and not best.rank < same.rank - self._rules.margin:
            self.target = Target(same.name, self._smoothed(target, same.p_OP, stamp), stamp)
        elif same is not None:
            self.target = Target(best.name, best.p_OP, stamp)

    def problem(self, now: float) -> str:
        """Why the search is over at ``now``, in words; "" while it is not."""
        since = self._since if self.target is None else self.target.seen
        if now - since < self._rules.give_up_s:
            return ""
        called = f"{self.what} {self.wanted}" if self.wanted else self.what
        if self.target is None:
            return f"it gave up: {called} was not perceived within {self._rules.give_up_s:g} s"
        return f"it gave up: {called} has not been perceived for {self._rules.give_up_s:g} s"

    def _smoothed(self, target: Target, p_OP: NDArray[np.float64], stamp: float) -> NDArray[np.float64]:
        step = p_OP - target.p_OP
        if self._rules.smoothing_s <= 0 or float(np.linalg.norm(step)) > self._rules.jump_m:
            return p_OP
        share = 1.0 - math.exp(-(stamp - target.seen) / self._rules.smoothing_s)
        return np.asarray(target.p_OP + share * step)
