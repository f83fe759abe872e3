"""What a tour cannot know of itself: each problem, its place and whether the tour can run all the same."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

from app.attention.desires import DesireClass
from app.modules.behaviors.face.face import EXPRESS
from app.modules.behaviors.gaze.look_at import LOOK_AT
from app.modules.behaviors.gestures.gesture_parameters import POINT_AT, WAVE
from app.modules.behaviors.speech.say import SAY
from app.tours.checks import Surroundings, check, media_of, words_by_language
from app.tours.desires import desires_of
from tests.tours.tours import ARM, tour

CLASSES: Mapping[str, DesireClass] = {each.name: each for each in (SAY, LOOK_AT, POINT_AT, WAVE, EXPRESS)}
AROUND = Surroundings(places=frozenset({"robotics-lab", "dock"}), classes=CLASSES, unknown_words={"en": frozenset()})
GOOD: dict[str, Any] = ARM | {
    "do": [
        {"say": {"en": "Hello."}, "look": "poster", "point": [1, 2, 1], "gesture": {"class": "Wave"}},
        {"look": [1, 2, 3], "expression": "happy", "wait": {"at_most_s": 5, "words": {"en": ["go on"]}}},
    ],
    "questions": [
        {
            "id": "weight",
            "question": {"en": "How heavy?"},
            "words": {"en": ["heavy", "weight"]},
            "answer": {"say": {"en": "Four kilograms."}, "show": {"file": "a.jpg", "alt": {"en": "Scales"}}},
        }
    ],
}


def found(around: Surroundings = AROUND, **more: Any) -> list[tuple[str, str]]:
    return [(problem.field, problem.severity) for problem in check(tour(**({"stops": [GOOD]} | more)), around)]


def stop(**more: Any) -> dict[str, Any]:
    return {"stops": [GOOD | more]}


def test_a_tour_for_which_all_is_there_has_no_problem() -> None:
    assert found(home="dock") == []
    assert found(Surroundings()) == [], "what is not known is not checked"


@pytest.mark.parametrize(
    ("changes", "field", "severity", "words"),
    [
        ({"stops": []}, "stops", "error", "no stop to go to"),
        (stop(left_out=True), "stops", "error", "no stop to go to"),
        ({"home": "dok"}, "home", "error", "the map lab has no place 'dok'; did you mean 'dock'?"),
        (stop(place="kitchen"), "stops.0.place", "error", "has no place 'kitchen'; allowed: dock, robotics-lab"),
        (stop(title={"fr": "Le bras"}), "stops.0.title", "error", "no text in en, the first of languages"),
        (stop(title={"en": "A", "de": "B"}), "stops.0.title.de", "warning", "languages does not have de"),
        (stop(do=[{"say": {"en": "…!"}}]), "stops.0.do.0.say.en", "error", "no letter or digit"),
        (stop(poster=None, do=[{"look": "poster"}]), "stops.0.do.0.look", "error", "no poster here"),
        ({"greeting": {"do": [{"look": "poster"}]}}, "greeting.do.0.look", "error", "no poster here"),
        (stop(do=[{"expression": "bored"}]), "stops.0.do.0.expression", "warning", "should be 'calm'"),
        (stop(do=[{"gesture": {"class": "Bow"}}]), "stops.0.do.0.gesture", "warning", "no desire class Bow"),
        (
            stop(do=[{"gesture": {"class": "Wave", "params": {"times": 99}}}]),
            "stops.0.do.0.gesture.params.times",
            "error",
            "less than or equal to 20",
        ),
        (
            stop(do=[{"wait": {"at_most_s": 1, "words": {"en": ["go"], "fr": ["suite"]}}}]),
            "stops.0.do.0.wait.words.fr",
            "warning",
            "languages does not have fr",
        ),
        (
            stop(questions=[*GOOD["questions"], GOOD["questions"][0] | {"id": "mass", "words": {"en": ["Heavy"]}}]),
            "stops.0.questions.1.words.en",
            "error",
            "'Heavy' is a word of the question weight, too",
        ),
        (
            {"commands": {"pause": {"en": ["wait"]}, "skip": {"en": ["Wait"]}}},
            "commands.skip.en",
            "error",
            "'Wait' is a word of commands.pause, too",
        ),
        (
            {"commands": {"pause": {"en": ["the arm"]}}} | stop(words={"en": ["the arm"]}),
            "stops.0.words.en",
            "error",
            "'the arm' is a word of commands.pause, too",
        ),
        ({"pace": {"slow_m": 9}}, "pace.slow_m", "mistake", "less than wait_m"),
    ],
)
def test_each_problem_says_what_it_is_about(changes: dict[str, Any], field: str, severity: str, words: str) -> None:
    problems = check(tour(**({"stops": [GOOD]} | changes)), AROUND)
    assert (field, severity) in [(problem.field, problem.severity) for problem in problems]
    assert any(words in problem.message for problem in problems if problem.field == field)


def test_a_text_that_says_nothing_is_one_problem() -> None:
    assert found(**stop(do=[{"say": {"en": "…"}}])) == [("stops.0.do.0.say.en", "error")]


def test_a_map_that_is_not_there_is_an_error_and_its_places_are_not_checked() -> None:
    assert found(Surroundings(no_map="there is no map 'lab'"), home="x") == [("map", "error")]


def test_a_second_language_may_be_missing_here_and_there() -> None:
    problems = found(languages=["en", "fr"])
    assert ("title", "warning") in problems
    assert {severity for _, severity in problems} == {"warning"}


def test_words_that_the_recognizer_does_not_know_are_named() -> None:
    around = replace(AROUND, unknown_words={"en": frozenset({"on", "weight"})})
    problems = check(tour(stops=[GOOD]), around)
    assert [(problem.field, problem.message.partition(":")[0]) for problem in problems] == [
        ("stops.0.questions.0.words.en", "the recognizer does not know 'weight'"),
        ("stops.0.do.1.wait.words.en", "the recognizer does not know 'on'"),
    ]
    assert all(problem.severity == "warning" for problem in problems)
    deaf = replace(AROUND, unknown_words={})
    assert [severity for _, severity in found(deaf)] == ["warning", "warning"]
    confirm = {"ask": {"en": "Shall I?"}, "agree": {"en": ["Yes please"]}, "decline": {"en": ["no"]}}
    asked = words_by_language(tour(greeting={"confirm": confirm}))
    assert asked == {"en": {"yes", "please", "no"}}


def test_media_that_are_missing_are_named() -> None:
    lab = tour(stops=[GOOD])
    assert [file for _, file in media_of(lab)] == ["a.jpg"]
    (problem,) = check(lab, replace(AROUND, missing=frozenset({"a.jpg"})))
    assert (problem.field, problem.severity) == ("stops.0.questions.0.answer.show.file", "warning")


def test_the_worst_comes_first() -> None:
    severities = [severity for _, severity in found(languages=["en", "fr"], pace={"slow_m": 9}, home="x")]
    assert severities == sorted(severities, key=("mistake", "error", "warning").index)
    assert len(set(severities)) == 3


def test_a_steps_desires_are_those_of_the_programs_classes() -> None:
    step = tour(stops=[GOOD]).stops[0].do[0]
    desires = list(desires_of(step, "fr", "en"))
    assert [(key, cls) for key, cls, _ in desires] == [("say", "Say"), ("point", "PointAt"), ("gesture", "Wave")]
    assert desires[0][2] == {"text": "Hello.", "language": "en"}
    for _, cls, params in desires:
        CLASSES[cls].validated(params)
