"""Damage in the middle of a log: the missing part, and reading on after it."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator

from app.logs.log import Log, LogError, Logged, LogInfo


class LogDamaged(LogError):
    """Messages that arrived from ``begin`` to ``end`` (robot's clock, s, inclusive) cannot be read; later ones may
    be."""

    def __init__(self, message: str, begin: float, end: float) -> None:
        super().__init__(message)
        self.begin = begin
        self.end = end

    @property
    def behind(self) -> float:
        """The first time (s) after the damage, from which reading can go on."""
        return math.nextafter(self.end, math.inf)


def missing(damage: LogDamaged, info: LogInfo) -> str:
    """The damaged part of the log in words: ``0.1 s from 0:07.5 cannot be read``."""
    since = place(damage.begin - info.begin)
    if damage.end >= info.end:
        return f"nothing from {since} on can be read"
    return f"{_length(damage.end - damage.begin)} from {since} cannot be read"


def place(seconds: float) -> str:
    """A place in a log, ``seconds`` from its begin: ``0:07.5``, ``1:02:03.0``."""
    tenths = max(0, math.floor(10 * seconds + 1e-6))
    minutes, tenths = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    return f"{f'{hours}:{minutes:02}' if hours else minutes}:{tenths / 10:04.1f}"


def skipping(
    log: Log, begin: float | None, channels: Collection[str] | None, damaged: Callable[[LogDamaged], None]
) -> Iterator[Logged]:
    """The messages of ``log``, continued after each damaged part, which is reported to a callback.

    Raises LogError if the log does not say where reading can go on.
    """
    while True:
        try:
            yield from log.messages(begin, channels)
            return
        except LogDamaged as damage:
            if begin is not None and damage.behind <= begin:
                raise
            begin = damage.behind
            damaged(damage)


def _length(seconds: float) -> str:
    return "less than 0.1 s" if seconds < 0.05 else f"{seconds:.1f} s"
