"""Barge-in: whether a person talks while the robot speaks. Values and times in, no clock."""

from __future__ import annotations

import math

#: A voice may pause so long (s) between syllables and still be one.
_GAP_S = 0.4


class BargeIn:
    """A voice heard for ``after_s`` makes the robot yield until ``resume_s`` after its end. ``after_s`` None: never."""

    def __init__(self, after_s: float | None, resume_s: float) -> None:
        self._after_s = after_s
        self._resume_s = resume_s
        self._since = math.inf
        self._last = -math.inf
        self._yields = False

    def hear(self, stamp: float, voice: bool) -> None:
        """Whether a voice sounds at ``stamp``."""
        if not voice:
            return
        if stamp - self._last > _GAP_S:
            self._since = stamp
        self._last = stamp
        if self._after_s is not None and stamp - self._since >= self._after_s:
            self._yields = True

    def yields(self, now: float) -> bool:
        """Whether the robot yields to a voice at ``now``."""
        if now - self._last > self._resume_s:
            self._yields = False
        return self._yields
