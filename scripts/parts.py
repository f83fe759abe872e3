"""How long the parts of a task take, for its last words. Standard library only."""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator
from contextlib import contextmanager


class Parts:
    """The seconds that each named part took, in the order in which they ended; parts may overlap, in threads too."""

    def __init__(self) -> None:
        self._took_s: dict[str, float] = {}

    @contextmanager
    def timed(self, name: str) -> Iterator[None]:
        """Time what is done within, whether or not it succeeds."""
        began = time.monotonic()
        try:
            yield
        finally:
            self.note(name, time.monotonic() - began)

    def note(self, name: str, seconds: float) -> None:
        """Add ``seconds`` to those of the part ``name``."""
        self._took_s[name] = self._took_s.get(name, 0.0) + seconds

    def __str__(self) -> str:
        return ", ".join(f"{name} {seconds:.0f} s" for name, seconds in self._took_s.items())


def processor_s() -> float:
    """Processor time (s) of all child processes that have ended, with their own."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
