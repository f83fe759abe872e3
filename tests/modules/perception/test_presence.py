"""Presence with hysteresis: by example, and that no sequence of looks makes a subject appear twice without leaving."""

from __future__ import annotations

import math
from collections import defaultdict

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.modules.perception.presence import Hysteresis, PresenceState, Sighting, look

PLAIN = Hysteresis(sightings=2, off_looks=2, off_s=0.5, moved_m=0.5, turned_rad=0.5, change_s=1.0)


class Eyes:
    """Looks one after another; ``said`` is what came of them: stamp, verb, subject."""

    def __init__(self, rule: Hysteresis = PLAIN) -> None:
        self.rule = rule
        self.presence = PresenceState()
        self.said: list[tuple[float, str, str]] = []

    def look(self, stamp: float, *sightings: Sighting, source: str = "kinect") -> None:
        self.presence, changes = look(self.presence, self.rule, source, stamp, sightings)
        self.said += [(stamp, change.verb, change.subject.sighting.subject) for change in changes]


ANN = Sighting("ann")


def test_it_appears_with_enough_sightings_and_leaves_after_enough_looks_without() -> None:
    eyes = Eyes()
    for stamp in (0.0, 0.125, 0.25):
        eyes.look(stamp, ANN)
    assert eyes.presence.there == {"ann"}
    for stamp in (0.375, 0.625, 0.75, 0.875):
        eyes.look(stamp)
    assert eyes.said == [(0.125, "appears", "ann"), (0.75, "leaves", "ann")]
    assert not eyes.presence.subjects


def test_one_sighting_that_is_not_confirmed_is_no_event() -> None:
    eyes = Eyes()
    eyes.look(0.0, ANN)
    for stamp in (0.3, 0.6, 0.9):
        eyes.look(stamp)
    assert eyes.said == []
    assert not eyes.presence.subjects, "and it is forgotten"


def test_it_must_be_seen_for_long_enough_where_a_time_is_asked_for() -> None:
    eyes = Eyes(Hysteresis(on_s=0.5, off_s=5))
    for stamp in (0.0, 0.25, 0.5, 0.75, 1.0, 1.25):
        eyes.look(stamp, *([ANN] if stamp != 0.5 else []))
    assert eyes.said == [(1.0, "appears", "ann")], "0.25 s, a gap, 0.25 s"


def test_short_gaps_are_bridged() -> None:
    eyes = Eyes()
    for step in range(100):
        eyes.look(step * 0.3, *([ANN] if step % 2 == 0 else []))
    assert eyes.said == [(0.6, "appears", "ann")]


def test_while_no_source_looks_nothing_leaves_and_one_look_without_is_not_enough() -> None:
    eyes = Eyes()
    eyes.look(0.0, ANN)
    eyes.look(0.1, ANN)
    eyes.look(3600.0)
    assert eyes.presence.there == {"ann"}
    eyes.look(3600.1, ANN)
    eyes.look(7200.0)
    eyes.look(7200.1)
    assert eyes.said == [(0.1, "appears", "ann"), (7200.1, "leaves", "ann")]


def test_only_the_source_that_saw_it_last_can_miss_it() -> None:
    eyes = Eyes()
    eyes.look(0.0, ANN, source="panorama")
    eyes.look(0.1, ANN, source="panorama")
    for step in range(20):
        eyes.look(0.2 + step, source="kinect")
    assert eyes.presence.there == {"ann"}
    eyes.look(21.0, ANN, source="kinect")
    eyes.look(21.5, source="kinect")
    eyes.look(22.0, source="kinect")
    assert eyes.said[-1] == (22.0, "leaves", "ann")


def test_confidence_has_two_thresholds_and_what_was_not_judged_stays() -> None:
    eyes = Eyes(Hysteresis(enter=0.5, stay=0.3, off_looks=2, off_s=0))
    for stamp, confidence in enumerate((math.nan, 0.4, 0.6, 0.4, math.nan, 0.2, 0.4, 0.2, 0.2, 0.4)):
        eyes.look(float(stamp), Sighting("ann", confidence))
    assert eyes.said == [(2.0, "appears", "ann"), (8.0, "leaves", "ann")]


def test_it_changes_when_it_has_moved_or_turned_far_enough_and_not_too_often() -> None:
    eyes = Eyes()
    places = [(0.0, 0.0), (0.1, 0.0), (0.5, 0.4), (0.9, 0.6), (1.2, 0.8), (2.5, 1.4)]
    for stamp, x in places:
        eyes.look(stamp, Sighting("ann", 1.0, (x, 0.0, 0.0), 0.0))
    assert eyes.said == [(0.1, "appears", "ann"), (1.2, "changes", "ann"), (2.5, "changes", "ann")]
    eyes.look(4.0, Sighting("ann", 1.0, (1.4, 0.0, 0.0), 0.6))
    assert eyes.said[-1] == (4.0, "changes", "ann")


