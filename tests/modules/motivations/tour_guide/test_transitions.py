"""The guide: each way from state to state, and each failure."""

from __future__ import annotations

from typing import Any

import pytest

from app.modules.motivations.tour_guide.progress import (
    Asked,
    Called,
    Chosen,
    Clapped,
    Ended,
    Event,
    Heard,
    Pressed,
    Scheduled,
    Spoken,
    State,
    Withdrawn,
)
from tests.modules.motivations.tour_guide.run import WAIT, Run, changed, say, stop


def test_a_tour_from_greeting_to_home() -> None:
    run = Run().started().until("idle")
    assert run.states == [
        *("idle", "inviting", "confirming", "leading", "turning", "presenting"),
        *("leading", "turning", "presenting", "listening", "parting", "going_home", "idle"),
    ]
    assert (run.progress.presented, run.progress.failures) == (("one", "two"), ())
    assert run.progress.reason == "the tour is over"


@pytest.mark.parametrize(
    ("begin", "event", "state"),
    [
        ({"by": ["face"], "for_s": 2}, None, "inviting"),
        ({"by": ["press"]}, None, "idle"),
        ({"by": ["face"], "people_min": 3}, None, "idle"),
        ({"by": ["voice"]}, None, "idle"),
        ({"by": ["press"]}, Scheduled(), "inviting"),
        ({"by": ["face"], "people_min": 9}, Pressed("start"), "inviting"),
    ],
)
def test_who_begins_a_tour(begin: dict[str, Any], event: Event | None, state: State) -> None:
    run = Run(changed(begin=begin)).see()
    assert run.see(*([event] if event else []), after_s=1.9).progress.state == ("idle" if event is None else state)
    assert run.see(after_s=0.2).progress.state == state


def test_a_voice_begins_it_where_it_may() -> None:
    run = Run(changed(begin={"by": ["voice"]})).see().see(after_s=3)
    assert run.progress.state == "idle"
    assert run.see(speaking=True).progress.state == "inviting"


def test_those_who_came_along_are_not_invited_again_before_they_have_left() -> None:
    run = Run().started().until("idle").see(after_s=60)
    assert run.progress.state == "idle"
    assert run.see(people=0, near=0).see(people=2, near=2).see(after_s=3).progress.state == "inviting"


@pytest.mark.parametrize("held", [{"e_stop": True}, {"by_hand": True}, {"battery": 0.39}])
def test_no_tour_begins_that_could_not_go_on(held: dict[str, Any]) -> None:
    run = Run().see(Pressed("start"), **held)
    assert (run.progress.state, run.wishes()) == ("idle", ())
    assert run.progress.reason


@pytest.mark.parametrize(
    ("events", "seen", "state"),
    [
        ([Heard("Yes")], {}, "leading"),
        ([Heard("no")], {}, "idle"),
        ([Heard("maybe")], {}, "confirming"),
        ([Pressed("decline")], {}, "idle"),
        ([], {"after_s": 19.0}, "confirming"),
        ([], {"after_s": 21.0}, "idle"),
    ],
)
def test_an_invitation_is_accepted_or_not(events: list[Event], seen: dict[str, Any], state: State) -> None:
    assert Run().started().until("confirming").see(*events, **seen).progress.state == state


def test_visitors_who_leave_decline() -> None:
    run = Run().started().until("confirming").see(people=0, near=0)
    assert run.see(after_s=4.8).progress.state == "confirming"
    assert run.see(after_s=0.3).progress.state == "idle"


def test_visitors_who_were_never_seen_have_not_left() -> None:
    run = Run().see(Pressed("start"), people=0, near=0).until("confirming")
    assert run.see(after_s=19.0).progress.state == "confirming", "a phone may answer from behind the robot"
    assert run.press("agree").progress.state == "leading"


def test_it_asks_once_more_who_does_not_answer() -> None:
    run = Run().started().until("confirming")
    first = run.wish("Say")
    assert run.done("Say").see(after_s=9.0).wish("Say") == first
    again = run.see(after_s=1.5).wish("Say")
    assert (again.key != first.key, again.params) == (True, first.params)
    assert run.see(after_s=5.0).wish("Say") == again
    assert run.see(Heard("yes")).progress.state == "leading"


def test_without_a_question_it_leads_at_once() -> None:
    run = Run(changed(greeting={"do": [say("Come!")]})).started().until("leading")
    assert "confirming" not in run.states


