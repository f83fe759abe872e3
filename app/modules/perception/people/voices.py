"""Binding of voices to persons by direction: a voice has none but its direction, and several may stand there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.base.geometry import wrap_angle

#: Greatest angle (rad) between a voice and its person, and how much farther off the next person must be.
GATE_RAD, APART_RAD = math.radians(8), math.radians(5)
#: A voice stays with its person while no other is nearer to it by this (rad).
_STAYS_RAD = math.radians(3)


@dataclass(frozen=True, slots=True)
class VoiceHeard:
    """A voice that sounds: its track, and its ``azimuth`` (rad, in ``odom``) from the microphones."""

    track: int
    azimuth: float


def bound(
    voices: Sequence[VoiceHeard],
    p_OA: NDArray[np.float64],
    people: Mapping[int, NDArray[np.float64]],
    before: Mapping[int, int],
) -> dict[int, int]:
    """Persons by the tracks of ``voices`` heard at ``p_OA`` (2,) m; a voice that may be of several is left out.

    ``people``: places (2,) m by number; ``before``: the persons whose the voices were.
    """
    found = {}
    for voice in voices:
        off = sorted(
            (abs(wrap_angle(math.atan2(at[1] - p_OA[1], at[0] - p_OA[0]) - voice.azimuth)), number)
            for number, at in people.items()
        )
        if not off or off[0][0] > GATE_RAD:
            continue
        held = next((angle for angle, number in off if number == before.get(voice.track)), math.inf)
        if held <= min(GATE_RAD, off[0][0] + _STAYS_RAD):
            found[voice.track] = before[voice.track]
        elif len(off) == 1 or off[1][0] - off[0][0] >= APART_RAD:
            found[voice.track] = off[0][1]
    return found
