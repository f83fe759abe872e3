"""The guide's small parts: claps, sentences, schedule, visitors, changes of desires, buttons, perceptions."""

from __future__ import annotations

import math
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.messages import NavigationStatus
from app.modules.motivations.tour_guide.controls import buttons, operator_question
from app.modules.motivations.tour_guide.desire_changes import desire_changes
from app.modules.motivations.tour_guide.listening import CLAPS_APART_S, Calls, Claps, is_due, sentence_number
from app.modules.motivations.tour_guide.perceptions import awaited_phrases, perceptions
from app.modules.motivations.tour_guide.progress import Button, Called, Clapped, Pressed, Progress, State
from app.modules.motivations.tour_guide.senses import Senses
from app.modules.motivations.tour_guide.transitions import advance
from app.modules.motivations.tour_guide.visitors import HEARD_S, SEEN_S, Visitors
from app.modules.motivations.tour_guide.wishes import Wish
from app.tours.model import Slot
from tests.modules.motivations.tour_guide.run import LAB, Run, changed


def test_claps_in_a_row_are_counted_once_it_is_over() -> None:
    claps = Claps()
    assert claps.counted(0.0) is None
    claps.hear(10.0)
    claps.hear(10.5)
    assert claps.counted(10.6) is None
    assert claps.counted(10.6 + CLAPS_APART_S) == Clapped(2)
    assert claps.counted(20.0) is None
    claps.hear(30.0)
    claps.hear(40.0)
    assert claps.counted(42.0) == Clapped(1)


def test_a_call_is_a_noise_while_a_voice_sounds() -> None:
    calls = Calls()
    calls.hear(10.0)
    assert calls.called() is None, "a clap"
    calls.locate(10.4)
    assert calls.called() == Called()
    calls.locate(10.6)
    assert calls.called() is None, "each once"
    calls.hear(20.0)
    assert calls.called() is None, "long after the voice"


def test_sentences_are_counted_also_where_two_are_the_same() -> None:
    text = "Look. Look. There!"
    assert sentence_number(text, "Look.", 0) == 0
    assert sentence_number(text, "Look.", 1) == 1
    assert sentence_number(text, "There!", 0) == 2
    assert sentence_number(text, "Something else.", 1) == 1


def test_a_tour_is_due_once_in_its_minute() -> None:
    at = time.mktime((2026, 11, 24, 14, 0, 0, 0, 0, -1))  # a Tuesday, in the time of this place
    slots = (Slot.model_validate({"days": ["tue"], "times": ["14:00"]}),)
    assert is_due(slots, at - 0.1, at + 0.1)
    assert not is_due(slots, at + 0.1, at + 0.3)
    assert not is_due(slots, at - 0.3, at - 0.1)
    assert not is_due(slots, at + 86400 - 0.1, at + 86400 + 0.1)


def around(visitors: Visitors, now: float, at: Pose2 | None = None, *, behind: bool = False) -> tuple[int, float]:
    people = visitors.around(now, at or Pose2(), within_m=2.0, behind=behind)
    return people.people, people.farthest_m


def test_visitors_are_there_while_they_are_seen_and_some_seconds_after() -> None:
    visitors = Visitors()
    visitors.see(10.0, {1: (1.0, 0.0), 2: (0.0, 3.0)})
    assert around(visitors, 10.0) == (2, 3.0)
    assert visitors.around(10.0, Pose2(), within_m=2.0, behind=False).near == 1
    visitors.see(12.0, {1: (1.0, 0.0)})
    assert around(visitors, 10.0 + SEEN_S + 0.1) == (1, 1.0)
    assert around(visitors, 20.0) == (0, 0.0)


def test_who_is_ahead_does_not_follow() -> None:
    visitors = Visitors()
    visitors.see(10.0, {1: (3.0, 0.0), 2: (-1.0, 0.5)})
    assert around(visitors, 10.0, behind=True)[0] == 1
    assert around(visitors, 10.0, Pose2(0, 0, math.pi), behind=True)[0] == 1


def test_it_looks_for_visitors_where_they_are_were_heard_or_must_be() -> None:
    visitors = Visitors()

    def towards(now: float, at: Pose2) -> float | None:
        visitors.drive(at)
        return visitors.around(now, at, within_m=2.0, behind=False).towards

    assert towards(0.0, Pose2()) is None
    visitors.see(1.0, {1: (0.0, 1.0), 2: (0.0, 3.0)})
    assert towards(1.0, Pose2()) == pytest.approx(math.pi / 2), "the middle of them"
    assert towards(5.0, Pose2(0.3, 0.0)) == pytest.approx(math.atan2(2.0, -0.3)), "where they were"
    for count in range(1, 20):
        towards(5.0 + count, Pose2(0.3 + 0.2 * count, 0.0))
    assert towards(30.0, Pose2(4.2, 0.0)) == pytest.approx(math.pi), "back along the way"
    visitors.hear(31.0, 2.0)
    assert towards(31.0, Pose2(4.2, 0.0)) == 2.0
    assert towards(31.1 + HEARD_S, Pose2(4.2, 0.0)) == pytest.approx(math.pi)