def test_it_waits_for_those_who_fall_behind_and_goes_on_when_they_come() -> None:
    run = Run().started().until("leading").see(farthest_m=3.0)
    assert run.wish("GoTo").params["speed"] == 0.4, "it slows down"
    assert run.see(farthest_m=2.2).wish("GoTo").params["speed"] == 0.4, "and does not waver"
    assert run.see(farthest_m=1.9).wish("GoTo").params["speed"] == 0.8
    waiting = run.see(farthest_m=4.5)
    assert (waiting.progress.state, waiting.progress.reason) == ("waiting", "visitors fell behind")
    assert [wish.cls for wish in run.moves()] == ["LookAt"]
    assert run.see(farthest_m=3.0).progress.state == "waiting"
    assert run.see(farthest_m=2.4).progress.state == "leading"


def test_it_looks_back_where_it_has_seen_no_one_for_a_while() -> None:
    run = Run().started().until("leading").see(people=0, driven_m=4.9)
    assert run.progress.state == "leading"
    assert run.see(driven_m=5.1).progress.state == "waiting"
    assert run.texts() == []
    assert run.see(after_s=10).texts() == ["I am waiting for you."]
    first = run.wish("Say").key
    assert run.see(after_s=20).wish("Say").key != first, "called again"
    assert run.see(people=2, farthest_m=1.0).progress.state == "leading"
    assert run.see(people=0, driven_m=10.0).progress.state == "leading", "counted from there"


def test_who_waits_too_long_goes_on_with_those_who_are_there_or_ends() -> None:
    run = Run().started().until("leading").see(farthest_m=4.5).see(after_s=61)
    assert run.progress.state == "leading"
    run = Run().started().until("leading").see(farthest_m=4.5).see(people=0, after_s=61)
    assert run.progress.state == "waiting", "they may be where it has not looked"
    run.until("parting")
    assert run.progress.reason == "all visitors have left"


@pytest.mark.parametrize(
    ("events", "seen", "state"),
    [
        ([Heard("next")], {}, "parting"),
        ([Pressed("next")], {}, "parting"),
        ([Clapped(2)], {}, "parting"),
        ([Clapped(1)], {}, "listening"),
        ([Called()], {}, "parting"),
        ([Heard("hello")], {}, "listening"),
        ([], {"after_s": 31.0}, "parting"),
        ([Heard("heavy")], {}, "answering"),
        ([Asked("weight")], {}, "answering"),
        ([Asked("height")], {}, "listening"),
    ],
)
def test_what_ends_listening(events: list[Event], seen: dict[str, Any], state: State) -> None:
    assert Run().started().until("listening").see(*events, **seen).progress.state == state


def test_an_answer_is_said_and_then_it_listens_again() -> None:
    run = Run().started().until("listening").see(after_s=29).see(Asked("weight"))
    assert run.texts() == ["Four kilograms."]
    assert run.done("Say").progress.state == "listening"
    assert run.see(after_s=29).progress.state == "listening", "its time begins again"
    assert run.see(after_s=2).progress.state == "parting"


def test_it_goes_on_when_all_have_left() -> None:
    run = Run().started().until("listening").see(people=0).see(after_s=4.8)
    assert run.progress.state == "listening"
    assert run.see(after_s=0.3).progress.state == "parting"


def test_who_is_heard_has_not_left() -> None:
    run = Run().started().until("listening").see(people=0).see(after_s=3.0, speaking=True).see(speaking=False)
    assert run.see(after_s=4.8).progress.state == "listening"
    assert run.see(after_s=0.3).progress.state == "parting"


@pytest.mark.parametrize("face", ["poster", "place"])
def test_where_it_does_not_look_at_visitors_it_does_not_know_that_they_left(face: str) -> None:
    stops = [stop("one", do=[say("This is one."), WAIT], stand={"face": face}), stop("two")]
    run = Run(changed(stops=stops)).started().until("listening").see(people=0)
    assert run.see(after_s=29.0).progress.state == "listening"
    assert run.see(after_s=2.0).progress.state == "leading"


def test_the_operator_steers_the_tour() -> None:
    run = Run().started().until("leading").press("skip")
    assert (run.wish("GoTo").params["place"], run.progress.skipped) == ("two", (0,))
    assert run.press("undo_skip").wish("GoTo").params["place"] == "one"
    assert run.see(Chosen("two")).wish("GoTo").params["place"] == "two"
    assert run.see(Chosen("three")).wish("GoTo").params["place"] == "two"
    run.until("listening").press("repeat")
    assert run.texts() == ["This is two."]
    assert run.press("skip").progress.state == "parting"
    assert Run().started().press("end").until("idle").progress.reason == "the tour is over"


