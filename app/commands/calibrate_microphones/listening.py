"""Claps as they are heard: found, counted, and said where from."""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from app.commands.calibrate_microphones.sound_inputs import Sound
from app.modules.perception.voices.array_calibration.arrival_times import arrivals_of
from app.modules.perception.voices.array_calibration.calibration import AGREEING, longest_lag_s, rough_direction
from app.modules.perception.voices.array_calibration.claps import Clap, ClapDetector
from app.modules.perception.voices.microphone_array import MicrophoneArray

_AROUND = (
    "the front", "the front left", "the left", "behind on the left", "behind", "behind on the right", "the right",
    "the front right",
)  # fmt: skip
_SIDES = ("the front", "the left", "behind", "the right")
#: A clap is high or low from here on (deg of elevation).
_HIGH_DEG, _LOW_DEG = 20.0, -8.0
#: An elevation below this (deg) is not worth a word.
_LEVEL_DEG = 10.0


def claps_in(sound: Sound, array: MicrophoneArray, wanted: int) -> list[Clap]:
    """The claps in ``sound``: all of a recording, the ``wanted`` first ones of a sound card.

    At a sound card, standard error says of each where it came from and what is missing; Ctrl-C ends the listening, and
    those heard so far are returned.
    """
    detector = ClapDetector(sound.rate, len(array))
    claps: list[Clap] = []
    heard: list[NDArray[np.float64]] = []
    if sound.live:
        _say(f"Clap {wanted} times, {_how(array)}. Ctrl-C ends it with those heard so far.")
    try:
        for block, lost in sound.blocks:
            if lost:
                detector.restart(lost)
            for clap in detector.process(block):
                if not sound.live:
                    claps.append(clap)
                    continue
                arrivals = arrivals_of(clap, longest_lag_s(array))
                if np.median(arrivals.agreement) < AGREEING:
                    _say("a sound that is no clear clap: louder, nearer, one at a time")
                    continue
                claps.append(clap)
                heard.append(rough_direction(arrivals, array))
                _say(
                    said(len(claps), wanted, heard, array.dimensions) + (", too loud: clipped" if clap.clipped else "")
                )
            if sound.live and len(claps) >= wanted:
                break
    except KeyboardInterrupt:
        if not claps:
            raise
    return claps


def said(count: int, wanted: int, heard: Sequence[NDArray[np.float64]], dimensions: int) -> str:
    """The line about clap ``count`` of ``wanted``, the last of the directions ``heard`` (each (3,))."""
    left = f"{wanted - count} more" if count < wanted else "that is all"
    missing = missing_sides(heard, dimensions)
    nothing = f"; nothing yet from {_listed(missing)}" if missing and count < wanted else ""
    return f"clap {count}: from {where(heard[-1])}; {left}{nothing}"


def where(direction: NDArray[np.float64]) -> str:
    """A direction (3,) in words: ``the front left, 30° up``."""
    azimuth = math.degrees(math.atan2(direction[1], direction[0]))
    elevation = math.degrees(math.asin(max(-1.0, min(1.0, float(direction[2])))))
    if abs(elevation) > 70:
        return "above" if elevation > 0 else "below"
    side = _AROUND[round(azimuth / 45) % 8]
    height = f", {10 * round(abs(elevation) / 10):.0f}° {'up' if elevation > 0 else 'down'}"
    return side + (height if abs(elevation) >= _LEVEL_DEG else "")


def missing_sides(heard: Sequence[NDArray[np.float64]], dimensions: int) -> list[str]:
    """The sides from which nothing was ``heard`` (directions (3,)), as far as the array distinguishes them."""
    if dimensions == 1:
        return []
    directions = np.array(heard)
    azimuths = np.degrees(np.arctan2(directions[:, 1], directions[:, 0]))
    elevations = np.degrees(np.arcsin(np.clip(directions[:, 2], -1, 1)))
    level = np.abs(elevations) < 70
    missing = [
        side
        for number, side in enumerate(_SIDES)
        if not (level & (np.abs((azimuths - 90 * number + 180) % 360 - 180) <= 50)).any()
    ]
    if dimensions == 3:
        missing += ["above"] if elevations.max() < _HIGH_DEG else []
        missing += ["below"] if elevations.min() > _LOW_DEG else []
    return missing


def _how(array: MicrophoneArray) -> str:
    if array.dimensions == 3:
        return "1 to 2 m from the array, each time from another side, some above its height and some below"
    return "1 to 2 m from the array and at its height, each time from another side"


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
