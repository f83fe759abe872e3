"""What visitors see of a tour, and whose run it is."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.console.live.visitor_view import NOTHING, is_another_run, is_open, visitor_buttons, visitor_view
from app.messages import OperatorQuestion, TourFailure, TourProgress, TourQuestion
from tests.rehearsal.test_observer import IDLE
from tests.tours.tours import tour

AT_STOP = replace(
    IDLE,
    tour="lab-tour",
    title={"en": "The lab"},
    language="en",
    languages=("en", "fr"),
    state="listening",
    stop="arm",
    number=1,
    stops=2,
    text={"en": "It yields. Push it!", "fr": "Il cède."},
    sentence=1,
    press={"en": "Go on"},
    questions=(TourQuestion("weight", {"en": "How heavy?"}),),
    buttons=("next", "pause", "repeat", "skip", "end"),
    question=OperatorQuestion("The tour is paused. Go on?", ("resume",), "it ends", 9.0),
    people=3,
    failures=(TourFailure("arm", "not reached"),),
    reason="it was paused by Ann",
)
WAITS = replace(IDLE, tour="lab-tour", waits=True, buttons=("start",))


def test_what_concerns_the_operator_alone_is_left_out() -> None:
    view = visitor_view(AT_STOP, "", tour())
    assert view.tour
    assert view.sentences == {"en": ("It yields.", "Push it!"), "fr": ("Il cède.",)}
    assert (view.sentence, view.press, view.buttons) == (1, {"en": "Go on"}, ("next",))
    assert view.questions == AT_STOP.questions
    words = str(view)
    assert not [hidden for hidden in ("Ann", "paused. Go on", "not reached", "'skip'", "people") if hidden in words]


def test_what_is_said_beside_the_text_is_shown_as_it_is_said() -> None:
    assert visitor_view(AT_STOP, "Push it!", tour()).said == "", "it is in the text"
    assert visitor_view(AT_STOP, "One moment, please.", tour()).said == "One moment, please."


@pytest.mark.parametrize("progress", [None, IDLE, replace(IDLE, tour="lab-tour"), replace(WAITS, tour="")])
def test_without_a_tour_there_is_nothing(progress: TourProgress | None) -> None:
    assert not is_open(progress)
    assert visitor_view(progress, "Secret.", tour()) == NOTHING


def test_only_buttons_that_the_tour_waits_for() -> None:
    assert visitor_buttons(replace(AT_STOP, press={}), tour()) == ()
    confirming = replace(AT_STOP, state="confirming", buttons=("agree", "decline", "pause", "end"))
    assert visitor_buttons(confirming, tour()) == ("agree", "decline")
    assert visitor_buttons(replace(AT_STOP, state="inviting", buttons=("decline", "pause", "end")), tour()) == ()
    assert visitor_buttons(WAITS, tour()) == ("start",)
    assert visitor_buttons(WAITS, tour(begin={"by": ["face"]})) == ()
    assert visitor_buttons(WAITS, None) == ()


def test_a_run_ends_with_its_end_and_not_with_its_beginning() -> None:
    begins = replace(WAITS, state="inviting", run="1")
    assert is_another_run(None, WAITS)
    assert not is_another_run(WAITS, begins), "who came while it waited is still there"
    assert not is_another_run(begins, replace(begins, state="leading"))
    assert is_another_run(begins, replace(WAITS, run="1")), "the next ones have another"
    assert not is_another_run(replace(WAITS, run="1"), replace(begins, run="2"))
    assert is_another_run(begins, replace(begins, tour="other"))
    assert is_another_run(replace(begins, tour="", state="idle", waits=False), begins)
