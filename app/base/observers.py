"""A list of observers: callbacks that one source calls with each of its events."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Generic, ParamSpec

P = ParamSpec("P")

log = logging.getLogger("hbba.observers")

#: So many failures in a row remove an observer: one event that it cannot take leaves it in place, but an observer of
#: log lines that always fails would otherwise cause the next line itself, without end.
MOST_FAILURES = 10


class Observers(Generic[P]):
    """The observers of one source; for use on one thread.

    One policy for all sources: the exception of an observer is logged with a traceback; the source and all observers go
    on. An observer that fails ``MOST_FAILURES`` times in a row is removed.
    """

    __slots__ = ("_callbacks", "_failures", "_of")

    def __init__(self, of: str) -> None:
        """``of``: the source and its event, for the log: ``"the timeline"``."""
        self._of = of
        self._callbacks: dict[object, Callable[P, object]] = {}
        self._failures: dict[object, int] = {}

    def __bool__(self) -> bool:
        return bool(self._callbacks)

    def add(self, callback: Callable[P, object]) -> Callable[[], None]:
        """Call ``callback`` at every event from now on, after the observers added before it.

        A callback added twice is called twice. Returns a function that removes the observer; it may be called twice.
        """
        key = object()
        self._callbacks[key] = callback

        def remove() -> None:
            self._callbacks.pop(key, None)
            self._failures.pop(key, None)

        return remove

    def notify(self, *args: P.args, **kwargs: P.kwargs) -> None:
        """Call every observer with the arguments of the event; never raises.

        An observer added meanwhile is called from the next event on; one removed meanwhile is not called any more.
        """
        for key, callback in tuple(self._callbacks.items()):
            if key not in self._callbacks:
                continue
            try:
                callback(*args, **kwargs)
            except Exception:
                # Counted before the log is written: a log line may itself be an event of this source.
                failures = self._failures[key] = self._failures.get(key, 0) + 1
                if failures >= MOST_FAILURES:
                    self._callbacks.pop(key, None)
                outcome = "is removed" if failures >= MOST_FAILURES else "goes on"
                log.exception("an observer of %s failed and %s: %r", self._of, outcome, callback)
            else:
                if self._failures:
                    self._failures.pop(key, None)

    def clear(self) -> None:
        """Remove all observers."""
        self._callbacks.clear()
        self._failures.clear()
