"""Words by which visitors steer a tour."""

from __future__ import annotations

from typing import Any

import pytest

from app.modules.motivations.tour_guide.kept import KeptRun, after_restart
from app.modules.motivations.tour_guide.perceptions import awaited_phrases
from app.modules.motivations.tour_guide.progress import Heard, State
from app.tours.model import Tour
from app.tours.tour_file import digest
from tests.modules.motivations.tour_guide.run import LAB, Run

COMMANDS = {
    "pause": {"en": ["wait please"]},
    "resume": {"en": ["go on"]},
    "skip": {"en": ["skip this"]},
    "undo_skip": {"en": ["go back"]},
    "repeat": {"en": ["once more"]},
    "end": {"en": ["stop the tour"], "fr": ["fin"]},
}


def steered() -> Tour:
    plain: dict[str, Any] = LAB.model_dump(by_alias=True)
    first, second = plain["stops"]
    return LAB.model_validate(plain | {"commands": COMMANDS, "stops": [first, second | {"words": {"en": ["the arm"]}}]})


@pytest.mark.parametrize(
    ("begin", "phrase", "state", "stop"),
    [
        ("leading", "wait please", "paused", 0),
        ("presenting", "Once more", "presenting", 0),
        ("presenting", "skip this", "leading", 1),
        ("presenting", "the arm", "leading", 1),
        ("leading", "fin", "parting", 0),
        ("leading", "once more", "leading", 0),
        ("leading", "nonsense", "leading", 0),
        ("confirming", "stop the tour", "confirming", 0),
        ("going_home", "wait please", "going_home", 1),
    ],
)
def test_words_do_what_buttons_do(begin: State, phrase: str, state: State, stop: int) -> None:
    run = Run(steered()).started().until(begin)
    entry = run.progress.entry
    run.see(Heard(phrase))
    assert (run.progress.state, run.progress.stop) == (state, stop)
    assert (run.progress.entry == entry) == (
        phrase in ("nonsense", "once more") or begin in ("confirming", "going_home")
    )


def test_what_was_skipped_is_gone_back_to() -> None:
    run = Run(steered()).started().until("presenting").see(Heard("skip this")).see(Heard("go back"))
    assert (run.progress.state, run.progress.stop, run.progress.skipped) == ("leading", 0, ())


def test_a_pause_that_a_visitor_asked_for_ends_with_a_word_or_a_press() -> None:
    run = Run(steered()).started().until("leading").see(Heard("wait please"))
    assert run.progress.reason == "a visitor asked for a pause"
    assert run.moves() == ()
    assert awaited_phrases(run.progress, run.scene) == ("go on", "stop the tour")
    assert run.see(Heard("skip this"), after_s=60).progress.state == "paused"
    assert run.see(Heard("go on")).progress.state == "leading"
    assert run.see(Heard("wait please")).press("resume").progress.state == "leading"


def test_a_word_ends_no_pause_of_the_operators_and_none_by_the_emergency_stop() -> None:
    run = Run(steered()).started().until("leading").press("pause")
    assert awaited_phrases(run.progress, run.scene) == ()
    assert run.see(Heard("go on")).progress.state == "paused"
    assert run.see(Heard("stop the tour")).progress.state == "paused"
    run.press("resume").see(Heard("wait please")).see(e_stop=True).see(e_stop=False)
    assert run.progress.excuse == "e_stop"
    assert run.see(Heard("go on")).progress.state == "paused", "nothing moves before a press"
    assert run.press("resume").progress.state == "leading"


def test_an_operators_pause_takes_over_that_of_a_visitor() -> None:
    run = Run(steered()).started().until("leading").see(Heard("wait please")).press("pause")
    assert run.see(Heard("go on")).progress.state == "paused"


def test_after_a_restart_a_press_is_needed() -> None:
    run = Run(steered()).started().until("leading").see(Heard("wait please"))
    run.progress = after_restart(KeptRun(digest(run.scene.tour), 0.0, run.progress), 1.0, run.view, run.scene)
    assert run.see(Heard("go on")).progress.state == "paused"


def test_what_is_waited_for_comes_before_the_commands() -> None:
    run = Run(steered()).started().until("listening")
    assert awaited_phrases(run.progress, run.scene) == (
        *("next", "heavy", "wait please", "skip this", "go back", "once more", "stop the tour", "the arm"),
    )
    assert run.see(Heard("next")).progress.state == "parting"


def test_a_tour_without_commands_listens_for_none() -> None:
    run = Run().started().until("leading")
    assert awaited_phrases(run.progress, run.scene) == ()
