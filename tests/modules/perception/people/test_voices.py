"""Whose a voice is: by direction, place, face, and over a sentence; of none where it may be several persons'."""

from __future__ import annotations

import math

import numpy as np

from app.modules.perception.people.person_tracks import PersonTracks
from app.modules.perception.people.values import LegsSeen
from app.modules.perception.people.voices import Candidate, VoiceHeard, Voices

EARS = np.zeros(2)


def at(
    number: int, degrees: float, away_m: float, sigma_m: float = 0.05, *, believed: bool = True, faces: bool = False
) -> Candidate:
    angle = math.radians(degrees)
    place = away_m * np.array((math.cos(angle), math.sin(angle)))
    return Candidate(number, place, sigma_m**2 * np.eye(2), believed=believed, faces=faces)


def heard(*candidates: Candidate, degrees: float = 0.0) -> int | None:
    return Voices().hear(0.0, EARS, [VoiceHeard(9, math.radians(degrees))], candidates).get(9)


def test_of_two_four_degrees_apart_the_voice_is_of_whom_it_points_at() -> None:
    assert heard(at(1, 0.5, 3.0), at(2, 4.5, 3.0)) == 1
    assert heard(at(1, 2.0, 3.0), at(2, -2.0, 3.0)) is None


def test_of_two_behind_each_other_who_looks_at_the_robot_speaks() -> None:
    assert heard(at(1, 2.0, 3.0, faces=True), at(2, -2.0, 5.5)) == 1
    assert heard(at(1, 2.0, 3.0, faces=True), at(2, -2.0, 5.5, faces=True)) is None


def test_a_voice_beside_a_person_is_of_somebody_unseen() -> None:
    assert heard(at(1, 7.0, 3.0)) is None


def test_a_doubtful_place_may_be_farther_from_the_voice() -> None:
    assert heard(at(1, 7.0, 3.0, sigma_m=0.3)) == 1


def test_legs_that_may_be_a_chairs_have_a_voice_where_no_person_is() -> None:
    assert heard(at(1, 1.0, 3.0, believed=False)) == 1
    assert heard(at(1, 1.0, 3.0, believed=False), at(2, -1.0, 3.0)) == 2


def test_who_passes_before_a_speaker_does_not_take_the_voice() -> None:
    voices = Voices()
    owners = set()
    for k in range(40):
        passing = at(2, -20.0 + k, 2.0, faces=True)
        found = voices.hear(0.1 * k, EARS, [VoiceHeard(9, 0.0)], [at(1, 0.0, 4.0), passing])
        owners.add(found.get(9))
    assert owners == {1}


def test_a_voice_goes_to_the_other_where_it_was_wrong_at_first() -> None:
    voices = Voices()
    people = [at(1, 0.0, 3.0), at(2, 6.0, 3.0)]
    assert voices.hear(0.0, EARS, [VoiceHeard(9, math.radians(0.0))], people) == {9: 1}
    for k in range(1, 40):
        found = voices.hear(0.1 * k, EARS, [VoiceHeard(9, math.radians(6.0))], people)
    assert found == {9: 2}


def test_legs_that_stand_and_speak_are_a_persons_and_others_stay_chairs() -> None:
    tracks = PersonTracks()
    for k in range(40):
        t = 0.1 * k
        tracks.see_legs(t, [LegsSeen(np.array((3.0, y)), 0.08**2 * np.eye(2), known=False) for y in (0.0, 1.5)])
        tracks.hear(t, EARS, [VoiceHeard(9, 0.01)] if k > 20 else [])
    speaker, chair = sorted(tracks.persons(4.0), key=lambda person: person.p_OP[1])
    assert (speaker.state != "tentative", speaker.speaking) == (True, True)
    assert (chair.state, chair.speaking) == ("tentative", False)
