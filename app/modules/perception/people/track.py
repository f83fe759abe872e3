"""One track: what was perceived of a person without interruption, and how well a face or legs fit it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from app.messages import Person, PersonState, read_only
from app.modules.perception.people.identities import Colors, Histogram, Identity
from app.modules.perception.people.motion import GATE, NEVER, Motion
from app.modules.perception.people.torso_color import distance
from app.modules.perception.people.values import FaceSeen, LegsSeen, PersonRules

Vector = NDArray[np.float64]

#: Colours that agreed so long ago (s) hold an identity against another in the same colours.
AGREED_S = 1.5
#: A face and a track that were together keep together: a lower cost, and up to a distance (m) beyond the gate.
_TOGETHER, _TOGETHER_S, _TOGETHER_M = 8.0, 2.0, 1.2
#: Cost of a torso that has nothing in common with the track's.
_UNLIKE = 25.0
#: Histograms of a face's track and a person's before an unlike pair is refused, and from which distance on it is.
_COLORS, _UNLIKE_FROM = 3, 0.65
#: A person beside furniture is within such a distance (m), and slower than so (m/s).
_BESIDE_M, _STANDS_MPS = 0.3, 0.4
#: What was perceived so long ago (s) is perceived; who spoke so long ago speaks.
_RECENT_S, _SPOKEN_S = 0.7, 0.4


@dataclass(slots=True, eq=False)
class Track:
    """A person, or what may be one, in ``motion``; ``born`` (s) at ``origin`` (2,) m.

    ``number`` is not used again. Lists of histograms hold as many as count.
    """

    number: int
    motion: Motion
    born: float
    origin: Vector
    #: Last sighting; the last that was more than legs at an obstacle of the map; the last of legs, of a face.
    seen: float
    sure: float
    legs: float = -math.inf
    face: float = -math.inf
    face_track: int | None = None
    faces: dict[int, float] = field(default_factory=dict)
    faces_seen: int = 0
    sightings: int = 0
    #: When it was believed to be a person, None before.
    believed: float | None = None
    identity: Identity | None = None
    #: When colours agreed with its identity last, and whether the place is too doubtful for giving one.
    agreed: float = -math.inf
    #: When colours were quite others' than its identity's last, and how many looks have been so since any was not.
    against: float = -math.inf
    strange: int = 0
    doubtful: bool = False
    #: When it was last so near to another that the laser may have confused them.
    mixed: float = -math.inf
    #: When it got its number, if another than at first.
    numbered: float = -math.inf
    not_new_before: float = -math.inf
    colors: Colors = field(default_factory=lambda: Colors(40))
    recent: Colors = field(default_factory=lambda: Colors(6))
    torso: float = -math.inf
    z: float | None = None
    voice: int | None = None
    spoke: float = -math.inf

    def note_face(self, stamp: float, face: FaceSeen) -> None:
        """Note that ``face`` is this person's."""
        self.seen = self.sure = self.face = max(stamp, self.seen)
        self.face_track = face.track
        self.faces = {f: at for f, at in self.faces.items() if stamp - at < _TOGETHER_S} | {face.track: stamp}
        self.faces_seen += 1
        self.sightings += 1
        z, sigma2 = float(face.p_OF[2]), float(face.covariance[2, 2]) + 0.02**2
        self.z = z if self.z is None else self.z + 0.02 / (0.02 + sigma2) * (z - self.z)

    def face_cost(self, cost: float, face: FaceSeen, stamp: float, worn: Colors | None) -> float:
        """Cost of ``face`` being this person's: ``cost`` by its place, changed by colours ``worn`` below it."""
        if stamp - self.faces.get(face.track, -math.inf) < _TOGETHER_S:
            if cost >= NEVER and math.dist(face.p_OF[:2], self.motion.at) < _TOGETHER_M:
                cost = GATE
            cost -= _TOGETHER if cost < NEVER else 0.0
        far = None if worn is None else worn.distance(self.recent, 1)
        if cost < NEVER and worn is not None and far is not None:
            if far >= _UNLIKE_FROM and min(worn.samples, self.recent.samples) >= _COLORS:
                return NEVER
            cost += _UNLIKE * far**2
        return cost

    def legs_cost(self, cost: float, leg: LegsSeen, furniture: bool, unsure_s: float) -> float:
        """Cost of ``leg`` being this person's: ``cost`` by its place.

        ``unsure_s``: for how long nothing but ``furniture`` may be all that was seen of the person.
        """
        if cost >= NEVER:
            return NEVER
        if self.believed is None:
            return NEVER if leg.known else cost
        if furniture:
            # Who stands beside a chair stays; who walks past does not become one.
            stands = math.dist(leg.at, self.motion.at) < _BESIDE_M and self.motion.speed < _STANDS_MPS
            return cost if stands and self.motion.stamp - self.sure <= unsure_s else NEVER
        return cost - _TOGETHER

    def wear(self, stamp: float, histogram: Histogram, rules: PersonRules) -> None:
        """Take the colours (BINS,) of one look at the torso, and note whether they are those of the identity."""
        same, different = rules.identity.same, rules.identity.different
        if (
            self.identity is None
            and self.colors.mean is not None
            and distance(histogram, self.colors.mean) >= different
        ):
            # The mean of what two persons wear is worn by nobody.
            self.colors, self.recent = Colors(40), Colors(6)
        self.recent.add(histogram)
        self.torso = stamp
        # Who passes before a person does not change what the person wears.
        worn = self.colors if self.identity is None else self.identity.colors
        far = self.recent.distance(worn, rules.identity.samples)
        # The mean lags behind one who has just been confused with another.
        this = None if worn.mean is None else distance(histogram, worn.mean)
        if this is not None and this >= different:
            self.against, self.strange = stamp, self.strange + 1
        elif this is not None:
            self.strange = 0
        if far is not None and this is not None and max(far, this) < same:
            self.agreed = stamp
            if self.identity is not None:
                # What is worn as the person wears it is no furniture.
                self.sure = max(stamp, self.sure)
        if far is None or far < same:
            worn.add(histogram)
        elif self.identity is None and self.recent.samples >= rules.other_samples:
            self.colors, self.recent = Colors(40), Colors(6)

    def forget_identity(self) -> None:
        """Be unsure, until colours that are seen from now on identify: the last ones may be of both."""
        self.identity, self.doubtful, self.against, self.strange = None, True, -math.inf, 0
        self.colors, self.recent = Colors(40), Colors(6)

    def person(self, stamp: float, lost: bool, rules: PersonRules) -> Person:
        """The track as a message."""
        x, y, vx, vy = self.motion.x.tolist()
        state: PersonState = "confirmed"
        if self.believed is None:
            state = "tentative"
        elif self.identity is None:
            state = "unsure"
        elif lost:
            state = "lost"
        speaking = stamp - self.spoke <= _SPOKEN_S
        return Person(
            self.number,
            None if self.identity is None else self.identity.number,
            state,
            p_OP=(x, y, rules.face_m if self.z is None else self.z),
            v_O=(vx, vy),
            covariance=read_only(self.motion.P[:2, :2].copy()),
            face=self.face_track if stamp - self.face <= rules.lost_s else None,
            voice=self.voice if speaking else None,
            legs=stamp - self.legs <= rules.lost_s,
            speaking=speaking,
            last_seen=self.seen,
        )


def perceived_apart(a: Track, b: Track, stamp: float) -> bool:
    """Whether two tracks have faces, or legs, each of its own."""
    return (stamp - a.face < _RECENT_S and stamp - b.face < _RECENT_S) or (
        stamp - a.legs < _RECENT_S and stamp - b.legs < _RECENT_S
    )


def seen_in_images(track: Track, stamp: float) -> bool:
    """Whether the face of ``track`` was seen a moment ago."""
    return stamp - track.face <= _RECENT_S
