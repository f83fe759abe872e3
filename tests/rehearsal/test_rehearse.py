"""A whole tour, rehearsed: two visitors are led round a pillar to a stop, and what would go wrong is found."""

from __future__ import annotations

import itertools
import math
from typing import Any

import pytest

from app.base import paths
from app.maps.library import MapLibrary
from app.messages import Place
from app.program.config import load_configuration
from app.rehearsal.rehearse import RehearsalRequest, rehearse
from app.rehearsal.result import Rehearsal
from app.tours.consistency import tour_of
from tests.robots.simulated.kinematic.rooms import kept

pytestmark = pytest.mark.slow
PLACES = [Place("home", "Home", 0.0, 1.0, 0.0), Place("east", "East", 4.2, -0.9, 0.0)]
TOUR: dict[str, Any] = {
    "format": 1,
    "id": "room-tour",
    "title": {"en": "The room"},
    "languages": ["en", "fr"],
    "map": "room",
    "home": "home",
    "greeting": {"do": [{"say": {"en": "Hello.", "fr": "Bonjour."}}], "confirm": {"ask": {"en": "Shall I lead you?"}}},
    "farewell": {"do": [{"say": {"en": "Goodbye.", "fr": "Au revoir."}}]},
    "stops": [
        {
            "id": "east",
            "place": "east",
            "title": {"en": "East"},
            "do": [
                {"say": {"en": "This is the east. It is warm."}},
                {"wait": {"at_most_s": 20, "press": {"en": "On"}}},
            ],
            "questions": [
                {"id": "why", "question": {"en": "Why?"}, "answer": {"say": {"en": "The sun.", "fr": "Le soleil."}}}
            ],
        },
        {"id": "north", "place": "north", "title": {"en": "North"}},
    ],
}


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Rehearsal:
    """The rehearsal, in French."""
    folder = tmp_path_factory.mktemp("maps")
    kept(folder)
    maps = MapLibrary(folder)
    maps.keep_places("room", PLACES)
    configuration = load_configuration(paths.config_dir() / "lab.yaml")
    return rehearse(RehearsalRequest(tour_of(TOUR), configuration, maps, "fr"))


def test_the_guide_leads_presents_answers_and_goes_home(found: Rehearsal) -> None:
    assert found.stops == ("east",)
    states = [state for state, _ in itertools.groupby(line.state for line in found.states)]
    wanted = iter(states)
    in_order = (
        "inviting",
        "confirming",
        "leading",
        "presenting",
        "listening",
        "answering",
        "parting",
        "going_home",
        "idle",
    )
    assert all(state in wanted for state in in_order), states
    assert found.outcome == found.states[-1].reason


def test_every_sentence_has_its_time(found: Rehearsal) -> None:
    said = [subtitle.text for subtitle in found.subtitles]
    for sentence in ("Bonjour.", "This is the east.", "It is warm.", "Le soleil.", "Au revoir."):
        assert sentence in said
    for before, after in itertools.pairwise(found.subtitles):
        assert before.at_s < before.until_s <= after.at_s
    assert all(math.isfinite(subtitle.until_s) for subtitle in found.subtitles)


def test_the_robot_goes_to_the_stop_and_back_with_its_visitors(found: Rehearsal) -> None:
    presenting = next(line.at_s for line in found.states if line.state == "presenting")
    there = min(found.path, key=lambda pose: abs(pose.at_s - presenting))
    assert math.dist((there.x, there.y), (4.2, -0.9)) < 0.4
    assert math.dist((found.path[-1].x, found.path[-1].y), (0.0, 1.0)) < 0.4
    assert found.driven_m > 8.0
    assert all(pose.farthest_m is not None and pose.farthest_m < 4.0 for pose in found.path)


def test_what_would_go_wrong_is_listed(found: Rehearsal) -> None:
    messages = {(problem.severity, problem.message) for problem in found.problems}
    assert ("error", "north: there is no place north") in messages
    assert ("warning", "step 1 has no text in fr: that in en is said") in messages
    assert len(messages) == 2
    assert not found.can_be_led
