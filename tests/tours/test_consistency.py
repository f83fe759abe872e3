"""Data that is no tour is refused: the value and what is allowed are named."""

from __future__ import annotations

from typing import Any

import jsonschema
import pytest

from app.tours.consistency import steps_of, tour_of
from app.tours.model import rules_at, tour_schema
from app.tours.problems import InvalidTour
from tests.tours.tours import ARM, tour, tour_data

SAY = {"say": {"en": "Yes."}}
QUESTION = {"id": "weight", "question": {"en": "How heavy?"}, "answer": {"say": {"en": "Four kilograms."}}}


def stop(**more: Any) -> dict[str, Any]:
    return tour_data(stops=[ARM | more])


@pytest.mark.parametrize(
    ("data", "field", "words"),
    [
        (tour_data(format=2), "format", "should be 1"),
        (tour_data(id="Lab tour"), "id", "should be an id: 1 to 40 small letters, digits and hyphens, not 'Lab tour'"),
        (tour_data(languages=[]), "languages", "at least 1 item"),
        (tour_data(languages=["en", "fr", "en"]), "languages.2", "the language 'en' is here twice"),
        (tour_data(title={"English": "x"}), "title.English", "should be a language's tag, as en, fr or en-gb"),
        (tour_data(title={"en": " \n"}), "title.en", "should be a text on one line"),
        (tour_data(stops=[ARM, ARM | {"poster": None}]), "stops.1.id", "another stop is called 'arm' too"),
        (tour_data(stops=[ARM, ARM | {"id": "leg"}]), "stops.1.poster", "each needs its own"),
        (stop(plase="x"), "stops.0.plase", "did you mean 'place'?"),
        (stop(do=[{}]), "stops.0.do.0", "a step needs at least one of say, look, point, show"),
        (stop(do=[{"look": "away"}]), "stops.0.do.0.look", "should be 'visitors' or 'poster', not 'away'"),
        (stop(do=[{"look": [1, 2]}]), "stops.0.do.0.look.2", "is missing"),
        (stop(do=[{"point": [1, 2, "high"]}]), "stops.0.do.0.point.2", "should be a valid number"),
        (stop(do=[{"point": [1, float("nan"), 1]}]), "stops.0.do.0.point.1", "should be a finite number"),
        (stop(do=[{"show": {"file": "../x.jpg", "alt": {"en": "x"}}}]), "stops.0.do.0.show.file", "a path within"),
        (stop(do=[{"show": {"file": "x.exe", "alt": {"en": "x"}}}]), "stops.0.do.0.show.file", "ends in .jpg"),
        (stop(do=[{"gesture": {"class": "Wave", "params": {"a": [1]}}}]), "stops.0.do.0.gesture.params.a", "a number"),
        (stop(do=[{"gesture": {"class": "A", "params": {"a": "\ud800"}}}]), "stops.0.do.0.gesture.params.a", "a text"),
        (stop(do=[{"wait": {"claps": 2}}]), "stops.0.do.0.wait.at_most_s", "is missing"),
        (stop(do=[{"wait": {"at_most_s": 5, "words": {"en": ["4!"]}}}]), "stops.0.do.0.wait.words.en.0", "of letters"),
        (stop(poster="HBBA:GO"), "stops.0.poster", "after HBBA: comes STOP/ or SAY/, not 'GO'"),
        (tour_data(accept=["HBBA:SAY/X"]), "accept.0", "LANGUAGE/TEXT"),
        (stop(questions=[QUESTION, QUESTION]), "stops.0.questions.1.id", "another question of this stop"),
        (stop(questions=[QUESTION | {"answer": {"look": "visitors"}}]), "stops.0.questions.0.answer", "says or shows"),
        (
            stop(questions=[QUESTION | {"answer": SAY | {"wait": {"at_most_s": 1}}}]),
            "stops.0.questions.0.answer.wait",
            "does not wait",
        ),
        (tour_data(pace={"slow_m": 4}), "pace.slow_m", r"should be less than wait_m \(4\), not 4"),
        (tour_data(battery={"begin_min": 0.1}), "battery.end_below", r"should be less than begin_min \(0.1\), not 0.2"),
        (tour_data(begin={"by": ["face", "face"]}), "begin.by.1", "'face' is here twice"),
        (tour_data(schedule=[{"days": ["mon"], "times": ["9:30"]}]), "schedule.0.times.0", "a time of day"),
        (tour_data(schedule=[{"days": ["mon", "mon"], "times": ["09:30"]}]), "schedule.0.days.1", "twice"),
    ],
)
def test_a_mistake_is_named_with_what_is_allowed(data: dict[str, Any], field: str, words: str) -> None:
    with pytest.raises(InvalidTour, match=words) as refused:
        tour_of(data)
    assert [problem.field for problem in refused.value.problems] == [field]


def test_all_mistakes_are_found_at_once() -> None:
    with pytest.raises(InvalidTour) as refused:
        tour_of(tour_data(map="", pace={"speed": 2}, stops=[ARM | {"title": {}}]))
    assert [problem.field for problem in refused.value.problems] == ["map", "pace.speed", "stops.0.title"]


def test_the_schema_is_one_and_takes_what_the_model_takes() -> None:
    schema = tour_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    check = jsonschema.Draft202012Validator(schema)
    check.validate(tour_data())
    check.validate(tour().model_dump(mode="json", by_alias=True))
    for wrong in (stop(do=[{"look": "away"}]), stop(id="A"), tour_data(languages=["E"]), tour_data(more=1)):
        assert not check.is_valid(wrong)


def test_what_a_stop_does_not_say_of_failures_is_the_tours() -> None:
    lab = tour(
        on_failure={"reach": {"retry": 1, "then": "end"}, "present": {"then": "skip"}},
        stops=[ARM | {"on_failure": {"reach": {"then": "present_from_here"}}}],
    )
    rules = rules_at(lab, lab.stops[0])
    assert (rules.reach.retry, rules.reach.ask_s, rules.reach.then) == (1, 20, "present_from_here")
    assert rules.present.then == "skip"


def test_every_step_is_found() -> None:
    lab = tour(greeting={"do": [SAY]}, farewell={"do": [SAY]}, stops=[ARM | {"questions": [QUESTION]}])
    assert [path for path, _ in steps_of(lab)] == [
        ("greeting", "do", 0),
        ("farewell", "do", 0),
        ("stops", 0, "do", 0),
        ("stops", 0, "questions", 0, "answer"),
    ]
