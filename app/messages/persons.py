"""Messages of persons, bound from faces, voices and legs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from app.messages.percepts import POINT

PersonState = Literal["tentative", "confirmed", "unsure", "lost"]


@dataclass(frozen=True, slots=True, eq=False)
class TorsoColors:
    """Colours of what people wear in one image: below faces, and above legs where no face is seen.

    ``stamp`` and ``frame`` are those of the image. Each row of ``histograms`` (N, B) float32 has the sum 1; the first
    belong to ``tracks`` of ``Faces`` of the same image, the others to ``persons``, tracks of ``Persons``. Never
    recorded.
    """

    stamp: float
    frame: str
    tracks: tuple[int, ...]
    histograms: NDArray[np.float32]
    persons: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Person:
    """A person, by all that is perceived of them.

    ``track`` is the number of one uninterrupted perception and ``person`` the identity, which is kept over
    interruptions: None while ``tentative`` (not yet believed to be a person) and while ``unsure`` (a person, but one of
    several known ones, or a new one). A person ``lost`` was not perceived for a second, and is predicted. No number is
    used again.

    ``p_OP`` (m, in ``odom``) is the middle of the face, its height that of people in general where none was seen;
    ``v_O`` (m/s) the velocity over ground, ``covariance`` (2, 2) float64 m² of the place over ground. ``face`` and
    ``voice`` are the tracks of what is bound to the person now, None without; ``legs`` whether the laser sees them.
    ``speaking``: the voice sounds now. ``last_seen`` (s, robot's clock) by a camera or the laser.
    """

    track: int
    person: int | None
    state: PersonState
    p_OP: tuple[float, float, float]
    v_O: tuple[float, float]
    covariance: Annotated[NDArray[np.float64], Meta(extra_json_schema={"items": POINT})]
    face: int | None
    voice: int | None
    legs: bool
    speaking: bool
    last_seen: float


@dataclass(frozen=True, slots=True)
class Persons:
    """All persons at ``stamp``, in the order of their tracks."""

    stamp: float
    persons: tuple[Person, ...]
