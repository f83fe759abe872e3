"""The state of playback, and its range of speeds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Phase = Literal["playing", "paused", "ended", "seeking"]

#: Times real time.
SLOWEST = 0.1
FASTEST = 20.0


@dataclass(frozen=True, slots=True)
class PlaybackState:
    """The state of playback. ``position``, ``begin`` and ``end``: robot's clock (s); ``speed`` None: as fast as
    possible.

    ``playing``: time passes now, or will after the seek under way. ``problem``: the reason why playback paused at a
    damaged part, in words; "" otherwise.
    """

    position: float
    begin: float
    end: float
    speed: float | None
    playing: bool
    phase: Phase
    problem: str = ""


def checked_speed(speed: float | None) -> float | None:
    """``speed`` if it is valid. Raises ValueError saying what is allowed."""
    if speed is not None and not SLOWEST <= speed <= FASTEST:
        raise ValueError(f"a speed is from {SLOWEST:g} to {FASTEST:g}, or none for as fast as possible, not {speed!r}")
    return speed