def test_a_place_that_becomes_known_later_is_no_change() -> None:
    eyes = Eyes()
    for stamp in (0.0, 0.1, 2.0):
        eyes.look(stamp, ANN)
    eyes.look(4.0, Sighting("ann", 1.0, (5.0, 0.0, 0.0)))
    assert len(eyes.said) == 1
    eyes.look(5.0, Sighting("ann", 1.0, (5.6, 0.0, 0.0)))
    assert eyes.said[-1] == (5.0, "changes", "ann")


def test_of_two_sightings_of_one_subject_the_nearer_to_its_place_counts() -> None:
    eyes = Eyes()
    here, there = (Sighting("code", 1.0, (x, 0.0, 0.0)) for x in (0.0, 9.0))
    for stamp in (0.0, 1.0, 2.0, 3.0):
        eyes.look(stamp, *([here] if stamp == 0.0 else [there, here]))
    assert eyes.said == [(1.0, "appears", "code")]


SOURCES = st.sampled_from(["kinect", "panorama"])
SIGHTINGS = st.lists(
    st.builds(
        Sighting,
        st.sampled_from(["ann", "ben"]),
        st.one_of(st.just(math.nan), st.floats(0, 1)),
        st.one_of(st.none(), st.tuples(st.floats(-2, 2), st.just(0.0), st.just(0.0))),
        st.one_of(st.none(), st.floats(-4, 4)),
    ),
    max_size=3,
)
GAPS = st.one_of(st.floats(0, 0.5), st.sampled_from([-0.1, 1.0, 60.0]))
RULES = st.builds(
    Hysteresis,
    sightings=st.integers(1, 3),
    on_s=st.floats(0, 1),
    off_looks=st.integers(1, 3),
    off_s=st.floats(0, 2),
    enter=st.floats(0, 1),
    stay=st.floats(0, 1),
    moved_m=st.one_of(st.none(), st.floats(0.1, 2)),
    turned_rad=st.one_of(st.none(), st.floats(0.1, 2)),
    change_s=st.floats(0, 2),
)


@given(RULES, st.lists(st.tuples(GAPS, SOURCES, SIGHTINGS), max_size=60))
def test_events_alternate_are_debounced_and_only_looks_make_them(
    rule: Hysteresis, looks: list[tuple[float, str, list[Sighting]]]
) -> None:
    presence, stamp = PresenceState(), 100.0
    there: dict[str, str] = {}
    last_event: dict[str, float] = {}
    last_seen: dict[str, tuple[float, str]] = {}
    looks_seen: dict[str, int] = defaultdict(int)
    for gap_s, source, sightings in looks:
        stamp += gap_s
        presence, changes = look(presence, rule, source, stamp, sightings)
        for sighting in sightings:
            looks_seen[sighting.subject] += 1
            last_seen[sighting.subject] = (stamp, source)
        assert len({change.subject.sighting.subject for change in changes}) == len(changes), "one event a look"
        for change in changes:
            name = change.subject.sighting.subject
            assert not math.isnan(change.subject.sighting.confidence)
            if change.verb == "appears":
                assert name not in there, "no two appears without a leaves between"
                assert looks_seen[name] >= rule.sightings
                there[name] = source
            else:
                assert name in there
                assert change.subject.source == source
            if change.verb == "changes":
                assert stamp - last_event[name] >= rule.change_s
            if change.verb == "leaves":
                assert name not in {s.subject for s in sightings if s.confidence >= max(rule.enter, rule.stay)}
                del there[name]
            last_event[name] = stamp
        assert presence.there == set(there)


@given(st.floats(1.0, 1e6), st.sampled_from(["kinect", "panorama"]))
def test_no_rest_of_any_length_is_a_leave(rest_s: float, source: str) -> None:
    eyes = Eyes(Hysteresis(off_looks=1, off_s=1.1))
    eyes.look(0.0, ANN)
    eyes.look(rest_s, source=source)
    assert eyes.said == [(0.0, "appears", "ann")]


@pytest.mark.parametrize("wrong", [{"sightings": 0}, {"off_s": -1}, {"moved_m": 0}, {"enter": 2}, {"of_s": 1}])
def test_rules_that_cannot_be_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Hysteresis.model_validate(wrong)