keys = st.sampled_from(["1.say", "2.say", "face", "slam"])
wished = st.builds(Wish, keys, st.sampled_from(["Say", "GoTo"]), st.sampled_from([{}, {"x": 1}, {"x": 2}]))


@given(st.lists(wished, unique_by=lambda w: w.key), st.lists(wished, unique_by=lambda w: w.key), st.sets(keys))
def test_changes_lead_from_what_is_held_to_what_is_wanted(
    before: list[Wish], wanted: list[Wish], spent: set[str]
) -> None:
    held = {wish.key: wish for wish in before}
    changes = desire_changes(held, wanted, spent)
    after = dict(held)
    for key in changes.withdraw:
        del after[key]
    for wish in changes.change:
        assert after[wish.key].cls == wish.cls
        after[wish.key] = wish
    for wish in changes.add:
        assert wish.key not in after
        after[wish.key] = wish
    assert after == {wish.key: wish for wish in wanted if wish.key not in spent}
    assert not desire_changes(after, wanted, spent)


BUTTONS: tuple[Button, ...] = (
    *("agree", "decline", "next", "pause", "resume", "retry", "skip", "undo_skip", "repeat", "end"),
)
STATES: tuple[State, ...] = ("inviting", "confirming", "leading", "presenting", "listening", "parting", "going_home")


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("paused", [False, True])
def test_the_buttons_that_are_offered_are_those_that_do_something(state: State, paused: bool) -> None:
    run = Run().started().until(state)
    if paused:
        run.press("pause")
    offered = buttons(run.progress, e_stop=False)
    for button in BUTTONS:
        seen = run.view.__class__(run.view.now, people=2, farthest_m=1.0, near=2, events=(Pressed(button),))
        after = advance(run.progress, seen, run.scene)
        assert (
            after
            != advance(run.progress, run.view.__class__(run.view.now, people=2, farthest_m=1.0, near=2), run.scene)
        ) == (button in offered), button


def test_the_operator_is_asked_with_a_default_and_a_time() -> None:
    run = Run(changed(on_failure={"reach": {"retry": 0, "ask_s": 20, "then": "end"}})).started().until("leading")
    assert operator_question(run.progress, run.scene) is None
    run.done("GoTo", done=False)
    question = operator_question(run.progress, run.scene)
    assert question is not None
    assert (question.answers, question.default) == (("retry", "skip", "end"), "the tour ends")
    assert question.until == run.progress.since + 20
    run.press("pause")
    question = operator_question(run.progress, run.scene)
    assert question is not None
    assert question.answers == ("resume", "end")


def test_it_perceives_what_the_state_is_about() -> None:
    run = Run()

    def classes() -> set[str]:
        return {wish.cls for wish in perceptions(run.progress, run.scene)}

    assert classes() == {"LocateFaces"}, "visitors begin it by their faces"
    run.started().until("confirming")
    assert classes() == {"LocateFaces", "LocateVoices", "ListenForWords"}
    assert awaited_phrases(run.progress, run.scene) == ("yes", "no")
    assert "LocateFaces" not in {wish.cls for wish in perceptions(run.until("leading").progress, run.scene)}
    assert {"SLAM", "LocateVoices"} <= classes()
    run.until("listening")
    assert "DetectNoises" in classes()
    assert awaited_phrases(run.progress, run.scene) == ("next", "heavy")


def navigated(senses: Senses, now: float, state: str, remaining_m: float) -> float | None:
    """Since when the way is not free, after this status."""
    goal = Pose2(5.0, 0.0)
    senses.take_navigation(NavigationStatus(now, "PlanAndFollowPath", state, "", goal=goal, remaining_m=remaining_m))
    return senses.view(now, LAB, Progress(), diverted=False, events=()).stuck_since


def test_a_way_where_navigation_waits_and_tries_by_turns_is_not_free() -> None:
    senses = Senses(by_hand="Teleop", voice=0.5)
    assert navigated(senses, 10.0, "following", 3.0) is None
    assert navigated(senses, 11.0, "waiting", 2.5) == 11.0
    assert navigated(senses, 14.0, "following", 2.4) == 11.0
    assert navigated(senses, 16.0, "recovering", 2.6) == 11.0
    assert navigated(senses, 18.0, "following", 1.9) is None, "it came through"
    navigated(senses, 30.0, "waiting", 1.5)
    assert navigated(senses, 36.5, "following", 4.0) is None, "another way is longer, and free"
