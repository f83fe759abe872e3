"""The timeline: a bounded history of everything that happened to the robot's attention, with query by time."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

from app.base.observers import Observers
from app.messages import EventKind, TimelineEvent


@dataclass(frozen=True, slots=True)
class TimelineStatistics:
    """``events`` kept now, ``added`` since the start, ``forgotten`` for want of room."""

    events: int
    added: int
    forgotten: int


class Timeline:
    """The last ``capacity`` events; ``clock_now`` stamps those added without a stamp (None: every event brings its
    own)."""

    def __init__(self, capacity: int, clock_now: Callable[[], float] | None = None) -> None:
        if capacity < 1:
            raise ValueError(f"a timeline holds at least 1 event, not {capacity}")
        self._events: deque[TimelineEvent] = deque(maxlen=capacity)
        self._now = clock_now
        self._last = 0
        self._observers: Observers[[TimelineEvent]] = Observers("the timeline")

    def add(
        self,
        kind: EventKind,
        subject: str,
        text: str,
        data: Mapping[str, Any] | None = None,
        *,
        stamp: float | None = None,
    ) -> TimelineEvent:
        """Append an event (``stamp`` None: now) and notify the observers."""
        if stamp is None:
            if self._now is None:
                raise ValueError("a timeline without a clock needs each event's stamp")
            stamp = self._now()
        self._last += 1
        event = TimelineEvent(self._last, stamp, kind=kind, subject=subject, text=text, data=dict(data or {}))
        self._events.append(event)
        self._observers.notify(event)
        return event

    def query(
        self,
        since: float | None = None,
        until: float | None = None,
        kinds: Collection[str] | None = None,
        limit: int | None = None,
        *,
        after_id: int = 0,
    ) -> tuple[TimelineEvent, ...]:
        """The newest ``limit`` events with ``since`` <= stamp < ``until``, of these ``kinds``, of a greater id; oldest
        first."""
        found: list[TimelineEvent] = []
        for event in reversed(self._events):
            if event.id <= after_id or (limit is not None and len(found) >= limit):
                break
            if (
                (since is None or event.stamp >= since)
                and (until is None or event.stamp < until)
                and (kinds is None or event.kind in kinds)
            ):
                found.append(event)
        return tuple(reversed(found))

    def clear(self) -> None:
        """Remove every event; ids grow on, so that events added later are distinct from the former ones."""
        self._events.clear()

    def observe(self, callback: Callable[[TimelineEvent], None]) -> Callable[[], None]:
        """Call ``callback`` with every event from now on; returns a function that ends this."""
        return self._observers.add(callback)

    def statistics(self) -> TimelineStatistics:
        return TimelineStatistics(len(self._events), self._last, self._last - len(self._events))
