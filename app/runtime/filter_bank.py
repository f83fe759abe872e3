"""Every rate filter of a graph by name: attention rewrites them together, tests and replays pin single ones."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from app.base.yaml_source import likeliest
from app.runtime.filter import CLOSED, RateFilter, check_divisor
from app.runtime.subscription import Subscription


@dataclass(frozen=True, slots=True)
class Pin:
    """A filter fixed at φ = ``divisor`` against attention; it skips the first ``offset`` messages."""

    divisor: float
    offset: int = 0


class FilterBank:
    """Every rate filter of the graph by ``Module.port``; rewrites any number of them in one step of the loop."""

    def __init__(self) -> None:
        self._filters: dict[str, RateFilter] = {}
        #: Offsets by name of the pinned ones.
        self._pinned: dict[str, int] = {}
        #: Offsets by name of those that wait for their first opening.
        self._delayed: dict[str, int] = {}
        self._undivided: set[str] = set()
        #: By module the names of its filters that attention controls, and the inputs that rest while these are closed.
        self._attended: dict[str, set[str]] = {}
        self._resting: dict[str, tuple[Subscription[Any], ...]] = {}

    def add(self, name: str, rate_filter: RateFilter, *, decimable: bool = True) -> None:
        """Register a filter; one that is not ``decimable`` may only be open or closed."""
        self._filters[name] = rate_filter
        if not decimable:
            self._undivided.add(name)

    def names(self) -> Collection[str]:
        return self._filters.keys()

    def divisors(self) -> dict[str, float]:
        return {name: f.divisor for name, f in self._filters.items()}

    def pin(self, name: str, pin: Pin) -> None:
        """Fix the filter ``name``: from now on :meth:`apply` does not change it.

        Raises KeyError for a filter that does not exist, ValueError for an invalid φ or offset.
        """
        if pin.offset < 0:
            raise ValueError(f"an offset is a number of messages from 0, not {pin.offset}")
        if name in self._undivided and check_divisor(pin.divisor) not in (1, CLOSED):
            raise ValueError(f"the channel of {name} may not be decimated: 1 or off, not {pin.divisor:g}")
        self._pinned.pop(name, None)
        self.apply({name: pin.divisor})
        self._filters[name].begin(pin.offset)
        self._pinned[name] = pin.offset

    def unpin(self, name: str, divisor: float) -> None:
        """Give a pinned filter back to :meth:`apply`, at φ = ``divisor``; one that is not pinned stays as it is."""
        if name in self._pinned:
            del self._pinned[name]
            self.apply({name: divisor})

    def undivided(self) -> Collection[str]:
        """The filters that may only be open or closed."""
        return frozenset(self._undivided)

    def pinned(self) -> Collection[str]:
        return self._pinned.keys()

    def reset(self) -> None:
        """Reset the phases of open filters: the next message passes, at a pinned filter after its offset."""
        for name, rate_filter in self._filters.items():
            rate_filter.begin(self._pinned.get(name, 0))

    def delay(self, offset: int) -> None:
        """Skip ``offset`` messages at every filter that is closed now, once, when it first opens.

        A calibration tries each phase of a decimation so. Raises ValueError for an invalid offset.
        """
        if offset < 0:
            raise ValueError(f"an offset is a number of messages from 0, not {offset}")
        closed = (name for name, rate_filter in self._filters.items() if not rate_filter.is_open)
        self._delayed = {name: offset for name in closed if offset and name not in self._pinned}

    def apply(self, divisors: Mapping[str, float]) -> dict[str, tuple[float, float]]:
        """Set the φ named, those that open (or speed up) first, and return what changed: name -> (before, after).

        Pinned filters stay as they are. Raises KeyError for a filter that does not exist and ValueError for a φ that
        cannot be, changing nothing.
        """
        filters, pinned, delayed = self._filters, self._pinned, self._delayed
        changes: dict[str, tuple[float, float]] = {}
        checked: set[float] = set()
        opening: list[tuple[str, RateFilter, float]] = []
        closing: list[tuple[str, RateFilter, float]] = []
        for name, divisor in divisors.items():
            rate_filter = filters.get(name)
            if rate_filter is None:
                module = f"{name.partition('.')[0]}."
                beside = [known for known in filters if known.startswith(module)]
                raise KeyError(unknown("filter", name, beside or filters))
            before = rate_filter.phi
            if divisor not in checked:
                checked.add(check_divisor(divisor))
            if divisor != before and name not in pinned:
                changes[name] = (before, divisor)
                (closing if divisor > before else opening).append((name, rate_filter, divisor))
        for some in (opening, closing):
            for name, rate_filter, after in some:
                rate_filter.change(after)
                if delayed and after != CLOSED and name in delayed:
                    rate_filter.begin(delayed.pop(name))
        if self._resting:
            for module in {name.partition(".")[0] for name in changes}:
                self._rest(module)
        return changes

    def attend(self, names: Collection[str], subscriptions: Mapping[str, Collection[Subscription[Any]]]) -> None:
        """Let ``subscriptions``, by module, rest while all filters ``names`` of that module are closed."""
        for name in names:
            self._attended.setdefault(name.partition(".")[0], set()).add(name)
        for module in self._attended:
            self._resting[module] = tuple(subscriptions.get(module, ()))
            self._rest(module)

    def _rest(self, module: str) -> None:
        if subscriptions := self._resting.get(module):
            closed = not any(self._filters[name].is_open for name in self._attended[module])
            for subscription in subscriptions:
                subscription.rest(closed)


def unknown(kind: str, name: str, known: Collection[str]) -> str:
    return f"no {kind} {name!r}; {likeliest(name, known)}there are: {', '.join(sorted(known)) or 'none'}"
