"""Landmarks as they are kept, and sightings of them as they come."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.messages import Keyframes
from app.modules.perception.landmarks.sightings import FloatArray, Sightings

#: Anchors that are no keyframes: the map itself, and odometry's origin.
MAP, ODOM = -2, -1
#: Sightings from which a landmark counts as found, not glimpsed.
CONFIRMED = 3
#: States of the localization in which a sighting is placed on the map.
LOCALIZED = ("mapping", "tracking")


@dataclass(frozen=True, slots=True)
class LandmarkSettings:
    """``shared_m``, ``shared_rad``: error that all sightings of a keyframe share, and least sigma of a landmark.
    ``gate_sigma_m``: error of the map against itself, in the gate. ``gate_m``: in ``odom``, sightings nearer than this
    are of one landmark. ``drift_per_m`` and ``turn_per_m``: sigma of odometry's place (m) and direction (rad) for each
    metre driven without a localization. ``map_drift_per_m``, at most ``map_drift_m``: sigma between places of a growing
    map for each metre driven between them."""

    shared_m: float = 0.02
    shared_rad: float = 0.03
    gate_sigma_m: float = 0.05
    gate_m: float = 1.0
    drift_per_m: float = 0.02
    turn_per_m: float = 0.01
    map_drift_per_m: float = 0.01
    map_drift_m: float = 0.25


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """One sighting from the robot: ``p_BQ`` (3,) m in ``base_link`` with ``sigma_m`` along each axis, and the direction
    of the normal there (rad), if known."""

    p_BQ: FloatArray
    sigma_m: float
    heading: float | None = None
    heading_sigma: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Anchored:
    """A landmark as it is kept. ``seen`` counts its sightings; ``driven_m`` is the odometer at the last one, ``here``
    whether that was on this visit. ``misses``: looks in a row that should have shown it and did not, since ``missed``
    (s)."""

    id: int
    text: str
    sightings: Sightings
    seen: int
    first_seen: float
    last_seen: float
    driven_m: float = 0.0
    here: bool = True
    misses: int = 0
    missed: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class LandmarkState:
    """All that a map of landmarks knows, for a next instance."""

    known: tuple[Anchored, ...]
    made: int
    ids: NDArray[np.int64]
    X_FA: FloatArray
    travelled: FloatArray
    on_map: bool
    keyframes: Keyframes | None
    driven_m: tuple[float, float]
