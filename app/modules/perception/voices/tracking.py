"""Who is who among the directions that sound comes from: tracks, from birth to death."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.voices.localization import Peaks


@dataclass(frozen=True, slots=True)
class TrackerSettings:
    """When tracks are born and die. ``tracks``: most at a time."""

    tracks: int = 4
    birth_power: float = 0.06
    keep_power: float = 0.035
    gate_deg: float = 12.0
    birth_sightings: int = 5
    silence_s: float = 1.5
    active_s: float = 0.15


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A source of sound followed over time.

    ``id`` is its number, from 1, never used again. ``direction`` (3,) float64 unit vector, ``velocity`` (3,) rad/s on
    the sphere (at right angles to it), in the axes the peaks were given in. ``power`` in [0, 1] of its last sighting.
    ``active``: heard just now; ``born`` and ``last_seen``: s.
    """

    id: int
    direction: NDArray[np.float64]
    velocity: NDArray[np.float64]
    power: float
    active: bool
    born: float
    last_seen: float


class Tracker:
    """Follows sources; knows no clock but the times it is given."""

    def __init__(self, settings: TrackerSettings = TrackerSettings()) -> None:
        self.settings = settings
        self._tracks: list[Track] = []
        self._next = 1
        self._seen: list[tuple[NDArray[np.float64], int, float]] = []

    def rotate(self, rotation: NDArray[np.float64]) -> None:
        """Turn all that is known by ``rotation`` (3, 3), R_new_old: the axes themselves have turned."""
        self._tracks = [
            Track(t.id, rotation @ t.direction, rotation @ t.velocity, t.power, t.active, t.born, t.last_seen)
            for t in self._tracks
        ]
        self._seen = [(rotation @ direction, count, last) for direction, count, last in self._seen]

    def update(self, time_s: float, peaks: Peaks) -> tuple[Track, ...]:
        """Take the peaks of ``time_s`` (s, never going back); the tracks as they stand, oldest first."""
        settings = self.settings
        free = list(range(len(peaks.powers)))
        kept = []
        for track in self._tracks:
            near = [
                k
                for k in free
                if peaks.powers[k] > settings.keep_power
                and peaks.directions[k] @ track.direction > np.cos(np.radians(settings.gate_deg))
            ]
            if near:
                best = max(near, key=lambda k: float(peaks.powers[k]))
                free.remove(best)
                direction = 0.8 * track.direction + 0.2 * peaks.directions[best]
                direction /= np.linalg.norm(direction)
                power = float(peaks.powers[best])
                kept.append(Track(track.id, direction, np.zeros(3), power, True, track.born, time_s))
            elif time_s - track.last_seen < settings.silence_s:
                active = time_s - track.last_seen < settings.active_s
                kept.append(
                    Track(track.id, track.direction, track.velocity, track.power, active, track.born, track.last_seen)
                )
        self._tracks = kept
        self._seen = [entry for entry in self._seen if time_s - entry[2] < 0.25]
        for k in free:
            direction, power = peaks.directions[k], float(peaks.powers[k])
            if power < settings.birth_power or len(self._tracks) >= settings.tracks:
                continue
            if any(direction @ track.direction > np.cos(np.radians(20)) for track in self._tracks):
                continue
            count = 1
            for index, entry in enumerate(self._seen):
                if direction @ entry[0] > np.cos(np.radians(10)):
                    count = entry[1] + 1
                    del self._seen[index]
                    break
            if count >= settings.birth_sightings:
                self._tracks.append(Track(self._next, direction, np.zeros(3), power, True, time_s, time_s))
                self._next += 1
            else:
                self._seen.append((direction, count, time_s))
        return tuple(self._tracks)
