"""What a tour cannot know of itself: whether places, media, words and gestures that it names are there.

``Surroundings`` are found by ``surroundings``; the check itself is pure.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from app.attention.desires import DesireClass, InvalidDesire
from app.base.yaml_source import KeyPath, dotted, suggestion
from app.speech.text_spans import sentences_of
from app.tours.consistency import mistakes, steps_of
from app.tours.desires import EXPRESS, desires_of
from app.tours.model import Commands, Tour
from app.tours.problems import TourProblem
from app.tours.steps import Step
from app.tours.values import Words


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What there is of what one tour refers to; None: not known, so not checked.

    ``no_map``: the reason why the tour's map cannot be used, "" if it can; ``places``: ids of the places on it;
    ``missing``: media files of the tour that are not there; ``classes``: desire classes of the program;
    ``unknown_words``: words of the tour that cannot be recognized, by language; a language that is missing there
    cannot be recognized at all.
    """

    no_map: str = ""
    places: frozenset[str] | None = None
    missing: frozenset[str] = frozenset()
    classes: Mapping[str, DesireClass] | None = None
    unknown_words: Mapping[str, frozenset[str]] | None = None


def check(tour: Tour, around: Surroundings) -> tuple[TourProblem, ...]:
    """All problems of ``tour``: mistakes first, then errors, then warnings, each in the tour's order."""
    found = [
        *mistakes(tour),
        *_of_places(tour, around),
        *_of_texts(tour),
        *_of_words(tour, around),
        *_of_steps(tour, around),
    ]
    severities = ("mistake", "error", "warning")
    return tuple(sorted(found, key=lambda problem: severities.index(problem.severity)))


def words_by_language(tour: Tour) -> Mapping[str, frozenset[str]]:
    """Single words, in lower case, that are listened for on ``tour``, by language."""
    found: dict[str, set[str]] = {}
    for _, words in _heard(tour):
        for language, phrases in words.items():
            found.setdefault(language, set()).update(word for phrase in phrases for word in phrase.lower().split())
    return {language: frozenset(words) for language, words in found.items()}


def media_of(tour: Tour) -> Iterator[tuple[KeyPath, str]]:
    """Path and name of each media file that ``tour`` shows."""
    for path, step in steps_of(tour):
        if step.show is not None:
            yield (*path, "show", "file"), step.show.file


def _of_places(tour: Tour, around: Surroundings) -> Iterator[TourProblem]:
    if not any(not stop.left_out for stop in tour.stops):
        yield TourProblem(("stops",), "the tour has no stop to go to", "error")
    if around.no_map:
        yield TourProblem(("map",), around.no_map, "error")
    if around.places is None:
        return
    named: list[tuple[KeyPath, str]] = [(("stops", n, "place"), stop.place) for n, stop in enumerate(tour.stops)]
    if tour.home is not None:
        named.insert(0, (("home",), tour.home))
    for path, place in named:
        if place not in around.places:
            known = suggestion(place, sorted(around.places))
            yield TourProblem(path, f"the map {tour.map} has no place {place!r}; {known}", "error")


def _of_texts(tour: Tour) -> Iterator[TourProblem]:
    """Every text has the first language; others are optional, but said."""
    first, *others = tour.languages
    for path, text in _texts(tour):
        if first not in text:
            yield TourProblem(path, f"has no text in {first}, the first of languages, which every text needs", "error")
            continue
        if missing := [language for language in others if language not in text]:
            yield TourProblem(path, f"has no text in {', '.join(missing)}: that in {first} is used", "warning")
    for path, by_language in (*_texts(tour), *_heard(tour)):
        for language in by_language:
            if language not in tour.languages:
                yield TourProblem((*path, language), f"languages does not have {language}: this is not used", "warning")


def _of_commands(tour: Tour) -> Iterator[TourProblem]:
    """Words that would steer the tour in two ways."""
    taken: dict[tuple[str, str], KeyPath] = {}
    for path, words in _commands(tour):
        for language, phrases in words.items():
            for phrase in phrases:
                other = taken.setdefault((language, phrase.lower()), path)
                if other != path:
                    yield TourProblem((*path, language), f"{phrase!r} is a word of {dotted(other)}, too", "error")


