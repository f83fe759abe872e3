"""Mode 2 of the thesis (3.4): the head follows the view, and past a soft limit the base turns after it; pure.

``web/src/drive/viewFollow.ts`` is the same for the page, and says why; both are compared with one file of examples.
Angles are in degrees, left positive, by the robot's front.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

SOFT_LIMIT_DEG = 30.0
#: The base begins to turn this far beyond the limit.
BAND_DEG = 8.0
_FULL_DEG, _FULL_SPEED = 30.0, 0.6
_SLEW_PER_S, _LONGEST_S = 1.5, 0.2
_HEAD_FULL_DEG, _HEAD_REST_DEG = 20.0, 1.5


@dataclass(frozen=True, slots=True)
class Follow:
    """Whether the base is ``turning``; ``pan`` of the head and ``angular`` of the base are shares of the greatest
    speeds, -1 to 1, left positive."""

    turning: bool = False
    pan: float = 0.0
    angular: float = 0.0


STILL = Follow()


def follow(before: Follow, bearing: float, gaze: float, *, limit: float = SOFT_LIMIT_DEG, passed: float) -> Follow:
    """What head and base are to do ``passed`` seconds after ``before``: the view is at ``bearing``, the head at
    ``gaze``."""
    if not (math.isfinite(bearing) and math.isfinite(gaze)):
        return STILL
    beyond = abs(bearing) - limit
    turning = beyond > (0.0 if before.turning else BAND_DEG)
    wanted = math.copysign(_FULL_SPEED * min(1.0, beyond / _FULL_DEG), bearing) if turning else 0.0
    return Follow(turning, _head_speed(bearing - gaze), _slewed(before.angular, wanted, passed))


def _slewed(before: float, wanted: float, passed: float) -> float:
    if wanted == 0.0 or before * wanted < 0.0:
        return 0.0
    most = abs(before) + _SLEW_PER_S * max(0.0, min(passed, _LONGEST_S))
    return math.copysign(min(abs(wanted), most), wanted)


def _head_speed(error: float) -> float:
    if abs(error) < _HEAD_REST_DEG:
        return 0.0
    return max(-1.0, min(1.0, error / _HEAD_FULL_DEG))
