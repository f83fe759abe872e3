"""Where the playing of a recording is, and at which speeds it may go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Phase = Literal["playing", "paused", "ended", "seeking"]

#: Times real time.
SLOWEST = 0.1
FASTEST = 20.0


@dataclass(frozen=True, slots=True)
class PlaybackState:
    """Where playback is. ``position``, ``begin`` and ``end``: robot's clock (s); ``speed`` None: as fast as possible.

    ``playing``: time goes on now or will after the seek under way. ``problem``: what cannot be read here, in words, why
    it stands; "" where all is well.
    """

    position: float
    begin: float
    end: float
    speed: float | None
    playing: bool
    phase: Phase
    problem: str = ""


def checked_speed(speed: float | None) -> float | None:
    """``speed`` if it may be. Raises ValueError saying what is allowed."""
    if speed is not None and not SLOWEST <= speed <= FASTEST:
        raise ValueError(f"a speed is from {SLOWEST:g} to {FASTEST:g}, or none for as fast as possible, not {speed!r}")
    return speed