def test_a_pause_goes_on_with_the_sentence_that_was_interrupted() -> None:
    stops = [stop("one", do=[say("First. Second one. Third!"), say("Then.")])]
    run = Run(changed(stops=stops)).started().until("presenting")
    first = run.wish("Say").key
    run.see(Spoken(first, 1))
    assert run.texts() == ["First. Second one. Third!"]
    assert run.press("pause").moves() == ()
    assert run.see(after_s=300).progress.state == "paused"
    assert run.press("resume").texts() == ["Second one. Third!"]
    second = run.wish("Say").key
    assert second != first
    run.see(Spoken(second, 1)).see(Spoken(first, 0)).press("pause").press("resume")
    assert run.texts() == ["Third!"], "counted from there"
    assert run.done("Say").texts() == ["Then."]
    run.see(Spoken(run.wish("Say").key, 7)).press("pause").press("resume")
    assert run.texts() == ["Then."]


def test_a_paused_tour_can_be_sent_elsewhere_and_goes_there_afterwards() -> None:
    run = Run().started().until("leading").press("pause").press("skip")
    assert (run.progress.state, run.moves()) == ("paused", ())
    assert run.press("resume").wish("GoTo").params["place"] == "two"
    run.press("pause").see(Chosen("one"))
    assert run.press("resume").wish("GoTo").params["place"] == "one"


def test_a_low_battery_ends_the_tour_at_once() -> None:
    run = Run().started().until("presenting").see(battery=0.19)
    assert (run.progress.state, run.progress.reason) == ("parting", "the battery is low")


def test_a_lost_robot_stops_and_says_so() -> None:
    run = Run().started().until("leading").see(localized=False, after_s=3)
    assert (run.progress.state, [wish.cls for wish in run.wishes()]) == ("lost", ["Say"])
    assert run.see(localized=True).progress.state == "leading"
    run.see(localized=False, after_s=3).see(after_s=181)
    assert run.texts() == ["I do not know where I am. I must end the tour here.", "Goodbye."]
    run.until("idle")
    assert (run.wishes(), run.progress.reason) == ((), "the robot does not know where it is")
    assert "going_home" not in run.states
    found = Run().started().until("leading").see(localized=False, after_s=3).see(after_s=181).see(localized=True)
    assert found.until("idle").states[-2] == "going_home", "its pose was found while it said goodbye"


def test_it_is_not_lost_as_it_sets_out_and_mapping_has_just_begun() -> None:
    run = Run().started().until("leading").see(localized=False, after_s=2.5)
    assert (run.progress.state, run.texts()) == ("leading", [])
    assert run.see(localized=False, after_s=1.0).progress.state == "lost"


def test_a_way_home_that_is_blocked_is_tried_thrice() -> None:
    run = Run().started().until("going_home")
    for _ in range(3):
        run.done("GoTo", done=False)
    assert (run.progress.state, run.progress.reason) == ("idle", "the way home is blocked")


def test_without_a_home_it_stays() -> None:
    assert "going_home" not in Run(changed(home=None)).started().until("idle").states


def test_an_outcome_of_an_older_state_is_none() -> None:
    run = Run().started().until("leading")
    old = run.wish("GoTo").key
    run.press("skip").see(Ended(old, True))
    assert run.progress.state == "leading"


def test_why_it_ends_stays_on_the_page() -> None:
    run = Run(changed(farewell={"do": [say("Thank you."), say("Goodbye.")]})).started().until("presenting")
    run.see(battery=0.19).done("Say", only="excuse-battery").done("Say", only=".say")
    assert (run.texts(), run.progress.reason) == (["Goodbye."], "the battery is low")
    assert run.until("going_home").progress.reason == "the battery is low"


def test_a_goal_that_a_person_withdraws_is_a_pause() -> None:
    run = Run().started().until("leading")
    run.see(Withdrawn(run.wish("GoTo").key))
    assert (run.progress.state, run.progress.reason, run.moves()) == ("paused", "its goal was withdrawn", ())
    assert run.see(after_s=30).progress.state == "paused"
    assert run.press("resume").progress.state == "leading"


def test_a_text_that_a_person_withdraws_is_over() -> None:
    run = Run().started().until("presenting")
    run.see(Withdrawn(run.wish("Say").key)).see()
    assert (run.progress.state, run.progress.failures) == ("leading", ())
