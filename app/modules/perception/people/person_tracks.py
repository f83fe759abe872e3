"""Tracks of persons: faces, legs and voices bound together, each with an identity that survives interruptions.

Faces and legs measure places and are assigned to the tracks of those seen a moment ago (``motion.py``). A track is
believed to be a person after two faces or half a metre walked: chairs have legs, too. Then it is identified
(``identities.py``). Voices have directions only, and are bound to persons there (``voices.py``).

The order of observations in a message changes nothing, no number is used again, and what is kept is bounded.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from app.messages import Person
from app.modules.perception.people.furniture import SPOT_M, Furniture
from app.modules.perception.people.identities import (
    Appearance,
    Colors,
    Histogram,
    Identity,
    Passable,
    identify,
    pruned,
)
from app.modules.perception.people.motion import Motion, assigned, costs
from app.modules.perception.people.track import AGREED_S, Track, perceived_apart, seen_in_images
from app.modules.perception.people.values import FaceSeen, LegsSeen, PersonRules
from app.modules.perception.people.voices import Candidate, VoiceHeard, Voices

Vector = NDArray[np.float64]


#: Two tracks nearer than this (m) are of one person, unless both have faces.
_ONE_PERSON_M = 0.4
#: Floor of a face's standard deviation over ground (m), and of the share of its covariance: its place is a track's,
#: whose errors last.
_FACE_FLOOR_M, _FACE_FACTOR = 0.1, 2.0
#: What stood so often (sightings) within a spot is furniture until it walks.
_STOOD = 15


class PersonTracks:
    """All persons around. ``next_track`` and ``next_person`` are the numbers of the next new ones."""

    def __init__(self, next_track: int = 1, next_person: int = 1, rules: PersonRules | None = None) -> None:
        self.rules = rules or PersonRules()
        self.next_track = next_track
        self.next_person = next_person
        self.passable: Passable = lambda a, b: True
        """Whether no known wall is between two places (2,) m in ``odom``."""
        self._tracks: list[Track] = []
        self._lost: list[Track] = []
        self._missing: list[Identity] = []
        #: Colours by face track, and when they came.
        self._torsos: dict[int, tuple[float, Colors]] = {}
        self._torso = -math.inf
        self._voices = Voices()
        self._furniture = Furniture(self.rules.most)

    # --- observations ------------------------------------------------------------------------------------------------

    def see_faces(self, stamp: float, faces: Sequence[FaceSeen]) -> None:
        """Take the faces of one image."""
        faces = sorted(faces, key=lambda face: face.track)
        self._advance(stamp)
        places = np.array([face.p_OF[:2] for face in faces]).reshape(-1, 2)
        spread = np.array([_over_ground(face.covariance) for face in faces]).reshape(-1, 2, 2)
        cost = costs([track.motion for track in self._tracks], places, spread)
        for row, face in enumerate(faces):
            worn = self._torsos[face.track][1] if face.track in self._torsos and self.rules.identity.colors else None
            for column, track in enumerate(self._tracks):
                cost[row, column] = track.face_cost(float(cost[row, column]), face, stamp, worn)
        pairs = dict(assigned(cost))
        for row, face in enumerate(faces):
            track = self._tracks[pairs[row]] if row in pairs else self._new(stamp, places[row], spread[row])
            if row in pairs:
                self._see_face(track, places[row], spread[row], stamp)
            track.note_face(stamp, face)
        self._settle(stamp)

    def _see_face(self, track: Track, at: Vector, spread: Vector, stamp: float) -> None:
        before = track.motion.at.copy()
        track.motion.update(at, spread)
        if math.dist(before, track.motion.at) > self.rules.jump_m:
            # Who is seen beside a hidden person may be taken for the person.
            track.mixed = stamp

    def see_torsos(self, stamp: float, histograms: Mapping[int, Histogram]) -> None:
        """Take the colours (BINS,) below faces, by their tracks."""
        self._advance(stamp)
        for face, histogram in sorted(histograms.items()):
            _, colors = self._torsos.get(face, (stamp, Colors(6)))
            colors.add(histogram)
            self._torsos[face] = stamp, colors
            self._torso = stamp
            track = next((t for t in self._tracks if t.face_track == face and stamp - t.face < 0.3), None)
            if track is not None:
                track.wear(stamp, histogram, self.rules)
        self._torsos = {face: held for face, held in self._torsos.items() if stamp - held[0] < 5.0}
        self._settle(stamp)

    def see_worn(self, stamp: float, histograms: Mapping[int, Histogram]) -> None:
        """Take the colours (BINS,) above legs, by the numbers of tracks."""
        self._advance(stamp)
        for track in self._tracks:
            if track.number in histograms:
                track.wear(stamp, histograms[track.number], self.rules)
        self._settle(stamp)

    def see_legs(self, stamp: float, legs: Sequence[LegsSeen]) -> None:
        """Take what may be legs in one scan."""
        legs = sorted(legs, key=lambda leg: (float(leg.at[0]), float(leg.at[1])))
        self._advance(stamp)
        places = np.array([leg.at for leg in legs]).reshape(-1, 2)
        spread = np.array([leg.covariance for leg in legs]).reshape(-1, 2, 2)
        cost = costs([track.motion for track in self._tracks], places, spread)
        furniture = [leg.known or self._furniture.at(leg.at) for leg in legs]
        for row, leg in enumerate(legs):
            for column, track in enumerate(self._tracks):
                fits = float(cost[row, column])
                cost[row, column] = track.legs_cost(fits, leg, furniture[row], self.rules.known_s)
        pairs = dict(assigned(cost))
        for row, leg in enumerate(legs):
            if row in pairs:
                track = self._tracks[pairs[row]]
                if math.dist(leg.at, track.motion.at) > self.rules.jump_m:
                    # Who passed before a person may be taken for the person.
                    track.mixed = stamp
                track.motion.update(leg.at, leg.covariance)
            elif leg.known or self._of_a_person(leg.at, stamp):
                continue
            else:
                track = self._new(stamp, leg.at, leg.covariance)
            self._note_legs(track, stamp, leg)
        self._settle(stamp)

    def hear(self, stamp: float, p_OA: Vector, voices: Sequence[VoiceHeard]) -> None:
        """Take the voices heard now at ``p_OA`` (2,) m in ``odom``."""
        self._advance(stamp)
        everybody = {t.number: t for t in (*self._tracks, *self._lost)}
        candidates = [
            Candidate(
                t.number,
                t.motion.at,
                t.motion.P[:2, :2],
                believed=t.believed is not None,
                faces=seen_in_images(t, stamp),
            )
            for t in everybody.values()
        ]
        for voice, number in self._voices.hear(stamp, p_OA, voices, candidates).items():
            track = everybody[number]
            track.voice, track.spoke = voice, stamp
            if track.believed is None and self._voices.heard_s(voice) >= self.rules.voice_s:
                # What has legs and speaks is no chair.
                track.believed = stamp
                self._furniture.forget(track.origin)
        self._settle(stamp)

    def persons(self, stamp: float) -> tuple[Person, ...]:
        """Everybody at ``stamp``, in the order of tracks."""
        self._advance(stamp)
        self._settle(stamp)
        everybody = sorted((*self._tracks, *self._lost), key=lambda track: track.number)
        lost = {track.number for track in self._lost}
        return tuple(track.person(stamp, track.number in lost, self.rules) for track in everybody)

    # --- tracks ------------------------------------------------------------------------------------------------------

    def _advance(self, stamp: float) -> None:
        for track in (*self._tracks, *self._lost):
            track.motion.predict(stamp)
        rules, kept = self.rules, []
        for track in self._tracks:
            unseen = stamp - track.seen
            if unseen <= (rules.lost_s if track.believed is not None or track.faces_seen else rules.forgotten_s):
                kept.append(track)
            elif track.identity is not None:
                track.identity.crossed = any(
                    other is not track
                    and other.believed is not None
                    and math.dist(other.motion.at, track.identity.at) < rules.crossing_m
                    for other in self._tracks
                )
                self._miss(track, track.identity)
                self._lost.append(track)
        self._tracks = kept
        self._lost = [track for track in self._lost if stamp - track.seen <= rules.identity.gap_s]
        self._missing = pruned(self._missing, stamp, rules.identity)
        self._furniture.forget_old(stamp)

    def _miss(self, track: Track, identity: Identity) -> None:
        if all(identity is not other for other in self._missing):
            self._missing.append(identity)

    def _new(self, stamp: float, at: Vector, covariance: Vector) -> Track:
        motion = Motion.begin(stamp, at, covariance)
        track = Track(self.next_track, motion, stamp, np.array(at), seen=stamp, sure=stamp)
        self.next_track += 1
        self._tracks.append(track)
        if len(self._tracks) > self.rules.most:
            gone = min(self._tracks, key=lambda t: (t.believed is not None, t.seen, t.number))
            self._tracks = [other for other in self._tracks if other is not gone]
            if gone.identity is not None:
                self._miss(gone, gone.identity)
        return track

    def _note_legs(self, track: Track, stamp: float, leg: LegsSeen) -> None:
        track.seen = track.legs = max(stamp, track.seen)
        track.sightings += 1
        stood = track.sightings >= _STOOD and math.dist(track.motion.at, track.origin) < SPOT_M
        if track.believed is None and stood:
            self._furniture.note(track.seen, track.origin)
        if not leg.known and not self._furniture.at(leg.at):
            track.sure = max(stamp, track.sure)

    def _of_a_person(self, at: Vector, stamp: float) -> bool:
        """Whether a person is where a candidate without a track is: the other leg, a bag."""
        return any(
            track.believed is not None and math.dist(track.motion.at, at) < _ONE_PERSON_M for track in self._tracks
        )

    # --- belief and identity -----------------------------------------------------------------------------------------

    def _settle(self, stamp: float) -> None:
        self._believe(stamp)
        self._merge(stamp)
        self._doubt_crossing(stamp)
        for track in self._tracks:
            if track.identity is not None:
                self._check(track, stamp, track.identity)
        for track in sorted(self._tracks, key=lambda t: t.number):
            if track.believed is not None and track.identity is None:
                self._identify(track, stamp)
        for track in self._tracks:
            if track.identity is not None and track.seen > track.identity.stamp:
                track.identity.stamp, track.identity.at = track.seen, track.motion.at.copy()
        agreed = [(t, t.identity) for t in self._tracks if t.identity is not None and stamp - t.agreed < AGREED_S]
        numbers = {identity.number for _, identity in agreed}
        for track, identity in agreed:
            identity.agreed = stamp, track.motion.at.copy()
            together = identity.together | numbers - {identity.number}
            identity.together = set(sorted(together)[-self.rules.identity.most :])

    def _believe(self, stamp: float) -> None:
        rules = self.rules
        for track in self._tracks:
            walked = math.dist(track.motion.at, track.origin) >= rules.walked_m and track.sightings >= 4
            if track.believed is not None:
                continue
            if track.faces_seen >= rules.faces or walked:
                track.believed = stamp
                # What stood there was this person.
                self._furniture.forget(track.origin)
            elif track.sightings >= 3:
                self._stand_again(track, stamp)

    def _stand_again(self, track: Track, stamp: float) -> None:
        """Take legs where one person was lost a moment ago for theirs: who stood behind somebody need not walk."""
        gap = self.rules.identity.gap_s
        if self._furniture.at(track.motion.at):
            return
        near = [
            identity
            for identity in self._missing
            if not (identity.crossed and identity.colors.samples)
            and track.born - identity.stamp <= gap
            and math.dist(identity.at, track.motion.at) < 0.5
        ]
        if len(near) == 1:
            track.believed = stamp
            self._take(track, near[0])

    def _merge(self, stamp: float) -> None:
        order = sorted(self._tracks, key=lambda t: (t.believed is None, not seen_in_images(t, stamp), t.number))
        for rank, track in enumerate(order):
            if track.believed is None:
                continue
            for other in order[rank + 1 :]:
                if other.believed is not None and perceived_apart(track, other, stamp):
                    continue
                if math.dist(track.motion.at, other.motion.at) < _ONE_PERSON_M:
                    self._tracks = [t for t in self._tracks if t is not other]
                    if other.identity is not None:
                        self._miss(other, other.identity)
                    return

    def _doubt_crossing(self, stamp: float) -> None:
        """Take their identities from those who pass so near to each other that the laser may confuse them.

        Who is seen in the own colours meanwhile keeps it; the others have it again by their colours.
        """
        rules = self.rules
        if not rules.identity.colors:
            return
        believed = [track for track in self._tracks if track.believed is not None]
        for track in believed:
            if any(o is not track and math.dist(o.motion.at, track.motion.at) < rules.confused_m for o in believed):
                track.mixed = stamp
            identity = track.identity
            if identity is None or identity.colors.samples < rules.identity.samples or track.agreed > track.mixed:
                continue
            # Another's colours say at once that the other has the track.
            if track.against > track.agreed or stamp - track.agreed >= rules.grace_s:
                identity.crossed = True
                self._miss(track, identity)
                self._forget_identity(track)

    def _forget_identity(self, track: Track) -> None:
        """Let ``track`` be unsure: what is perceived from now on may be another, so it is another track."""
        track.forget_identity()
        self._renumber(track)

    def _renumber(self, track: Track) -> None:
        track.number, track.numbered = self.next_track, track.motion.stamp
        self.next_track += 1

    def _check(self, track: Track, stamp: float, identity: Identity) -> None:
        """Doubt the identity of a track whose colours have become another's."""
        rules = self.rules
        if not rules.identity.colors:
            return
        far = track.recent.distance(identity.colors, rules.other_samples)
        # Somebody who passes before a person is soon gone; after a time out of sight nothing speaks for the old name.
        regained = track.strange >= rules.identity.samples and stamp - track.agreed >= AGREED_S
        if not regained and (far is None or far < rules.identity.different):
            return
        self._miss(track, identity)
        self._forget_identity(track)
        track.believed, track.not_new_before, track.doubtful = stamp, stamp + rules.doubt_s, False

    def _identify(self, track: Track, stamp: float) -> None:
        rules = self.rules
        assert track.believed is not None
        few = track.colors.samples < rules.identity.samples
        wait_s = rules.colors_come_s if stamp - self._torso < rules.colored_s else rules.colors_s
        if few and stamp - track.believed < wait_s and rules.identity.colors:
            return
        colored = track.colors.samples >= rules.identity.samples
        # An identity that somebody has by place alone may turn out to be that of whom the colours show.
        weak = [
            t
            for t in self._tracks
            if colored and t is not track and t.identity is not None and stamp - t.agreed > AGREED_S
        ]
        claimed = [t.identity for t in weak if t.identity is not None and t.identity.colors.samples]
        missing = [*self._missing, *claimed]
        seen = Appearance(track.born, track.origin, track.colors, now=stamp, here=track.motion.at)
        found = identify(seen, missing, rules.identity, None if track.doubtful else self.passable)
        track.doubtful = track.doubtful or found == "unsure"
        if isinstance(found, Identity):
            for other in weak:
                if other.identity is found:
                    self._forget_identity(other)
            self._take(track, found)
        elif found == "new" and stamp >= track.not_new_before:
            few = track.colors.samples < rules.new_samples
            if rules.identity.colors and few and stamp - self._torso < rules.colored_s:
                # Colours will say whether it is somebody known.
                return
            if self._worn_by_another(track, stamp):
                return
            self._take(track, Identity(self.next_person, stamp, track.motion.at.copy(), track.colors))
            self.next_person += 1

    def _worn_by_another(self, track: Track, stamp: float) -> bool:
        """Whether somebody not seen just now has the colours of ``track``: one of both tracks is wrong then."""
        rules = self.rules
        for other in self._tracks:
            if other is track or other.identity is None or stamp - other.agreed <= rules.both_s:
                continue
            far = track.colors.distance(other.identity.colors, rules.identity.samples)
            if far is not None and far <= rules.identity.same:
                return True
        return False

    def _take(self, track: Track, identity: Identity) -> None:
        self._missing = [other for other in self._missing if other is not identity]
        self._lost = [other for other in self._lost if other.identity is not identity]
        if identity.colors.samples < self.rules.identity.samples <= track.colors.samples:
            identity.colors = track.colors
        if track.mixed > track.numbered:
            # Who is known now need not be whom it followed before it was so near to another.
            self._renumber(track)
        track.identity = identity
        track.not_new_before = -math.inf
        track.doubtful = False
        track.agreed = track.torso if track.colors.samples >= self.rules.identity.samples else -math.inf


def _over_ground(covariance: Vector) -> Vector:
    return np.asarray(_FACE_FACTOR * covariance[:2, :2] + _FACE_FLOOR_M**2 * np.eye(2))
