"""What attention writes on the timeline, in the words people read."""

from __future__ import annotations

import pytest

from app.attention.desires import Desire, Source
from app.attention.timeline import Timeline
from app.attention.timeline_writer import note_desires, source_words
from app.attention.workspace import WorkspaceChange


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
    assert event.data["source"] == {"kind": source.kind, "name": source.name}
