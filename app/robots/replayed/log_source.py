"""Read-ahead of a log, in pieces decoded before they are due."""

from __future__ import annotations

import math
from collections.abc import Collection, Generator, Mapping
from dataclasses import dataclass, field

from app.logs.log import Log, LogError, Logged
from app.logs.mcap.damage import LogDamaged
from app.logs.mcap.writer import weight

#: Greatest duration (s of the log), number of messages and memory of a piece; two pieces are held at a time.
PIECE_S = 0.25
PIECE_MESSAGES = 256
PIECE_BYTES = 32_000_000


@dataclass(frozen=True, slots=True)
class LogPosition:
    """A position between two messages of a log.

    Messages that arrived before ``at`` (s) have passed, and the first ``passed[channel]`` of those that arrived at
    ``at`` itself. ``since``: later start times of channels that had no demand before.
    """

    at: float
    passed: Mapping[str, int] = field(default_factory=dict)
    since: Mapping[str, float] = field(default_factory=dict)


class LogSource:
    """The messages of ``channels`` from ``place`` to ``end`` (s, inclusive), in pieces. Used in one thread."""

    def __init__(self, log: Log, channels: Collection[str], place: LogPosition, end: float) -> None:
        self._log = log
        self._channels = frozenset(channels)
        self._place = place
        self._end = end
        self._messages: Generator[Logged, None, None] | None = None
        self._next: Logged | None = None
        self._failure: LogError | None = None
        self._behind = -math.inf

    def piece(self) -> list[Logged]:
        """The next messages, in the order of the log; none at the end.

        Raises LogError where the file is damaged, after all messages before the damage. After LogDamaged, the next
        piece follows the damage.
        """
        try:
            return self._piece()
        except LogDamaged as damage:
            if damage.behind <= self._behind:
                raise LogError(str(damage)) from damage
            self._behind, self._messages = damage.behind, None
            raise

    def _piece(self) -> list[Logged]:
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure
        if self._messages is None:
            self._messages = self._read()
        piece: list[Logged] = []
        held = 0
        if self._next is not None:
            piece.append(self._next)
            held = weight(self._next.message)
            self._next = None
        try:
            for logged in self._messages:
                if piece and logged.at - piece[0].at > PIECE_S:
                    self._next = logged
                    break
                piece.append(logged)
                held += weight(logged.message)
                if len(piece) >= PIECE_MESSAGES or held >= PIECE_BYTES:
                    break
        except LogError as failure:
            if not piece:
                raise
            self._failure = failure
        return piece

    def close(self) -> None:
        """Release the log."""
        if self._messages is not None:
            self._messages.close()

    def _read(self) -> Generator[Logged, None, None]:
        if not self._channels:
            return
        place = self._place
        begin = max(place.at, min(place.since.get(channel, place.at) for channel in self._channels), self._behind)
        passed = dict(place.passed)
        for logged in self._log.messages(begin, self._channels):
            if logged.at > self._end:
                return
            if logged.at < max(place.at, place.since.get(logged.channel, place.at)):
                continue
            if logged.at == place.at and passed.get(logged.channel, 0) > 0:
                passed[logged.channel] -= 1
                continue
            yield logged
