"""When a switch of attention is held back."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from app.attention.problem import Selection, SelectionProblem, produced


@dataclass(frozen=True, slots=True)
class SelectionHysteresis:
    """When a selection that takes something from a desire may replace one that still holds.

    It must gain more than ``gain`` in Ω, or have been the better one for ``dwell_s`` seconds. A limit of 0 is not used;
    with both 0 every switch is made at once.
    """

    gain: float = 0.0
    dwell_s: float = 0.0


class HysteresisState:
    """Decides by a :class:`SelectionHysteresis`, and remembers since when a switch is held back."""

    def __init__(self, limits: SelectionHysteresis) -> None:
        self.limits = limits
        #: When the switch held back now may be made; None while none is, or only its gain counts.
        self.until: float | None = None

    def release(self) -> None:
        """Drop the switch that is held back: ``dwell_s`` of the next one begins with that one."""
        self.until = None

    def concerns(self, best: Selection, before: Collection[str]) -> bool:
        """Whether there is anything to decide: ``best`` is another selection than ``before``, and limits are set."""
        return bool(self.limits.gain or self.limits.dwell_s) and set(best.strategies) != set(before)

    def holds(
        self, problem: SelectionProblem, best: Selection, stay: Selection, before: Collection[str], now: float
    ) -> bool:
        """Whether ``stay``, the best among the strategies ``before`` that are on, is kept instead of ``best``."""
        # The best among what is on is all of it only if it still holds and nothing of it is useless.
        loses = any(produced(problem, best.strategies, cls) < produced(problem, before, cls) for cls in stay.fulfilled)
        if set(stay.strategies) != set(before) or stay.relaxed != best.relaxed or not loses:
            self.until = None
            return False
        if self.until is None:
            self.until = now + self.limits.dwell_s
        gained = self.limits.gain and best.omega - stay.omega > self.limits.gain
        lasted = self.limits.dwell_s and now >= self.until
        if gained or lasted:
            self.until = None
            return False
        return True
