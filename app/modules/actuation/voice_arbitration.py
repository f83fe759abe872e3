"""Arbitration of the robot's voice: of those who speak, the one of highest priority is heard. Frames and times in,
no clock."""

from __future__ import annotations

import math
from collections.abc import Sequence

from app.modules.actuation.arbitration import Contender


class VoiceArbiter:
    """``contenders`` for the voice, each of which speaks until ``pause_s`` after its last frame."""

    def __init__(self, contenders: Sequence[Contender], pause_s: float) -> None:
        self._contenders = tuple(contenders)
        self._pause_s = pause_s
        self._last = {contender.input: -math.inf for contender in contenders}

    def admit(self, port: str, now: float) -> bool:
        """Whether the frame that has come in by ``port`` at ``now`` is to be played."""
        self._last[port] = now
        winner = self._winner(now)
        return winner is not None and winner.input == port

    def speaker(self, now: float) -> str | None:
        """The behavior that is heard at ``now``; None in silence. Among equal priorities the first listed wins."""
        winner = self._winner(now)
        return None if winner is None else winner.behavior

    def _winner(self, now: float) -> Contender | None:
        speaking = [c for c in self._contenders if now - self._last[c.input] <= self._pause_s]
        return max(speaking, key=lambda contender: contender.priority, default=None)
