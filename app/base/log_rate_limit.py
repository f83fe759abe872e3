"""Rate limit for the log: repeated lines are written a few times, then counted, so that a log neither fills a disk nor
blocks the event loop.

Two lines are equal if the same statement logs the same words and values (and the same exception).
"""

from __future__ import annotations

import copy
import logging
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from typing import TextIO

#: Equal lines written per window, and the window's length (s); the others are counted and reported at its end.
FIRST = 5
WINDOW_S = 10.0
#: Number of different lines that are counted; beyond it the oldest is removed after its count is reported.
MOST_LINES = 256


@dataclass(slots=True)
class _Line:
    """One line in its window: the window's begin, the line's words, how many were written and how many were not."""

    since: float
    record: logging.LogRecord
    written: int
    held: int = 0


class RateLimitedHandler(logging.StreamHandler[TextIO]):
    """Writes to a stream; ``now`` gives seconds of any steady clock."""

    def __init__(self, stream: TextIO, *, now: Callable[[], float] = time.monotonic) -> None:
        super().__init__(stream)
        self._now = now
        self._lines: OrderedDict[int, _Line] = OrderedDict()
        self._timer: threading.Timer | None = None

    def emit(self, record: logging.LogRecord) -> None:
        key = _key(record)
        self._end_windows(self._now())
        line = self._lines.get(key)
        if line is None:
            self._lines[key] = _Line(self._now(), _bare(record), 1)
            if len(self._lines) > MOST_LINES:
                self._say(self._lines.popitem(last=False)[1])
        elif line.written < FIRST:
            line.written += 1
        else:
            line.held += 1
            self._await_end()
            return
        super().emit(record)

    def say_held(self) -> None:
        """Say how often what was held back came, where its window is over. Called by itself in time."""
        self.acquire()
        try:
            self._timer = None
            self._end_windows(self._now())
            if any(line.held for line in self._lines.values()):
                self._await_end()
        finally:
            self.release()

    def close(self) -> None:
        """Say what was held back, and end."""
        self.acquire()
        try:
            if self._timer is not None:
                self._timer.cancel()
            for line in self._lines.values():
                self._say(line)
            self._lines.clear()
        finally:
            self.release()
        super().close()

    def _end_windows(self, now: float) -> None:
        # In the order in which they began: those behind the first that goes on go on too.
        while self._lines:
            key, line = next(iter(self._lines.items()))
            if now - line.since < WINDOW_S:
                return
            del self._lines[key]
            if line.held:
                self._say(line)
                # It goes on, probably: nothing of it is written, only how often it came.
                self._lines[key] = _Line(now, line.record, FIRST)

    def _say(self, line: _Line) -> None:
        if not line.held:
            return
        record = copy.copy(line.record)
        times = "once more" if line.held == 1 else f"{line.held} times more"
        seconds = max(1, round(self._now() - line.since))
        record.msg = f"{line.record.msg} (repeated {times} in {seconds} s)"
        record.created = time.time()
        super().emit(record)

    def _await_end(self) -> None:
        if self._timer is None:
            self._timer = threading.Timer(WINDOW_S, self.say_held)
            self._timer.daemon = True
            self._timer.start()


def _key(record: logging.LogRecord) -> int:
    """A key that is equal for records of the same statement with the same content."""
    error = record.exc_info[1] if record.exc_info else None
    values = {name: str(value) for name, value in vars(record).items() if name not in _OF_ONE}
    return hash((record.getMessage(), type(error), str(error), *sorted(values.items())))


#: Attributes in which two records of a line differ, or which are in the message.
_OF_ONE = frozenset(
    {"args", "created", "msecs", "relativeCreated", "msg", "message", "exc_info", "exc_text", "asctime"}
    | {"thread", "threadName", "taskName"}
)


def _bare(record: logging.LogRecord) -> logging.LogRecord:
    """Its words alone: a traceback would keep all that its frames know of."""
    bare = copy.copy(record)
    bare.msg, bare.args = record.getMessage(), ()
    bare.exc_info = bare.exc_text = bare.stack_info = None
    return bare