def _commands(tour: Tour) -> Iterator[tuple[KeyPath, Words]]:
    for name in Commands.model_fields:
        yield ("commands", name), getattr(tour.commands, name)
    for number, stop in enumerate(tour.stops):
        yield ("stops", number, "words"), stop.words


def _of_words(tour: Tour, around: Surroundings) -> Iterator[TourProblem]:
    yield from _of_commands(tour)
    for number, stop in enumerate(tour.stops):
        taken: dict[tuple[str, str], str] = {}
        for index, question in enumerate(stop.questions):
            for language, phrases in question.words.items():
                for phrase in phrases:
                    other = taken.setdefault((language, phrase.lower()), question.id)
                    if other != question.id:
                        where = ("stops", number, "questions", index, "words", language)
                        yield TourProblem(where, f"{phrase!r} is a word of the question {other}, too", "error")
    if around.unknown_words is None:
        return
    for path, words in _heard(tour):
        for language, phrases in words.items():
            if (unknown := around.unknown_words.get(language)) is None:
                yield TourProblem(
                    (*path, language), f"words in {language} are not recognized: only presses count", "warning"
                )
                continue
            for phrase in phrases:
                if lacking := [word for word in phrase.lower().split() if word in unknown]:
                    yield TourProblem(
                        (*path, language),
                        f"the recognizer does not know {', '.join(map(repr, lacking))}: {phrase!r} is never heard",
                        "warning",
                    )


def _of_steps(tour: Tour, around: Surroundings) -> Iterator[TourProblem]:
    for path, file in media_of(tour):
        if file in around.missing:
            yield TourProblem(path, f"there is no file {file} in the folder of tours: nothing is shown", "warning")
    for path, step in steps_of(tour):
        if step.look == "poster" and not (path[0] == "stops" and tour.stops[int(path[1])].poster):
            yield TourProblem((*path, "look"), "there is no poster here to look at", "error")
        for language, text in (step.say or {}).items():
            if not sentences_of(text):
                yield TourProblem((*path, "say", language), "has no letter or digit to say yet", "error")
        if around.classes is not None:
            yield from _of_desires(step, path, tour, around.classes)


def _of_desires(step: Step, path: KeyPath, tour: Tour, classes: Mapping[str, DesireClass]) -> Iterator[TourProblem]:
    for key, cls, params in desires_of(step, tour.languages[0], tour.languages[0]):
        here = (*path, key)
        if cls not in classes:
            yield TourProblem(here, f"this program has no desire class {cls}: it is passed over", "warning")
            continue
        if key == "say" and not all(sentences_of(text) for text in (step.say or {}).values()):
            continue  # it is said of the text already
        try:
            classes[cls].validated(params)
        except InvalidDesire as refusal:
            at: KeyPath = (*here, *refusal.field.split(".")) if key == "gesture" else here
            yield TourProblem(at, refusal.message, "warning" if cls == EXPRESS else "error")


def _texts(tour: Tour) -> Iterator[tuple[KeyPath, Mapping[str, str]]]:
    yield ("title",), tour.title
    if tour.greeting.confirm is not None:
        yield ("greeting", "confirm", "ask"), tour.greeting.confirm.ask
    for number, stop in enumerate(tour.stops):
        yield ("stops", number, "title"), stop.title
        for index, question in enumerate(stop.questions):
            yield ("stops", number, "questions", index, "question"), question.question
    for path, step in steps_of(tour):
        if step.say is not None:
            yield (*path, "say"), step.say
        if step.show is not None:
            yield (*path, "show", "alt"), step.show.alt
        if step.wait is not None and step.wait.press is not None:
            yield (*path, "wait", "press"), step.wait.press


def _heard(tour: Tour) -> Iterator[tuple[KeyPath, Mapping[str, Any]]]:
    if (confirm := tour.greeting.confirm) is not None:
        yield ("greeting", "confirm", "agree"), confirm.agree
        yield ("greeting", "confirm", "decline"), confirm.decline
    yield from _commands(tour)
    for number, stop in enumerate(tour.stops):
        for index, question in enumerate(stop.questions):
            yield ("stops", number, "questions", index, "words"), question.words
    for path, step in steps_of(tour):
        if step.wait is not None:
            yield (*path, "wait", "words"), step.wait.words
