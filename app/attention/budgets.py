"""What attention may give of each resource: budgets that people and batteries set, less what pressure takes of them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from app.attention.desires import GRAIN
from app.attention.strategies import MOST
from app.attention.timeline import Timeline


class Budgets:
    """The budgets of all resources, at first ``capacities``, each in its resource's unit. Changes go to the timeline.

    Amounts are whole thousandths, rounded down: the solver counts in these.
    """

    def __init__(self, capacities: Mapping[str, float], timeline: Timeline) -> None:
        self._budgets = dict(capacities)
        #: What pressure leaves of them; 1 where nothing is said.
        self._shares: dict[str, float] = {}
        self._timeline = timeline

    def whole(self) -> dict[str, float]:
        """The budgets as they were set last."""
        return dict(self._budgets)

    def left(self) -> dict[str, float]:
        """What may be given now: of each budget the share that is left."""
        return {name: self._left(name) for name in self._budgets}

    def set(self, resource: str, value: float, reason: str) -> bool:
        """Set a budget, for ``reason``; whether it is another than before. Raises ValueError for a resource that there
        is not, or a value below 0 or above ``MOST``."""
        self._known(resource)
        if not 0 <= value <= MOST:
            raise ValueError(f"the capacity of {resource} must be from 0 to {MOST:,.0f}, not {value!r}")
        before, after = self._budgets[resource], _grained(value)
        if after == before:
            return False
        self._budgets[resource] = after
        text = f"{resource} may now use {after:g} instead of {before:g}: {reason}"
        self._timeline.add("capacity", resource, text, {"before": before, "after": after, "reason": reason})
        return True

    def share(self, resource: str, share: float, reason: str) -> bool:
        """Leave ``share`` (0 to 1) of a budget, which stays set, for ``reason``; whether that is another amount than
        before. Raises ValueError for a resource that there is not, or another share."""
        self._known(resource)
        if not 0 <= share <= 1:
            raise ValueError(f"the share of {resource} must be from 0 to 1, not {share!r}")
        before = self._left(resource)
        self._shares[resource] = share
        after = self._left(resource)
        if after == before:
            return False
        text = f"{resource} may now use {after:g} of its {self._budgets[resource]:g}: {reason}"
        data = {"before": before, "after": after, "budget": self._budgets[resource], "reason": reason}
        self._timeline.add("capacity", resource, text, data)
        return True

    def _left(self, resource: str) -> float:
        return _grained(self._budgets[resource] * self._shares.get(resource, 1.0))

    def _known(self, resource: str) -> None:
        if resource not in self._budgets:
            raise ValueError(f"no resource {resource!r}; there are: {', '.join(self._budgets)}")


def _grained(value: float) -> float:
    return math.floor(value * GRAIN + 1e-6) / GRAIN
