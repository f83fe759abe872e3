"""The guide: each way from state to state, and each failure."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from app.maps.poster_places import Poster
from app.modules.motivations.tour_guide.progress import (
    Asked,
    Called,
    Chosen,
    Clapped,
    Ended,
    Event,
    Failure,
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


def test_each_state_desires_what_it_is_about() -> None:
    run = Run().started()
    assert run.texts() == ["Hello."]
    assert run.until("confirming").texts() == ["Shall I?"]
    going = run.press("agree").wish("GoTo")
    assert going.params == {"x": 1, "y": 2, "place": "one", "tolerance_m": 0.3, "tolerance_rad": 0.2, "speed": 0.8}
    assert run.until("turning").wish("TrackFace").params == {}
    assert run.until("presenting").texts() == ["This is one."]
    assert run.until("listening").wishes() == ()
    assert run.until("parting").texts() == ["Goodbye."]
    assert run.until("going_home").wish("GoTo").params["place"] == "dock"
    assert run.until("idle").wishes() == ()


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


@pytest.mark.parametrize(
    ("then", "state", "stop_id"),
    [("skip", "leading", "two"), ("present_from_here", "presenting", "one"), ("end", "parting", "one")],
)
def test_a_stop_that_cannot_be_reached(then: str, state: State, stop_id: str) -> None:
    run = Run(changed(on_failure={"reach": {"retry": 1, "ask_s": 20, "then": then}})).started().until("leading")
    first = run.wish("GoTo").key
    assert run.done("GoTo", done=False).wish("GoTo").key != first, "tried again"
    assert run.done("GoTo", done=False).progress.state == "blocked"
    assert run.texts() == ["Excuse me, may I pass?"]
    assert run.see(after_s=19).progress.state == "blocked"
    assert run.see(after_s=2).progress.state == state
    assert run.scene.tour.stops[run.progress.stop].id == stop_id
    assert run.progress.failures == (Failure("one", "not reached"),)


def test_a_wait_for_visitors_is_no_new_try() -> None:
    run = Run(changed(on_failure={"reach": {"retry": 1}})).started().until("leading").done("GoTo", done=False)
    assert run.see(farthest_m=4.5).progress.state == "waiting"
    assert run.see(farthest_m=1.0).progress.state == "leading"
    assert run.done("GoTo", done=False).progress.state == "blocked"
    again = Run(changed(on_failure={"reach": {"retry": 1}})).started().until("leading").done("GoTo", done=False)
    again.see(farthest_m=4.5).press("skip").see(farthest_m=1.0)
    assert again.done("GoTo", done=False).progress.state == "leading", "the next stop has tries of its own"


def test_the_operator_is_asked_before_a_stop_is_given_up() -> None:
    run = Run(changed(on_failure={"reach": {"retry": 0}})).started().until("leading").done("GoTo", done=False)
    assert run.press("retry").progress.state == "leading"
    run.done("GoTo", done=False).press("skip")
    assert run.wish("GoTo").params["place"] == "two"
    unasked = changed(on_failure={"reach": {"retry": 0, "ask_s": 0}})
    run = Run(unasked).started().until("leading").done("GoTo", done=False)
    assert run.wish("GoTo").params["place"] == "two"


@pytest.mark.parametrize(("then", "state"), [("continue", "turning"), ("skip", "leading"), ("end", "parting")])
def test_a_step_that_fails(then: str, state: State) -> None:
    stops = [stop("one", do=[say("First."), say("Second.")]), stop("two")]
    run = Run(changed(stops=stops, on_failure={"present": {"retry": 1, "then": then}})).started().until("presenting")
    run.done("Say", done=False)
    assert run.texts() == ["First."], "tried again"
    run.done("Say", done=False)
    assert run.progress.failures == (Failure("one", "a text was not said"),)
    if then == "continue":
        assert run.see().texts() == ["Second."]
    else:
        assert run.progress.state == state


def test_a_step_that_reports_nothing_fails_in_the_end() -> None:
    run = Run().started().until("presenting").see(after_s=181)
    assert run.progress.failures == (Failure("one", "a text was not said"),)


def test_all_of_a_step_goes_on_at_once_and_all_of_it_is_awaited() -> None:
    step = say("Look there!") | {"point": [1, 2, 1], "look": "visitors", "expression": "happy"}
    run = Run(changed(stops=[stop("one", do=[step])])).started().until("presenting")
    assert [wish.cls for wish in run.wishes()] == ["Say", "PointAt", "Express", "TrackFace"]
    assert run.done("Say").progress.state == "presenting"
    assert run.done("PointAt").progress.state == "parting"


def test_a_poster_is_looked_at_by_its_text() -> None:
    step = say("See?") | {"look": "poster"}
    run = Run(changed(stops=[stop("one", do=[step], poster="HBBA:STOP/ONE")])).started().until("presenting")
    assert run.wish("LookAt").params == {"place": "HBBA:STOP/ONE"}


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


def test_a_place_that_is_gone_is_passed_over_and_noted() -> None:
    run = Run(missing="one").started().until("leading")
    assert run.wish("GoTo").params["place"] == "two"
    assert run.progress.failures == (Failure("one", "there is no place one"),)
    run = Run(missing="dock").started().until("idle")
    assert run.progress.reason == "there is no place dock"


def test_a_stop_that_is_presented_from_beside_its_place_is_noted() -> None:
    run = Run().started().until("leading").see(X_MB=(1.3, 2.2, 0.0)).until("presenting")
    assert run.progress.failures == (Failure("one", "presented 0.36 m from its place"),)
    run = Run().started().until("leading").see(X_MB=(1.3, 2.1, 0.0)).until("presenting")
    assert run.progress.failures == (), "a pose is corrected by some centimetres"


@pytest.mark.parametrize(
    ("face", "turned", "noted"),
    [("place", 0.5, "presented turned 29° from its place"), ("place", 0.22, ""), ("visitors", 3.0, "")],
)
def test_a_stop_that_is_presented_turned_away_is_noted(face: str, turned: float, noted: str) -> None:
    run = Run(changed(stops=[stop("one", stand={"face": face})]))
    run.scene = replace(run.scene, places={"one": {"x": 1.0, "y": 2.0, "heading": 3.0}})
    run.started().until("leading").see(X_MB=(1.0, 2.0, 3.0 + turned - math.tau)).until("presenting")
    assert [failure.what for failure in run.progress.failures] == [noted] * bool(noted)


@pytest.mark.parametrize(
    ("stand", "posters", "heading"),
    [
        ("poster", [Poster(1, "P", 1.0, 4.0, None), Poster(2, "P", 9.0, 2.0, None)], 1.57),
        ("poster", [Poster(1, "other", 1.0, 4.0, None)], 0.5),
        ("place", [Poster(1, "P", 1.0, 4.0, None)], 0.5),
    ],
)
def test_it_stands_turned_to_the_poster_where_the_map_knows_that(
    stand: str, posters: list[Poster], heading: float
) -> None:
    run = Run(changed(stops=[stop("one", poster="P", stand={"face": stand})]))
    run.scene = replace(run.scene, places={"one": {"x": 1.0, "y": 2.0, "heading": 0.5}}, posters=tuple(posters))
    assert run.started().until("leading").wish("GoTo").params["heading"] == heading
    run.see(X_MB=(1.0, 2.0, heading)).until("presenting")
    assert (run.progress.failures, "turning" in run.states) == ((), False)
    turned = Run(run.scene.tour)
    turned.scene = run.scene
    turned.started().until("leading").see(X_MB=(1.0, 2.0, heading + 1.0)).until("presenting")
    assert [failure.what for failure in turned.progress.failures] == ["presented turned 57° from its place"]


def test_on_its_way_home_it_asks_to_pass_too() -> None:
    run = Run().started().until("going_home")
    stuck = run.view.now
    assert run.see(stuck_since=stuck, after_s=8.1).texts() == ["Excuse me, may I pass?"]
    assert run.wish("GoTo").params["place"] == "dock", "it goes on meanwhile"


def test_what_is_left_out_is_passed_over() -> None:
    run = Run(changed(stops=[stop("one", left_out=True), stop("two")])).started().until("idle")
    assert run.progress.presented == ("two",)


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


def test_people_in_its_way_are_asked_to_let_it_pass_twice() -> None:
    run = Run().started().until("leading").see(stuck_since=0.0)
    assert run.texts() == [], "not for what was before"
    stuck = run.view.now
    run.see(stuck_since=stuck, after_s=8.1)
    assert run.texts() == ["Excuse me, may I pass?"]
    first = run.wish("Say").key
    assert run.see(after_s=5).wish("Say").key == first
    assert run.see(after_s=8).wish("Say").key != first, "asked again"
    assert run.wish("GoTo").params["place"] == "one", "it goes on meanwhile"
    assert run.see(stuck_since=None).texts() == []


def test_it_faces_visitors_and_turns_after_them() -> None:
    run = Run().started().see(towards=0.5)
    assert run.wish("RotateToHeading").params == {"heading": 0.5}
    assert run.see(towards=0.7).wish("RotateToHeading").params == {"heading": 0.5}, "that is the head's"
    assert run.see(towards=1.0).wish("RotateToHeading").params == {"heading": 1.0}
    run.until("leading")
    assert [wish.cls for wish in run.wishes()] == ["GoTo"], "it looks where it goes"
    for state in ("turning", "presenting", "listening", "parting"):
        assert run.until(state).wish("RotateToHeading").params == {"heading": 1.0}


def test_it_does_not_turn_to_visitors_while_it_points() -> None:
    points = say("There it is.") | {"point": [1.0, 2.0, 1.0]}
    run = Run(changed(stops=[stop("one", do=[points]), stop("two")])).started().see(towards=0.5).until("presenting")
    assert sorted(wish.cls for wish in run.wishes()) == ["PointAt", "Say"]
    run.done("PointAt")
    assert run.wish("RotateToHeading").params == {"heading": 0.5}, "it is still speaking"


def test_it_greets_those_it_sees_and_turns_to_nobody_else() -> None:
    run = Run().see(people=0, near=0, towards=3.0).started()
    assert [wish.cls for wish in run.wishes()] == ["Say"]
    assert run.see(speaking=True).wish("RotateToHeading").params == {"heading": 3.0}


def test_a_stop_where_it_stands_as_the_place_says_is_not_turned_at() -> None:
    stops = [stop("one", stand={"face": "place"}), stop("two")]
    run = Run(changed(stops=stops)).started().see(towards=0.5).until("presenting")
    assert "turning" not in run.states
    assert "RotateToHeading" not in [wish.cls for wish in run.wishes()]


def test_looking_back_is_turning_round() -> None:
    run = Run().started().until("leading").see(people=0, driven_m=5.0, towards=3.0)
    assert run.see().progress.state == "waiting"
    assert run.wish("RotateToHeading").params == {"heading": 3.0}


@pytest.mark.parametrize(
    ("held", "text"),
    [({"by_hand": True}, "One moment, please."), ({"e_stop": True}, "I was stopped. One moment, please.")],
)
def test_a_pause_is_said(held: dict[str, Any], text: str) -> None:
    assert Run().started().until("leading").see(**held).texts() == [text]


def test_an_end_that_visitors_do_not_expect_is_said_first() -> None:
    run = Run().started().until("presenting").see(battery=0.19)
    assert run.texts() == ["My battery is low. I must end the tour here.", "Goodbye."]
    assert run.done("Say", only="excuse-battery").progress.state == "parting", "goodbye is awaited, too"
    silent = Run(changed(farewell={"do": []})).started().until("presenting").see(battery=0.19)
    assert silent.texts() == ["My battery is low. I must end the tour here."]
    assert silent.done("Say").progress.state == "going_home"


@pytest.mark.parametrize(
    ("then", "text"),
    [
        ("skip", "I cannot get there, so I leave it out."),
        ("present_from_here", "I cannot get any nearer, so I explain it from here."),
        ("end", "I cannot get any further. I must end the tour here."),
    ],
)
def test_a_stop_that_is_given_up_is_said(then: str, text: str) -> None:
    run = Run(changed(on_failure={"reach": {"retry": 0, "ask_s": 0, "then": then}})).started().until("leading")
    assert run.done("GoTo", done=False).texts()[0] == text
    after = run.done("Say", done=False, only="excuse-" + run.progress.excuse)
    assert after.progress.failures == (Failure("one", "not reached"),), "no step fails where nothing can be said"


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


def test_what_is_doubtful_about_a_place_is_noted_and_the_stop_presented() -> None:
    run = Run()
    run.scene = replace(run.scene, doubts={"one": "its poster is gone"})
    assert run.started().until("idle").progress.presented == ("one", "two")
    assert run.progress.failures == (Failure("one", "its poster is gone"),)


@pytest.mark.parametrize("face", ["visitors", "place"])
@pytest.mark.parametrize(
    ("doubt", "excuses"),
    [
        ("its poster is not known on this map: it was removed, or not seen yet", True),
        ("its poster hangs 2.1 m from where it was: place it again", True),
        ("it is in an obstacle of the map", False),
    ],
)
def test_a_poster_that_is_gone_is_said_as_it_arrives(doubt: str, excuses: bool, face: str) -> None:
    run = Run(changed(stops=[stop("one", stand={"face": face}), stop("two")]))
    run.scene = replace(run.scene, doubts={"one": doubt})
    said = ["Excuse me, the poster is not where I knew it."] * excuses
    assert run.started().until("presenting").texts() == [*said, "This is one."]
    if excuses:
        run.done("Say", done=False, only="excuse-poster")
        assert run.progress.failures == (Failure("one", doubt),), "no step fails where nothing can be said"
    assert run.press("repeat").texts() == ["This is one."], "said once"
    assert run.until("leading").until("presenting").texts() == ["This is two."]
    assert Run().started().until("presenting").texts() == ["This is one."]


def test_that_a_poster_is_gone_is_said_in_the_tours_language() -> None:
    run = Run()
    run.scene = replace(run.scene, language="fr", doubts={"one": "its poster is gone"})
    assert run.started().until("presenting").texts()[0] == "Excusez-moi, l'affiche n'est pas là où je la connaissais."


def test_it_charges_at_home_until_it_is_moved() -> None:
    run = Run()
    run.scene = replace(run.scene, docks=True)
    assert [wish.cls for wish in run.started().until("idle").wishes()] == ["Dock"]
    run.press("start").see(towards=1.0, docked=True)
    assert [wish.cls for wish in run.wishes()] == ["Dock", "Say"], "it stays there while it greets, and does not turn"
    assert "Dock" not in [wish.cls for wish in run.until("leading").wishes()]
    again = run.until("idle")
    assert [wish.cls for wish in again.wishes()] == ["Dock"]
    assert again.see(by_hand=True).see(by_hand=False).wishes() == ()
