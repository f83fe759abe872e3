"""What the guide desires: where it goes, what it says, and to whom it turns."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from tests.modules.motivations.tour_guide.run import Run, changed, say, stop


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


def test_on_its_way_home_it_asks_to_pass_too() -> None:
    run = Run().started().until("going_home")
    stuck = run.view.now
    assert run.see(stuck_since=stuck, after_s=8.1).texts() == ["Excuse me, may I pass?"]
    assert run.wish("GoTo").params["place"] == "dock", "it goes on meanwhile"


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
