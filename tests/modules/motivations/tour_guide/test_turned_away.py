"""Visitors who turn their backs: no faces, and there still, by their legs in the laser."""

from __future__ import annotations

import asyncio
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.messages import Person, Persons, PersonState
from app.modules.motivations.tour_guide.perceptions import perceptions
from app.modules.motivations.tour_guide.progress import State
from app.modules.motivations.tour_guide.visitors import SEEN_S, STOOD_S, People, Point, Visitors
from app.modules.motivations.tour_guide.waiting import GOES_BACK_S, TURNED_AWAY_S
from app.runtime.clock import in_virtual_time
from tests.modules.motivations.tour_guide.lab_tour import PLACES, tour
from tests.modules.motivations.tour_guide.led_lab import LedLab, Visitor, person
from tests.modules.motivations.tour_guide.run import Run
from tests.modules.motivations.tour_guide.test_missing_visitors import looking_back


def around(visitors: Visitors, now: float, *, sought_since: float | None = None, legs_m: float = 0.0) -> People:
    return visitors.around(now, Pose2(), within_m=2.0, behind=False, sought_since=sought_since, legs_m=legs_m)


def bound(visitors: Visitors, now: float, *persons: Person) -> Visitors:
    visitors.bind(Persons(now, persons))
    return visitors


def test_who_turns_away_is_still_one() -> None:
    visitors = Visitors()
    visitors.see(10.0, {1: (2.0, 0.0)})
    bound(visitors, 10.0, person(7, 2.0, 0.1, last_seen=10.0))
    assert (around(visitors, 10.0).people, around(visitors, 10.0).others) == (1, 0), "legs and face are of one person"
    now = 10.1 + SEEN_S
    bound(visitors, now, person(7, 2.0, 0.3, last_seen=now))
    found = around(visitors, now)
    assert (found.people, found.others, found.others_m) == (0, 1, pytest.approx(math.hypot(2.0, 0.3)))
    assert found.others_nearest_m == found.others_m
    sought = around(visitors, now, sought_since=9.0)
    assert (sought.found, sought.others) == (1, 0), "the one whose face was seen as it looked for them"


def test_a_face_and_a_back_are_two() -> None:
    visitors = Visitors()
    visitors.see(10.0, {1: (2.0, 0.0)})
    bound(visitors, 10.0, person(7, 2.0, 0.1, last_seen=10.0), person(8, 2.0, 0.45, last_seen=10.0))
    assert (around(visitors, 10.0).people, around(visitors, 10.0).others) == (1, 1)


def test_what_is_not_bound_any_more_is_nobody() -> None:
    visitors = bound(Visitors(), 10.0, person(7, 2.0, 0.0, last_seen=10.0))
    assert around(visitors, 10.0).others == 1
    assert around(visitors, 12.0).others == 0, "persons are not tracked any more"
    bound(visitors, 15.0, person(7, 2.0, 0.0, state="lost", last_seen=10.0))
    assert around(visitors, 15.0).others == 0
    assert around(visitors, 15.0, sought_since=9.0).others == 1, "seen since they are looked for"
    assert visitors.around(15.0, Pose2(), within_m=2.0, behind=True, sought_since=9.0).others == 0


def test_legs_that_never_walked_are_somebodys_where_visitors_are_looked_for() -> None:
    def standing(x: float, stamp: float) -> tuple[Person, ...]:
        near = person(8, x, 0.0, state="tentative", last_seen=stamp)
        return near, person(9, x, 0.5, state="tentative", last_seen=stamp)

    visitors = bound(Visitors(), 10.0, *standing(3.0, 10.0))
    assert around(visitors, 10.0, legs_m=4.0).others == 0, "a glimpse"
    bound(visitors, 10.0 + STOOD_S, *standing(3.0, 10.0 + STOOD_S))
    assert around(visitors, 10.0 + STOOD_S, legs_m=4.0).others == 1, "so near to each other they are of one"
    assert around(visitors, 10.0 + STOOD_S).others == 0, "a chair, where nobody is looked for"
    assert around(visitors, 10.0 + STOOD_S, legs_m=2.0).others == 0, "farther than visitors are waited for"
    visitors.see(10.0 + STOOD_S, {1: (3.0, 0.3)})
    assert around(visitors, 10.0 + STOOD_S, legs_m=4.0).others == 0, "of the one whose face is seen there"


