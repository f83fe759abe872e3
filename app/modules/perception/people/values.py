"""What the tracker of persons is given, and its rules."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.modules.perception.people.identities import IdentityRules

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class FaceSeen:
    """A face: its track, and the place of its middle (3,) m in ``odom`` with covariance (3, 3) m²."""

    track: int
    p_OF: Vector
    covariance: Vector


@dataclass(frozen=True, slots=True)
class LegsSeen:
    """What may be the legs of a person: their place (2,) m in ``odom`` with covariance (2, 2) m².

    ``known``: the map has an obstacle there.
    """

    at: Vector
    covariance: Vector
    known: bool


@dataclass(frozen=True, slots=True)
class PersonRules:
    """Times in s, lengths in m."""

    identity: IdentityRules = field(default_factory=IdentityRules)
    #: A person not seen for so long is lost; what is not yet believed is forgotten.
    lost_s: float = 1.2
    forgotten_s: float = 0.8
    #: Faces, or the way walked, after which a person is believed.
    faces: int = 2
    walked_m: float = 0.5
    #: Legs whose direction a voice has for so long are a person's.
    voice_s: float = 0.8
    #: Time for colours to come before a person without any is identified, and for others to be found out after a
    #: mistake was.
    colors_s: float = 0.8
    #: ... while colours of anybody come: place alone is the weaker witness.
    colors_come_s: float = 2.5
    doubt_s: float = 4.0
    #: While colours of anybody came within so long, a person without any is not numbered as new.
    colored_s: float = 60.0
    #: Histograms before a person counts as new, or as another than thought.
    new_samples: int = 5
    other_samples: int = 6
    #: Legs at an obstacle of the map count for a person so long after any other sighting.
    known_s: float = 10.0
    #: Who is lost so near to somebody else may have been taken for them.
    crossing_m: float = 0.9
    confused_m: float = 0.6
    #: ... and keeps the identity so long (s) without a look at the own colours: a look or two may fail.
    grace_s: float = 0.7
    #: Legs so far from where they were expected may be another's.
    jump_m: float = 0.22
    #: Two in the same colours are two when those of both were seen within so long.
    both_s: float = 0.5
    #: Height of the middle of faces where none was seen.
    face_m: float = 1.57
    most: int = 60
