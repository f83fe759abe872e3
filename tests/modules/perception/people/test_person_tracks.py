"""Persons from faces, legs, voices and colours: kept through gaps, not confused, unsure where it is doubtful."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.messages import Person
from app.modules.perception.people.person_tracks import PersonTracks
from app.modules.perception.people.torso_color import histogram
from app.modules.perception.people.values import FaceSeen, LegsSeen, PersonRules
from app.modules.perception.people.voices import VoiceHeard

ORANGE, BLUE, WHITE = (196, 88, 52), (74, 92, 132), (226, 224, 216)
STEP_S = 0.1
Way = Callable[[float], tuple[float, float] | None]


def colors(rgb: tuple[int, int, int]) -> np.ndarray:
    return histogram(np.full((60, 3), rgb, np.uint8))


def face(track: int, x: float, y: float, sigma_m: float = 0.1) -> FaceSeen:
    return FaceSeen(track, np.array((x, y, 1.6)), sigma_m**2 * np.eye(3))


def legs(x: float, y: float, known: bool = False) -> LegsSeen:
    return LegsSeen(np.array((x, y)), 0.08**2 * np.eye(2), known)


def standing(x: float, y: float) -> Way:
    return lambda t: (x, y)


def play(
    tracks: PersonTracks,
    legs_of: Iterable[Way] = (),
    faces_of: Iterable[tuple[int, Way, tuple[int, int, int] | None]] = (),
    *,
    begin: float = 0.0,
    end: float,
) -> tuple[Person, ...]:
    """The persons at ``end``, after legs and faces of those ways every tenth of a second."""
    for k in range(round(begin / STEP_S), round(end / STEP_S)):
        t = k * STEP_S
        tracks.see_legs(t, [legs(*at) for way in legs_of if (at := way(t)) is not None])
        seen = [(number, at, rgb) for number, way, rgb in faces_of if (at := way(t)) is not None]
        tracks.see_faces(t, [face(number, *at) for number, at, _ in seen])
        tracks.see_torsos(t, {number: colors(rgb) for number, _, rgb in seen if rgb is not None})
    return tracks.persons(end)


def test_a_face_with_legs_is_one_confirmed_person_where_both_are() -> None:
    (person,) = play(PersonTracks(), [standing(2.0, 1.0)], [(7, standing(2.1, 1.1), ORANGE)], end=3.0)
    assert (person.state, person.person, person.face, person.legs) == ("confirmed", 1, 7, True)
    assert math.dist(person.p_OP[:2], (2.0, 1.0)) < 0.15
    assert abs(person.p_OP[2] - 1.6) < 0.05


def test_legs_that_stand_are_no_person_until_they_walk() -> None:
    tracks = PersonTracks()
    (chair,) = play(tracks, [standing(2.0, 0.0)], end=5.0)
    assert (chair.state, chair.person) == ("tentative", None)
    (walker,) = play(tracks, [lambda t: (2.0 + 0.8 * (t - 5.0), 0.0)], begin=5.0, end=7.0)
    assert (walker.state, walker.person) == ("confirmed", 1)
    assert walker.v_O[0] == pytest.approx(0.8, abs=0.2)


def test_legs_at_an_obstacle_of_the_map_begin_no_track() -> None:
    tracks = PersonTracks()
    tracks.see_legs(0.0, [legs(2.0, 0.0, known=True)])
    assert tracks.persons(0.1) == ()


def test_a_person_hidden_for_five_seconds_keeps_the_identity() -> None:
    def way(t: float) -> tuple[float, float] | None:
        return None if 4.0 < t < 9.0 else (1.0 + 0.5 * t, 0.0)

    tracks = PersonTracks()
    (before,) = play(tracks, [way], end=4.0)
    (lost,) = play(tracks, begin=4.0, end=6.0)
    (after,) = play(tracks, [way], begin=6.0, end=12.0)
    assert (before.person, lost.person, after.person) == (1, 1, 1)
    assert (lost.state, after.state) == ("lost", "confirmed")


def test_two_lost_within_reach_leave_who_appears_unsure() -> None:
    tracks = PersonTracks()
    play(tracks, [lambda t: (1.0 + 0.5 * t, 0.3), lambda t: (1.0 + 0.5 * t, -0.8)], end=3.0)
    appeared = play(tracks, [lambda t: (3.6 - 0.5 * (t - 6.0), -0.2)], begin=6.0, end=9.0)
    (person,) = [p for p in appeared if p.state != "lost"]
    assert (person.state, person.person) == ("unsure", None)


def test_who_appears_behind_a_wall_is_another() -> None:
    tracks = PersonTracks()
    play(tracks, [lambda t: (1.0 + 0.5 * t, 0.0)], end=3.0)
    tracks.passable = lambda a, b: False
    appeared = play(tracks, [lambda t: (2.5 - 0.5 * (t - 6.0), 1.0)], begin=6.0, end=9.0)
    assert {p.person for p in appeared if p.state == "confirmed"} == {2}


def test_colours_bring_an_identity_back_after_minutes() -> None:
    tracks = PersonTracks()
    play(tracks, [], [(1, standing(2.0, 1.0), ORANGE), (2, standing(2.0, -1.0), BLUE)], end=3.0)
    assert play(tracks, begin=3.0, end=90.0) == ()
    back = play(tracks, [], [(8, standing(3.0, 0.0), BLUE), (9, standing(1.0, 2.0), ORANGE)], begin=90.0, end=94.0)
    assert {p.face: p.person for p in back} == {8: 2, 9: 1}


def test_other_colours_are_a_new_person_though_one_was_just_lost_there() -> None:
    tracks = PersonTracks()
    play(tracks, [], [(1, standing(2.0, 1.0), ORANGE)], end=3.0)
    back = play(tracks, [], [(2, standing(2.1, 1.0), WHITE)], begin=6.0, end=9.0)
    assert {p.face: p.person for p in back if p.state == "confirmed"} == {2: 2}


def test_two_in_the_same_shirt_are_not_taken_for_each_other() -> None:
    tracks = PersonTracks()
    play(tracks, [], [(1, standing(2.0, 1.0), BLUE), (2, standing(2.0, -1.0), BLUE)], end=3.0)
    (back,) = play(tracks, [], [(3, standing(2.0, 0.0), BLUE)], begin=60.0, end=64.0)
    assert (back.state, back.person) == ("unsure", None)


def test_without_colours_nobody_is_recognized_after_long() -> None:
    tracks = PersonTracks()
    play(tracks, [], [(1, standing(2.0, 1.0), None)], end=3.0)
    (back,) = play(tracks, [], [(2, standing(2.0, 1.0), None)], begin=60.0, end=63.0)
    assert (back.state, back.person) == ("confirmed", 2)


def test_two_who_cross_keep_their_identities() -> None:
    tracks = PersonTracks()
    ways = (lambda t: (0.5 * t, 0.4), lambda t: (4.0 - 0.5 * t, -0.4))
    faces = [(1, ways[0], ORANGE), (2, ways[1], BLUE)]
    before = {p.face: p.person for p in play(tracks, ways, faces, end=2.0)}
    after = {p.face: p.person for p in play(tracks, ways, faces, begin=2.0, end=8.0)}
    assert before == after
    assert set(before) == {1, 2}


def test_known_persons_whose_legs_cross_are_unsure_until_their_colours_are_seen() -> None:
    tracks = PersonTracks()
    ways = (lambda t: (0.5 * t, 0.2), lambda t: (4.0 - 0.5 * t, -0.2))
    faces = [(1, ways[0], ORANGE), (2, ways[1], BLUE)]
    before = {p.face: p.person for p in play(tracks, ways, faces, end=2.0)}
    crossed = play(tracks, ways, begin=2.0, end=5.5)
    assert {(p.state, p.person) for p in crossed if p.state != "lost"} == {("unsure", None)}
    again = [(3, ways[0], ORANGE), (4, ways[1], BLUE)]
    after = {p.face: p.person for p in play(tracks, ways, again, begin=5.5, end=8.0) if p.state == "confirmed"}
    assert after == {3: before[1], 4: before[2]}


def test_who_walks_past_a_chair_does_not_become_one() -> None:
    tracks = PersonTracks()
    chair = standing(2.5, 0.3)

    def way(t: float) -> tuple[float, float] | None:
        return (0.5 * (t - 2.0), 0.0) if 2.0 < t < 6.8 else None

    play(tracks, [chair, way], end=6.8)
    left = play(tracks, [chair], begin=6.8, end=9.5)
    assert all(p.state in ("tentative", "lost") for p in left)


def test_a_voice_is_of_the_person_in_its_direction_alone() -> None:
    tracks = PersonTracks()
    here = np.zeros(2)
    play(tracks, [], [(1, standing(2.0, 1.5), None), (2, standing(2.0, -1.5), None)], end=2.0)
    tracks.hear(2.0, here, [VoiceHeard(5, math.atan2(1.5, 2.0) + 0.05)])
    speaking = {p.face: p.voice for p in tracks.persons(2.0) if p.speaking}
    assert speaking == {1: 5}
    tracks.hear(2.5, here, [VoiceHeard(6, 0.0)])
    assert not any(p.speaking for p in tracks.persons(3.0))


def test_a_voice_between_two_is_nobodys() -> None:
    tracks = PersonTracks()
    play(tracks, [], [(1, standing(3.0, 0.3), None), (2, standing(3.0, -0.3), None)], end=2.0)
    tracks.hear(2.0, np.zeros(2), [VoiceHeard(5, 0.01)])
    assert not any(p.speaking for p in tracks.persons(2.0))


@settings(max_examples=20)
@given(st.randoms(use_true_random=False))
def test_the_order_within_messages_changes_nothing(order: random.Random) -> None:
    plain, shuffled = PersonTracks(), PersonTracks()
    for k in range(25):
        t = k * STEP_S
        scan = [legs(1.0 + 0.08 * k, 0.5), legs(3.0 - 0.08 * k, -0.5), legs(2.0, 2.0), legs(4.0, 2.0, known=True)]
        faces = [face(1, 1.0 + 0.08 * k, 0.5), face(2, 3.0 - 0.08 * k, -0.5), face(3, 1.0, -2.0)]
        plain.see_legs(t, scan)
        plain.see_faces(t, faces)
        shuffled.see_legs(t, order.sample(scan, len(scan)))
        shuffled.see_faces(t, order.sample(faces, len(faces)))
    assert [_values(p) for p in plain.persons(2.5)] == [_values(p) for p in shuffled.persons(2.5)]


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_numbers_are_used_once_and_memory_is_bounded(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tracks = PersonTracks(rules=PersonRules(most=10))
    owners: dict[int, int] = {}
    for k in range(40):
        t = k * 0.3
        places = rng.uniform(-6, 6, (14, 2))
        tracks.see_faces(t, [face(100 * k + i, *at) for i, at in enumerate(places.tolist())])
        tracks.see_legs(t, [legs(*at) for at in rng.uniform(-6, 6, (20, 2)).tolist()])
        persons = tracks.persons(t)
        assert sum(p.state != "lost" for p in persons) <= 10
        assert len({p.track for p in persons}) == len(persons)
        held = [p.person for p in persons if p.person is not None]
        assert len(set(held)) == len(held), "one identity, one person"
        for p in persons:
            if p.track in owners and p.person is not None:
                assert owners[p.track] == p.person
            if p.person is not None:
                owners[p.track] = p.person
                assert p.person < tracks.next_person
            assert p.track < tracks.next_track


def _values(person: Person) -> tuple[object, ...]:
    place = tuple(round(value, 9) for value in (*person.p_OP, *person.v_O))
    return person.track, person.person, person.state, place, person.face, person.legs


def test_colours_above_legs_say_who_stands_turned_away() -> None:
    tracks = PersonTracks()
    play(tracks, [], [(1, standing(2.0, 1.0), ORANGE), (2, standing(2.0, -1.0), BLUE)], end=3.0)
    for k in range(600, 640):
        tracks.see_legs(0.1 * k, [legs(1.0 + 0.05 * (k - 600), 0.0)])
        (person,) = [p for p in tracks.persons(0.1 * k) if p.state != "lost"]
        tracks.see_worn(0.1 * k, {person.track: colors(BLUE)})
    (person,) = tracks.persons(64.0)
    assert (person.state, person.person, person.face) == ("confirmed", 2, None)


def test_a_track_whose_legs_jump_is_unsure_until_colours_say_whose_they_are() -> None:
    tracks = PersonTracks()
    play(tracks, [standing(3.0, 0.0)], [(1, standing(3.0, 0.0), ORANGE), (2, standing(1.0, 2.0), BLUE)], end=3.0)
    numbers = {p.face: p.person for p in tracks.persons(3.0)}
    play(tracks, [standing(3.0, 0.0)], begin=3.0, end=6.0)

    def passing(t: float) -> tuple[float, float]:
        return 3.0, 0.3 + 0.5 * (t - 6.0)

    # Another passes before who stands there, and the laser sees one pair of legs.
    (person,) = [p for p in play(tracks, [passing], begin=6.0, end=8.0) if p.state != "lost"]
    assert (person.state, person.person) == ("unsure", None)
    for k in range(80, 100):
        tracks.see_legs(0.1 * k, [legs(*passing(0.1 * k))])
        tracks.see_worn(0.1 * k, {person.track: colors(BLUE)})
    (person,) = [p for p in tracks.persons(10.0) if p.state != "lost"]
    assert (person.state, person.person) == ("confirmed", numbers[2])


@given(st.floats(0.6, 0.95), st.booleans())
@settings(max_examples=12, deadline=None)
def test_a_track_that_went_over_to_the_face_beside_a_hidden_person_is_unsure(aside: float, colored: bool) -> None:
    tracks = PersonTracks()
    play(tracks, [standing(4.0, 0.0)], [(1, standing(4.0, 0.0), ORANGE)], end=3.0)
    # The person is hidden; beside there is a face whose distance is a guess.
    named = set()
    for k in range(30, 45):
        t = k * STEP_S
        if k >= 36:
            seen = FaceSeen(2, np.array((4.0, aside, 1.6)), np.diag((1.0, 0.05, 0.01)))
            tracks.see_faces(t, [seen])
            if colored:
                tracks.see_torsos(t, {2: colors(BLUE)})
        named = {p.person for p in tracks.persons(t) if p.face == 2}
    assert 1 not in named


def seen_above_legs(
    tracks: PersonTracks, legs_of: Iterable[Way], worn: dict[int, tuple[int, int, int]], begin: float, end: float
) -> list[tuple[Person, ...]]:
    """The persons every tenth of a second; ``worn`` by the index of the way that is nearest to the person."""
    ways, found = tuple(legs_of), []
    for k in range(round(begin / STEP_S), round(end / STEP_S)):
        t = k * STEP_S
        tracks.see_legs(t, [legs(*at) for way in ways if (at := way(t)) is not None])
        persons = [p for p in tracks.persons(t) if p.state in ("confirmed", "unsure")]
        looks = {}
        for p in persons:
            nearest = min(range(len(ways)), key=lambda i: math.dist(p.p_OP[:2], ways[i](t) or (1e6, 0.0)))
            if nearest in worn:
                looks[p.track] = colors(worn[nearest])
        tracks.see_worn(t, looks)
        found.append(tracks.persons(t))
    return found


def test_anothers_colours_after_a_crossing_end_an_identity_at_once() -> None:
    tracks = PersonTracks()
    orange = (1, standing(3.0, 0.0), ORANGE)
    play(tracks, [standing(3.0, 0.0)], [orange, (2, standing(1.0, 3.0), BLUE)], end=3.0)
    numbers = {p.face: p.person for p in tracks.persons(3.0)}
    play(tracks, [standing(3.0, 0.0)], [orange], begin=3.0, end=6.0)

    def passing(t: float) -> tuple[float, float]:
        return 3.0, 0.3 + 0.5 * (t - 6.0)

    # The track of who stood there goes along with who passes, in other colours, within a moment after its own.
    later = seen_above_legs(tracks, [passing], {0: BLUE}, 6.0, 8.5)
    named = [p.person for persons in later[2:] for p in persons if p.legs and p.state == "confirmed"]
    assert numbers[1] not in named
    assert named[-1] == numbers[2]


@given(st.floats(0.3, 1.2), st.floats(2.0, 5.0))
@settings(max_examples=20, deadline=None)
def test_a_track_that_went_over_to_another_person_has_another_number(speed: float, away: float) -> None:
    tracks = PersonTracks()
    ways = [standing(away, 0.0), standing(1.0, 4.0)]
    play(tracks, ways, [(1, ways[0], ORANGE), (2, ways[1], BLUE)], end=3.0)
    owners = {p.track: p.person for p in tracks.persons(3.0)}

    def passing(t: float) -> tuple[float, float]:
        return away, 0.3 + speed * (t - 3.0)

    for persons in seen_above_legs(tracks, [passing], {0: BLUE}, 3.0, 6.0):
        for p in persons:
            if p.person is not None:
                assert owners.setdefault(p.track, p.person) == p.person


def test_the_colours_of_two_are_no_third_persons() -> None:
    tracks = PersonTracks()
    play(tracks, [], [(1, standing(2.0, 1.5), ORANGE), (2, standing(2.0, -1.5), BLUE)], end=3.0)
    # A face without legs, whose torso is now one's and now the other's.
    for k in range(100, 140):
        t = k * STEP_S
        tracks.see_faces(t, [face(9, 3.0, 0.0)])
        tracks.see_torsos(t, {9: colors(ORANGE if k % 2 else BLUE)})
    (person,) = [p for p in tracks.persons(14.0) if p.state != "lost"]
    assert (person.state, person.person) == ("unsure", None)


def test_colours_seen_again_after_long_end_an_identity_that_place_alone_held() -> None:
    tracks = PersonTracks()
    at = standing(3.0, 0.0)
    play(tracks, [at], [(1, at, ORANGE), (2, standing(1.0, 2.0), BLUE)], end=6.0)
    numbers = {p.face: p.person for p in tracks.persons(6.0)}
    # Nobody looks at the torso for five seconds; the legs never jumped, but another is there now.
    play(tracks, [at], begin=6.0, end=11.0)
    looks = seen_above_legs(tracks, [at], {0: BLUE}, 11.0, 13.0)
    assert [p.person for p in looks[4] if p.legs] == [None], "three looks are enough"
    assert [p.person for p in looks[-1] if p.legs] == [numbers[2]]


@pytest.mark.parametrize(("worn", "stays"), [(ORANGE, True), (BLUE, False), (None, False)])
def test_legs_at_an_obstacle_are_a_persons_while_the_own_colours_are_above_them(
    worn: tuple[int, int, int] | None, stays: bool
) -> None:
    tracks = PersonTracks()
    play(tracks, [standing(3.0, 0.0)], [(1, standing(3.0, 0.0), ORANGE)], end=3.0)
    # The person turns away beside something that the map has, and stands there for longer than that alone may count.
    for k in range(30, 180):
        t = k * STEP_S
        tracks.see_legs(t, [legs(3.0, 0.0, known=True)])
        if worn is not None:
            tracks.see_worn(t, {p.track: colors(worn) for p in tracks.persons(t) if p.legs})
    assert any(p.state == "confirmed" and p.person == 1 for p in tracks.persons(18.0)) == stays


def test_an_unsure_track_that_went_over_to_another_has_another_number_with_the_name() -> None:
    tracks = PersonTracks()
    play(tracks, [standing(1.0, 3.0)], [(1, standing(1.0, 3.0), ORANGE)], end=3.0)
    # Somebody of whom nothing but the face is seen is not known; the person who passes is taken for that one.
    (unknown,) = [p for p in play(tracks, [], [(2, standing(3.0, 0.0), None)], begin=8.0, end=10.0) if p.face == 2]

    def passing(t: float) -> tuple[float, float]:
        return 3.0, 0.35 + 0.5 * (t - 10.0)

    named = [p for persons in seen_above_legs(tracks, [passing], {0: ORANGE}, 10.0, 13.0) for p in persons if p.person]
    assert {p.person for p in named} == {1}
    assert unknown.track not in {p.track for p in named}
