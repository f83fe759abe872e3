"""Repeated sightings of QR codes merged into landmarks: a recursive weighted mean, without any event loop.

Each sighting has its own variance R: by depth, at range r, R = (σ₀ + k r²)² (the depth's error grows with the square of
the range); by the laser, that of ``laser_ray``. With the landmark's variance P, each sighting moves it by the share P /
(P + R), which is the mean of all sightings weighted by 1 / R. P never falls below a floor: sightings share the drift of
the odometry, so a thousand of them are not a thousand independent ones, and a landmark must stay able to follow.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from app.messages import Landmark

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class SightingModel:
    """σ = ``floor_m`` + ``per_m2`` · r² of one sighting by depth; a landmark's own σ never falls below ``floor_m``."""

    floor_m: float = 0.02
    per_m2: float = 0.01

    def sigma_m(self, range_m: float) -> float:
        """Standard deviation of a sighting at ``range_m``."""
        return self.floor_m + self.per_m2 * range_m**2


class LandmarkMap:
    """The known landmarks, in the order of first sight.

    The same text may be in several places: a sighting further than ``gate_m`` from every landmark of its text (or than
    three standard deviations, if that is more) makes a new one.
    """

    def __init__(
        self, model: SightingModel | None = None, gate_m: float = 1.0, landmarks: Iterable[Landmark] = ()
    ) -> None:
        self._model = model or SightingModel()
        self._gate_m = gate_m
        self._landmarks = list(landmarks)

    @property
    def landmarks(self) -> tuple[Landmark, ...]:
        return tuple(self._landmarks)

    def see(self, stamp: float, text: str, p_OQ: Point, range_m: float) -> Landmark:
        """Take one sighting by depth at ``p_OQ`` (m, in odom) from ``range_m`` away: :meth:`take` with its σ."""
        return self.take(stamp, text, p_OQ, self._model.sigma_m(range_m))

    def take(self, stamp: float, text: str, p_OQ: Point, sigma_m: float) -> Landmark:
        """Take one sighting at ``p_OQ`` (m, in odom) with ``sigma_m`` (> 0); returns the landmark it made or moved."""
        sigma_m = max(self._model.floor_m, sigma_m)
        index = self._nearest(text, p_OQ, sigma_m)
        if index is None:
            landmark = Landmark(text, p_OQ, sigma_m=sigma_m, sightings=1, first_seen=stamp, last_seen=stamp)
            self._landmarks.append(landmark)
        else:
            landmark = merged(self._landmarks[index], stamp, p_OQ, sigma_m, self._model.floor_m)
            self._landmarks[index] = landmark
        return landmark

    def _nearest(self, text: str, p_OQ: Point, sigma_m: float) -> int | None:
        best: tuple[float, int] | None = None
        for index, landmark in enumerate(self._landmarks):
            if landmark.text != text:
                continue
            distance = math.dist(landmark.p_FQ, p_OQ)
            if distance <= max(self._gate_m, 3.0 * (sigma_m + landmark.sigma_m)):
                best = min(best, (distance, index)) if best is not None else (distance, index)
        return None if best is None else best[1]


def merged(landmark: Landmark, stamp: float, p_OQ: Point, sigma_m: float, floor_m: float) -> Landmark:
    """``landmark`` after one more sighting at ``p_OQ`` with standard deviation ``sigma_m`` (> 0)."""
    P, R = landmark.sigma_m**2, sigma_m**2
    share = P / (P + R)
    x, y, z = (a + share * (b - a) for a, b in zip(landmark.p_FQ, p_OQ, strict=True))
    return replace(
        landmark,
        p_FQ=(x, y, z),
        sigma_m=max(floor_m, math.sqrt((1.0 - share) * P)),
        sightings=landmark.sightings + 1,
        first_seen=min(landmark.first_seen, stamp),
        last_seen=max(landmark.last_seen, stamp),
    )
