"""How a guided tour goes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Literal

from app.messages.base import Stamp, doc

TourState = Literal[
    "idle",
    "inviting",
    "confirming",
    "leading",
    "waiting",
    "searching",
    "turning",
    "presenting",
    "listening",
    "answering",
    "blocked",
    "lost",
    "paused",
    "parting",
    "going_home",
]
#: What people press, on the page, over REST or on their phones.
TourButton = Literal[
    "start", "agree", "decline", "next", "pause", "resume", "retry", "skip", "undo_skip", "repeat", "end"
]
#: By language.
Texts = Mapping[str, str]


@dataclass(frozen=True, slots=True)
class ShownMedia:
    """A picture or a video that visitors are shown."""

    file: Annotated[str, doc("Its path in the folder of tours.")]
    alt: Annotated[Texts, doc("What it shows, by language.")]
    video: Annotated[bool, doc("Whether it is a video.")]


@dataclass(frozen=True, slots=True)
class TourQuestion:
    """A question that visitors may ask at a stop."""

    id: str
    question: Annotated[Texts, doc("By language.")]


@dataclass(frozen=True, slots=True)
class OperatorQuestion:
    """What the robot asks its operator; without an answer it does what it says."""

    text: Annotated[str, doc("The question.")]
    answers: Annotated[tuple[TourButton, ...], doc("Buttons that answer it.")]
    default: Annotated[str, doc("What it does without an answer, in words.")]
    until: Annotated[float, doc("When it does that (robot's clock, s).")]


@dataclass(frozen=True, slots=True)
class TourFailure:
    """Something on a tour that failed."""

    stop: Annotated[str, doc("Id of the stop.")]
    what: Annotated[str, doc("In words.")]


@dataclass(frozen=True, slots=True)
class TourProgress:
    """How the tour that is under way goes, or waits for visitors; published with each change."""

    stamp: Stamp
    run: Annotated[str, doc("Id of the run; empty before the first.")]
    tour: Annotated[str, doc("Id of the tour; empty: none is under way, and none waits for visitors.")]
    title: Annotated[Texts, doc("Of the tour, by language.")]
    language: Annotated[str, doc("That the robot speaks.")]
    languages: tuple[str, ...]
    waits: Annotated[bool, doc("Whether visitors and the schedule begin it, again and again.")]
    state: TourState
    since: Annotated[float, doc("When the state began (robot's clock, s).")]
    reason: Annotated[str, doc("Why it is in this state, in words; may be empty.")]
    stop: Annotated[str, doc("Id of the stop that it is at, or on the way to; empty: none.")]
    stop_title: Annotated[Texts, doc("By language.")]
    number: Annotated[int, doc("Of the stop among those that are not left out, from 1; 0: none.")]
    stops: Annotated[int, doc("How many there are that are not left out.")]
    step: Annotated[int, doc("Of the stop, greeting or farewell, from 1; 0: none.")]
    steps: int
    text: Annotated[Texts, doc("What is said in this step, by language; none: nothing.")]
    sentence: Annotated[int, doc("Which sentence of it, from 0.")]
    shown: Annotated[ShownMedia | None, doc("What visitors are shown; null: nothing.")]
    press: Annotated[Texts, doc("What the button `next` is called, by language; none: it is not waited for.")]
    questions: Annotated[tuple[TourQuestion, ...], doc("That visitors may ask now.")]
    buttons: Annotated[tuple[TourButton, ...], doc("That do something now.")]
    question: Annotated[OperatorQuestion | None, doc("That the operator is asked; null: none.")]
    people: Annotated[int, doc("How many are seen.")]
    farthest_m: Annotated[float | None, doc("The distance of the farthest of them (m); null: none is seen.")]
    presented: Annotated[tuple[str, ...], doc("Ids of the stops that were presented.")]
    skipped: Annotated[tuple[str, ...], doc("Ids of the stops that were skipped.")]
    failures: tuple[TourFailure, ...]
