"""Turning in place to a heading: the turn rate by the angle that is left. A small class without a clock."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

#: Gain (1/s): the speed falls with the angle that is left.
_GAIN: Final = 1.5
#: Slower turns (rad/s) do not overcome friction.
_LEAST_RADPS: Final = 0.1
#: A base that comes no nearer by this much (rad) within so long (s) does not turn.
_NEARER_RAD: Final = 0.02
_STUCK_S: Final = 5.0


@dataclass(frozen=True, slots=True)
class RotationStep:
    """The turn rate to command (rad/s, left positive), None for no command; ``done``: the heading is reached;
    ``stuck``: the base does not turn."""

    radps: float | None
    done: bool = False
    stuck: bool = False


class Rotation:
    """Turns until ``tolerance_rad`` is left, at most at ``fastest_radps``; a heading that is reached is turned to again
    only once it is off by ``begin_rad``."""

    def __init__(self, fastest_radps: float, *, tolerance_rad: float, begin_rad: float) -> None:
        self._fastest_radps = max(fastest_radps, _LEAST_RADPS)
        self._tolerance_rad = tolerance_rad
        self._begin_rad = max(begin_rad, tolerance_rad)
        self._turns = True
        self._least_rad, self._since = math.inf, -math.inf

    def step(self, now: float, error_rad: float) -> RotationStep:
        """What to do at ``now`` (s); ``error_rad`` in [-pi, pi[ is the heading's angle from the base, left positive."""
        left = abs(error_rad)
        if left > (self._tolerance_rad if self._turns else self._begin_rad):
            if not self._turns or left < self._least_rad - _NEARER_RAD:
                self._least_rad, self._since = left, now
            self._turns = True
            speed = min(max(_GAIN * left, _LEAST_RADPS), self._fastest_radps)
            return RotationStep(math.copysign(speed, error_rad), stuck=now - self._since >= _STUCK_S)
        step = RotationStep(0.0 if self._turns else None, done=True)
        self._turns, self._least_rad = False, math.inf
        return step
