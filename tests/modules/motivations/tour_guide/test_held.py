"""A robot that is driven by hand or stopped: nothing of a tour moves it; and what holds whatever happens."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.modules.motivations.tour_guide.controls import buttons
from app.modules.motivations.tour_guide.progress import (
    Asked,
    Button,
    Chosen,
    Clapped,
    CodeRead,
    Ended,
    Event,
    Heard,
    Pressed,
    Scheduled,
    Spoken,
    Withdrawn,
)
from tests.modules.motivations.tour_guide.run import ACHIEVEMENTS, DRIVES, Run, changed


def test_hands_pause_it_and_it_plans_from_there_once_they_are_off() -> None:
    run = Run().started().until("leading").see(by_hand=True)
    assert (run.progress.state, run.moves()) == ("paused", ())
    run.see(after_s=100).see(by_hand=False, after_s=0.5)
    assert run.progress.state == "paused"
    assert run.see(after_s=1.1).progress.state == "leading"


def test_nothing_moves_after_the_emergency_stop_before_a_press() -> None:
    run = Run().started().until("leading").see(by_hand=True).see(e_stop=True)
    run.press("resume")
    assert run.progress.state == "paused", "it is latched still"
    run.see(e_stop=False, by_hand=False).see(after_s=60)
    assert (run.progress.state, run.moves()) == ("paused", ())
    assert run.press("resume").progress.state == "leading"
    ended = Run().started().until("leading").see(Pressed("end"), e_stop=True).see(Pressed("end")).see(e_stop=False)
    assert (ended.see(after_s=60).progress.state, ended.wishes()) == ("idle", ()), "not even home"
    run.see(e_stop=True).see(e_stop=False).see(after_s=601)
    assert (run.progress.state, run.progress.reason) == ("idle", "it was paused too long")


@pytest.mark.parametrize("begins", ["a face", "a voice", "the schedule", "a word", "start"])
def test_nothing_begins_after_the_emergency_stop_before_a_press(begins: str) -> None:
    run = Run(changed(begin={"by": ["press", "voice" if begins == "a voice" else "face"]}))
    events: dict[str, Event] = {
        "the schedule": Scheduled(),
        "a word": Heard("yes"),
        "start": Pressed("start"),
    }
    event = events.get(begins)
    run.see(people=0, near=0).see(e_stop=True).see(e_stop=False, after_s=60)
    run.see(people=2, near=2, speaking=True).see(*([event] if event else []), after_s=30).see(after_s=30)
    assert (run.progress.state, run.wishes()) == ("idle", ())
    assert run.progress.reason == "the emergency stop was pressed: press Resume"
    assert buttons(run.progress, e_stop=False) == ("resume",)
    assert buttons(run.progress, e_stop=True) == ()
    run.press("resume")
    assert (run.progress.state, run.progress.reason) == ("inviting", ""), "they are there still"


def test_a_press_while_the_emergency_stop_is_latched_frees_nothing() -> None:
    run = Run().see(people=0, near=0, e_stop=True).press("resume").press("start").see(e_stop=False)
    assert run.see(Scheduled()).progress.state == "idle"
    assert run.press("resume").press("start").progress.state == "inviting"


@pytest.mark.parametrize("ends", ["end", "its time"])
def test_a_tour_that_ends_during_the_emergency_stops_pause_is_followed_by_none(ends: str) -> None:
    run = Run().started().until("leading").see(e_stop=True)
    if ends == "end":
        run.press("end").see(e_stop=False)
    else:
        run.see(e_stop=False).see(after_s=601)
    assert run.progress.state == "idle"
    run.see(people=0, near=0).see(people=2, near=2).see(after_s=60).see(Scheduled())
    assert (run.progress.state, run.wishes()) == ("idle", ())
    assert run.press("resume").see(Scheduled()).progress.state == "inviting"


def test_resume_after_a_pause_by_the_emergency_stop_holds_nothing_any_more() -> None:
    run = Run().started().until("leading").see(e_stop=True).see(e_stop=False).press("resume").until("idle")
    run.see(people=0, near=0).see(people=2, near=2)
    assert run.see(after_s=3).progress.state == "inviting"


def test_an_emergency_stop_that_withdraws_the_goal_first_is_named() -> None:
    run = Run().started().until("leading")
    run.see(Withdrawn(run.wish("GoTo").key))
    assert (run.progress.state, run.progress.reason) == ("paused", "its goal was withdrawn")
    run.see(e_stop=True)
    assert run.progress.reason == "the emergency stop was pressed"
    assert run.texts() == ["I was stopped. One moment, please."]


@pytest.mark.parametrize("button", ["end", "resume"])
def test_a_press_does_not_move_a_robot_that_is_driven_by_hand(button: Button) -> None:
    run = Run().started().until("leading").see(by_hand=True, towards=0.5)
    assert run.see(Pressed(button)).progress.state == "paused"
    assert run.moves() == ()
    assert run.see(by_hand=False).see(after_s=2.0).progress.state == ("parting" if button == "end" else "leading")


CODES = ["HBBA:STOP/ONE/EN/MIND THE STEP.", "HBBA:SAY/EN/HELLO."]


presses: st.SearchStrategy[Button] = st.sampled_from(
    ["start", "agree", "decline", "next", "pause", "resume", "retry", "skip", "undo_skip", "repeat", "end"]
)


events = st.one_of(
    presses.map(Pressed),
    st.sampled_from([Chosen("one"), Chosen("two"), Asked("weight"), Heard("next"), Heard("yes"), Heard("heavy")]),
    st.sampled_from(CODES).map(CodeRead),
    st.sampled_from([Clapped(2), Scheduled(), Ended("3.go", True), Spoken("2.say", 1)]),
)


seen = st.fixed_dictionaries(
    {"after_s": st.sampled_from([0.1, 1.0, 12.0, 65.0])},
    optional={
        "people": st.integers(0, 3),
        "farthest_m": st.sampled_from([0.5, 3.0, 6.0]),
        "driven_m": st.floats(0, 100),
        "battery": st.sampled_from([None, 0.1, 0.9]),
        "e_stop": st.booleans(),
        "by_hand": st.booleans(),
        "localized": st.booleans(),
        "towards": st.sampled_from([None, 0.5, 3.0]),
        "stuck_since": st.sampled_from([None, 0.0]),
    },
)


moments = st.tuples(seen, st.one_of(st.none(), events), st.sampled_from(["", "done", "failed"]))


@settings(max_examples=50)
@given(st.lists(moments, max_size=60))
def test_whatever_happens(happening: list[tuple[dict[str, Any], Event | None, str]]) -> None:
    """It drives only in the states that drive, never between an emergency stop and a press, and always comes to an
    end."""
    run, held = Run(changed(accept=CODES)).started(), False
    for changes, event, outcome in happening:
        ended = [Ended(wish.key, outcome == "done") for wish in run.wishes() if outcome and wish.cls in ACHIEVEMENTS]
        run.see(*ended, *([event] if event else []), **changes)
        progress = run.progress
        if run.view.e_stop:
            held = True
        elif event == Pressed("resume"):
            held = False
        drives = any(wish.cls == "GoTo" for wish in run.wishes())
        assert not (run.moves() and (held or run.view.e_stop or run.view.by_hand))
        assert not drives or progress.state in DRIVES
        assert not (drives and (held or run.view.e_stop or run.view.by_hand))
        assert 0 <= progress.stop < len(run.scene.tour.stops)
        assert len({wish.key for wish in run.wishes()}) == len(run.wishes())
    run.see(e_stop=False, by_hand=False, localized=True, people=0, near=0)
    for _ in range(100):
        ended = [Ended(wish.key, False) for wish in run.wishes() if wish.cls == "GoTo"]
        run.see(*ended, after_s=25.0)
    assert run.progress.state == "idle"
