"""What a tour says of itself that cannot be: found without looking at anything else. Pure functions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from app.base.yaml_source import KeyPath
from app.tours.codes import CodeError, parse
from app.tours.model import Stop, Tour
from app.tours.problems import InvalidTour, TourProblem, of_validation
from app.tours.steps import Step


def tour_of(data: Mapping[str, Any]) -> Tour:
    """The tour that ``data`` (as of JSON or YAML) is. Raises InvalidTour with all mistakes."""
    try:
        tour = Tour.model_validate(data)
    except ValidationError as failure:
        raise InvalidTour(of_validation(failure)) from None
    if problems := tuple(mistakes(tour)):
        raise InvalidTour(problems)
    return tour


def mistakes(tour: Tour) -> Iterator[TourProblem]:
    """All mistakes for which ``tour`` is not kept."""
    yield from _twice(tour.languages, ("languages",), "the language {!r} is here twice")
    ids = [stop.id for stop in tour.stops]
    yield from _twice(ids, ("stops",), "another stop is called {!r} too; each needs an id of its own", "id")
    posters = [stop.poster for stop in tour.stops]
    yield from _twice(posters, ("stops",), "another stop has the poster {!r} too; each needs its own", "poster")
    for number, stop in enumerate(tour.stops):
        yield from _of_stop(stop, ("stops", number))
    for number, text in enumerate(tour.accept):
        yield from _of_code(text, ("accept", number))
    yield from _of_begin(tour)
    pace, battery = tour.pace, tour.battery
    if pace.slow_m >= pace.wait_m:
        yield TourProblem(
            ("pace", "slow_m"),
            f"should be less than wait_m ({pace.wait_m:g}), not {pace.slow_m:g}: it slows down before it waits",
        )
    if battery.end_below >= battery.begin_min:
        yield TourProblem(
            ("battery", "end_below"),
            f"should be less than begin_min ({battery.begin_min:g}), not {battery.end_below:g}: a tour that begins "
            f"with {battery.begin_min:.0%} of a charge would end at once",
        )


def steps_of(tour: Tour) -> Iterator[tuple[KeyPath, Step]]:
    """Every step and its path, those of questions among them."""
    for name, part in (("greeting", tour.greeting), ("farewell", tour.farewell)):
        for index, step in enumerate(part.do):
            yield (name, "do", index), step
    for number, stop in enumerate(tour.stops):
        for index, step in enumerate(stop.do):
            yield ("stops", number, "do", index), step
        for index, question in enumerate(stop.questions):
            yield ("stops", number, "questions", index, "answer"), question.answer


def _of_stop(stop: Stop, path: KeyPath) -> Iterator[TourProblem]:
    ids = [question.id for question in stop.questions]
    where = (*path, "questions")
    yield from _twice(ids, where, "another question of this stop is called {!r} too; each needs an id of its own", "id")
    for index, question in enumerate(stop.questions):
        answer = question.answer
        if answer.wait is not None:
            yield TourProblem((*where, index, "answer", "wait"), "an answer does not wait; the stop's own steps do")
        elif answer.say is None and answer.show is None:
            yield TourProblem((*where, index, "answer"), "an answer says or shows something")
    if stop.poster is not None:
        yield from _of_code(stop.poster, (*path, "poster"))


def _of_code(text: str, path: KeyPath) -> Iterator[TourProblem]:
    try:
        parse(text)
    except CodeError as refusal:
        yield TourProblem(path, str(refusal))


def _of_begin(tour: Tour) -> Iterator[TourProblem]:
    yield from _twice(tour.begin.by, ("begin", "by"), "{!r} is here twice")
    for number, slot in enumerate(tour.schedule):
        yield from _twice(slot.days, ("schedule", number, "days"), "{!r} is here twice")
        yield from _twice(slot.times, ("schedule", number, "times"), "{!r} is here twice")


def _twice(values: Iterable[str | None], path: KeyPath, message: str, key: str | None = None) -> Iterator[TourProblem]:
    """A problem for each of ``values`` at ``path`` (of their member ``key``) that another before it equals."""
    seen: set[str] = set()
    for number, value in enumerate(values):
        if value is None:
            continue
        if value in seen:
            yield TourProblem((*path, number) if key is None else (*path, number, key), message.format(value))
        seen.add(value)
