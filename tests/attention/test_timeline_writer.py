"""What attention writes on the timeline, in the words people read."""

from __future__ import annotations

from dataclasses import asdict

import pytest

from app.attention.desires import Desire, Source
from app.attention.timeline import Timeline
from app.attention.timeline_writer import note_desires, source_words
from app.attention.workspace import Removal, WorkspaceChange
from app.messages import Accomplished, Accomplishment


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (Source("operator", "operator"), "operator"),
        (Source("operator", "Ann"), "operator Ann"),
        (Source("motivation", "ScenarioCoordinator"), "motivation ScenarioCoordinator"),
        (Source("rest", "rest"), "REST client"),
        (Source("rest", "curl"), "REST client curl"),
        (Source("rest", ""), "REST client"),
    ],
)
def test_the_author_of_a_desire_is_named_once(source: Source, words: str) -> None:
    assert source_words(source) == words
    timeline = Timeline(10, lambda: 1.0)
    desire = Desire("d1", "Explore", 8.0, 2.0, False, {}, source, 1.0, None)
    note_desires(timeline, WorkspaceChange((desire,), (), ()))
    (event,) = timeline.query()
    assert event.text == f"{words} desires Explore (intensity 8, utility 2)"
    assert event.data["source"] == asdict(source)


@pytest.mark.parametrize(
    ("outcome", "reason", "text"),
    [
        ("done", "at (1, 2)", "GoTo of operator Ann is done, as Drive reports: at (1, 2)"),
        ("failed", "", "GoTo of operator Ann failed, as Drive reports"),
    ],
)
def test_an_accomplishment_is_noted_before_the_desire_leaves(outcome: Accomplished, reason: str, text: str) -> None:
    timeline = Timeline(10, lambda: 1.0)
    desire = Desire("d1", "GoTo", 8.0, 2.0, False, {}, Source("operator", "Ann"), 1.0, None)
    report = Accomplishment(1.0, "d1", "Drive", outcome, reason)
    note_desires(timeline, WorkspaceChange(removed=(Removal(desire, outcome),), accomplished=((desire, report),)))
    noted, left = timeline.query()
    assert (noted.kind, noted.subject, noted.text) == ("accomplishment", "GoTo", text)
    assert noted.data == {"id": "d1", "class": "GoTo", "behavior": "Drive", "outcome": outcome, "reason": reason}
    assert (left.kind, left.data["change"]) == ("desire", outcome)


def test_what_a_desire_is_about_is_called_by_its_name() -> None:
    timeline = Timeline(10, lambda: 1.0)
    params = {"x": 1.0, "y": 2.0, "place": "robotics-lab", "name": "Robotics lab"}
    desire = Desire("d1", "GoTo", 8.0, 2.0, False, params, Source("operator", "Ann"), 1.0, None)
    report = Accomplishment(1.0, "d1", "Drive", "done", "arrived at (1.00, 2.00)")
    note_desires(timeline, WorkspaceChange((desire,), (), ()))
    note_desires(timeline, WorkspaceChange(removed=(Removal(desire, "done"),), accomplished=((desire, report),)))
    assert [event.text for event in timeline.query()] == [
        "operator Ann desires GoTo 'Robotics lab' (intensity 8, utility 2)",
        "GoTo 'Robotics lab' of operator Ann is done, as Drive reports: arrived at (1.00, 2.00)",
        "desire for GoTo 'Robotics lab' done (intensity 8, utility 2)",
    ]


def test_a_report_alone_changes_no_selection() -> None:
    desire = Desire("d1", "Look", 8.0, 2.0, False, {}, Source("operator", "Ann"), 1.0, None)
    report = Accomplishment(1.0, "d1", "Look", "done")
    assert not note_desires(Timeline(10, lambda: 1.0), WorkspaceChange(accomplished=((desire, report),)))
