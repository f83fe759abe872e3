"""The rate filter: of every φ messages offered, one passes (thesis 2.2.3, 4.2.3).

φ = 1 lets all through, φ = ∞ (``CLOSED``) none. Opening a filter, or changing its φ, lets the next message pass at
once; giving it the φ it already has changes nothing, its phase included.

A source may leave out messages that no filter would let through. The next one then counts for all their periods, so
that φ keeps its meaning: one in φ of the source's own periods.
"""

from __future__ import annotations

import math
from collections.abc import Callable

CLOSED = math.inf


def check_divisor(divisor: float) -> float:
    """Return ``divisor`` if it is an integer >= 1 or ``CLOSED``; raise ValueError saying what is allowed."""
    # `not >=` rather than `<`: it refuses NaN too.
    if not divisor >= 1 or (divisor != CLOSED and divisor != int(divisor)):
        raise ValueError(f"a divisor must be an integer of at least 1, or infinite (closed), not {divisor!r}")
    return divisor


class RateFilter:
    """Counts messages and lets one in ``divisor`` pass.

    ``skip`` messages are still to be stopped before one passes; after it, ``reload`` of them. ``phi`` is the divisor,
    to be read where thousands are read at a time.
    """

    __slots__ = ("on_change", "phi", "reload", "skip")

    def __init__(self, divisor: float = 1, on_change: Callable[[float, float], None] | None = None) -> None:
        self.on_change = on_change
        self.phi = check_divisor(divisor)
        self.reload = divisor - 1
        self.skip: float = CLOSED if divisor == CLOSED else 0

    @property
    def divisor(self) -> float:
        """φ: an integer >= 1, or ``CLOSED``."""
        return self.phi

    @divisor.setter
    def divisor(self, divisor: float) -> None:
        """Change φ; ``on_change(before, after)`` is called if it is another. Raises ValueError, changing nothing."""
        if check_divisor(divisor) != self.phi:
            self.change(divisor)

    def change(self, divisor: float) -> None:
        """Change φ to another one, which :func:`check_divisor` has let pass."""
        before = self.phi
        self.phi = divisor
        self.reload = divisor - 1
        self.skip = CLOSED if divisor == CLOSED else 0
        if self.on_change is not None:
            self.on_change(before, divisor)

    def begin(self, offset: int) -> None:
        """Let ``offset`` messages go by before the next one that passes: the phase at which decimation begins."""
        if self.is_open:
            self.skip = offset

    @property
    def is_open(self) -> bool:
        """Whether anything passes at all."""
        return self.phi != CLOSED

    def offer(self, periods: int = 1) -> int:
        """Count a message that ends ``periods`` of its source, all but the last without a message of their own; returns
        how many of them pass. The message passes if any does.
        """
        # A closed filter skips infinitely many: inf - n is inf, so one test serves every φ.
        if self.skip >= periods:
            self.skip -= periods
            return 0
        after = periods - self.skip - 1
        self.skip = self.reload - after % self.phi
        return int(1 + after // self.phi)
