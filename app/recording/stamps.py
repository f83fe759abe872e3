"""Times in logs: seconds of the robot's clock as ROS and MCAP keep them, in nanoseconds, and back."""

from __future__ import annotations

import math

SECOND = 1_000_000_000


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
