"""A deadline for work that cannot look at the time itself."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class TimeIsUp(BaseException):
    """The deadline came. Not an Exception, since an ``except Exception`` in the work would catch it."""


@contextmanager
def until(deadline: float) -> Iterator[None]:
    """Raise TimeIsUp where the work inside still goes on at ``deadline`` (of ``time.perf_counter``).

    Only the main thread can be stopped so; in another the work ends when it ends.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(_number: int, _frame: FrameType | None) -> None:
        raise TimeIsUp

    handler = signal.signal(signal.SIGALRM, end)
    began = time.perf_counter()
    left, interval = signal.setitimer(signal.ITIMER_REAL, max(deadline - began, 1e-6))
    try:
        yield
    finally:
        # An alarm that was set before goes on.
        passed = time.perf_counter() - began
        signal.setitimer(signal.ITIMER_REAL, max(left - passed, 1e-6) if left else 0.0, interval)
        signal.signal(signal.SIGALRM, handler)
