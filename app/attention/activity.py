"""Activity: which perceptions do what attention selected them for. Pure.

No arbiter reports on a perception. What its strategy opens counts instead: an input is active while messages are taken
by it, an output that leads to no arbiter while something is published. So a selected perception whose source is silent,
or whose module does not work, is not exploited.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Final

from app.attention.exploitation import ExploitationChange
from app.attention.strategies import CLOSED, Strategy

PATIENCE_S: Final = 2.5
"""Without a message for so long (s), or for ``PERIODS`` periods of its source, a filter is active no more."""
PERIODS: Final = 3.0
GROUP: Final = "perception"
"""The group of changes that activity shows; those of arbiters have theirs."""


def watched(strategies: Iterable[Strategy], arbitrated: Collection[str]) -> dict[str, frozenset[str]]:
    """Open filters by class, of the chosen ``strategies`` that open none of the ``arbitrated`` outputs."""
    found: dict[str, frozenset[str]] = {}
    for strategy in strategies:
        names = frozenset(name for name, divisor in strategy.filters.items() if divisor != CLOSED)
        if names and not names & frozenset(arbitrated):
            found[strategy.cls] = found.get(strategy.cls, frozenset()) | names
    return found


class ActivityMonitor:
    """The classes of perceptions that are exploited now, from counters that only grow."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}
        self._seen: dict[str, float] = {}
        self._modules: dict[str, str] = {}
        self._classes: frozenset[str] = frozenset()

    @property
    def classes(self) -> frozenset[str]:
        """Desire classes whose perceptions work now."""
        return self._classes

    def sample(
        self,
        now: float,
        filters: Mapping[str, frozenset[str]],
        counts: Mapping[str, int],
        periods_s: Mapping[str, float],
    ) -> tuple[tuple[ExploitationChange, str], ...]:
        """What changed by ``now`` (s, robot's clock), with the class.

        ``filters`` as of :func:`watched`; ``counts``: messages taken or published so far by each of them;
        ``periods_s``: time between two messages that its filter lets through, where that is known.
        """
        for name, count in counts.items():
            if count > self._counts.get(name, count):
                self._seen[name] = now
        self._counts = dict(counts)
        active = {
            cls: next(iter(sorted(names & self._active(now, names, periods_s))), "") for cls, names in filters.items()
        }
        after = frozenset(cls for cls, name in active.items() if name)
        changes = [
            (ExploitationChange(now, GROUP, self._modules.pop(cls), exploited=False), cls)
            for cls in sorted(self._classes - after)
        ]
        for cls in sorted(after - self._classes):
            self._modules[cls] = active[cls].partition(".")[0]
            changes.append((ExploitationChange(now, GROUP, self._modules[cls], exploited=True), cls))
        self._classes = after
        return tuple(changes)

    def clear(self) -> None:
        """Time has jumped: nothing is known."""
        self._counts.clear()
        self._seen.clear()
        self._modules.clear()
        self._classes = frozenset()

    def _active(self, now: float, names: Iterable[str], periods_s: Mapping[str, float]) -> frozenset[str]:
        return frozenset(
            name
            for name in names
            if name in self._seen and now - self._seen[name] <= max(PATIENCE_S, PERIODS * periods_s.get(name, 0.0))
        )