places = st.tuples(st.floats(0.5, 4.0), st.floats(-2.0, 2.0))
states: st.SearchStrategy[PersonState] = st.sampled_from(["confirmed", "unsure", "tentative", "lost"])


@given(st.lists(places, max_size=5), st.lists(st.tuples(places, states), max_size=6))
def test_a_face_is_one_persons(faces: list[Point], found: list[tuple[Point, PersonState]]) -> None:
    persons = [person(k, *at, state=state, last_seen=10.0) for k, (at, state) in enumerate(found)]
    visitors = bound(Visitors(), 8.0, *persons)
    visitors.see(10.0, dict(enumerate(faces)))
    people = around(bound(visitors, 10.0, *persons), 10.0, sought_since=9.0, legs_m=5.0)
    assert people.people == len(faces)
    alone = [at for at, _ in found if all(math.dist(at, face) > 1.5 for face in faces)]
    counted = [at for at, state in found if state != "tentative" and at in alone]
    assert people.others >= len(counted), "who is far from all faces is another"
    believed = sum(each.state != "tentative" for each in persons)
    assert max(believed - len(faces), 0) <= people.others <= len(persons)


def test_a_visitor_with_his_back_turned_is_waited_for_only_a_little() -> None:
    run = looking_back().see(others=1, others_m=1.8, others_nearest_m=1.8)
    assert run.see(after_s=TURNED_AWAY_S - 1.0).progress.state == "waiting", "a face may come yet"
    assert run.see(after_s=1.1).progress.state == "leading"
    assert run.progress.company.size == 2, "both come along"
    assert "without" not in run.progress.excuse


def test_it_does_not_drive_back_for_one_who_is_there() -> None:
    run = looking_back().see(farthest_m=3.0, nearest_m=3.0, others=1, others_m=3.9, others_nearest_m=3.9)
    run.see(after_s=GOES_BACK_S + 1.0)
    assert (run.progress.state, run.progress.company.went_back) == ("waiting", False)
    assert run.texts() == ["I am waiting for you."]
    assert run.see(others=0).progress.state == "searching"


def test_visitors_who_look_at_what_is_shown_have_not_left() -> None:
    run = Run().started().until("listening").see(people=0, near=0, others=2)
    assert run.see(after_s=9.0).progress.state == "listening"
    assert run.see(others=0).see(after_s=5.1).progress.state == "parting"


@pytest.mark.parametrize(
    ("state", "tracked"),
    [("inviting", False), ("leading", False), ("turning", True), ("presenting", True), ("listening", True)],
)
def test_persons_are_tracked_where_visitors_may_turn_away(state: State, tracked: bool) -> None:
    run = Run().started().until(state)
    assert ("TrackPersons" in {wish.cls for wish in perceptions(run.progress, run.scene)}) is tracked


@pytest.mark.slow
@in_virtual_time
async def test_it_leads_on_visitors_whose_backs_it_sees(tmp_path: Path) -> None:
    led = await asyncio.to_thread(LedLab, tmp_path, tour(), PLACES)
    led.visitors = [Visitor(1.5, 0.5), Visitor(1.5, -0.5)]
    async with led:

        def look_away() -> None:
            for visitor in led.visitors:
                visitor.looks = led.progress.state in ("idle", "inviting", "confirming")

        led.start()
        await led.until("confirming")
        led.press("agree")
        await led.until("idle", limit_s=600, each=look_away)
        assert (led.progress.presented, led.progress.reason) == (("one", "two"), "the tour is over")
        assert "searching" not in led.states
        report = led.server.report
        assert report is not None
        assert report.waits >= 2
        assert report.waited_s < report.waits * (TURNED_AWAY_S + 5.0)
