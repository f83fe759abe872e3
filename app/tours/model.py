"""A guided tour: stops in order, and how the robot leads people to them (docs/guided-tours.md).

All that has a default may be left out. What one value cannot say of itself (ids that differ, places that exist) is
found by ``consistency`` and ``checks``.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from app.tours.steps import Question, Step
from app.tours.values import MOST_LANGUAGES, CodeText, Id, Language, PlaceId, Rule, Text, Title, TourPart, Words

MOST_STOPS, MOST_STEPS, MOST_QUESTIONS = 100, 50, 30

#: What begins a tour, or an invitation to it.
Beginning = Literal["press", "face", "voice"]
Weekday = Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"]

_Steps = Annotated[tuple[Step, ...], Field(max_length=MOST_STEPS)]
_Time = Annotated[str, Rule(r"(?:[01][0-9]|2[0-3]):[0-5][0-9]", "a time of day, as 09:30 or 14:00")]


class Begin(TourPart):
    """When people are invited."""

    by: tuple[Beginning, ...] = Field(
        ("press",), min_length=1, max_length=3, description="What begins it: a press, a face, a voice."
    )
    people_min: int = Field(1, ge=1, le=20, description="At least so many people.")
    within_m: float = Field(2.5, ge=0.5, le=10, description="Within so many metres.")
    for_s: float = Field(2.0, ge=0, le=60, description="For so many seconds.")


class Slot(TourPart):
    """Times, of the robot's place, at which the tour begins by itself."""

    days: tuple[Weekday, ...] = Field(min_length=1, max_length=7)
    times: tuple[_Time, ...] = Field(min_length=1, max_length=50)


class BatteryRule(TourPart):
    """How much charge a tour needs, as shares of a full battery."""

    begin_min: float = Field(0.4, ge=0, le=1, description="No tour begins below this.")
    end_below: float = Field(0.2, ge=0, le=1, description="Below this, the tour ends at once.")


class Pace(TourPart):
    """How the robot leads."""

    speed: float = Field(0.8, gt=0, le=1, description="Share of the robot's greatest speed.")
    slow_m: float = Field(2.5, ge=0.8, le=10, description="It slows down while visitors are farther behind (m).")
    wait_m: float = Field(4.0, ge=1, le=20, description="It waits while visitors are farther behind (m).")
    give_up_s: float = Field(
        60.0, ge=5, le=600, description="So long it waits; then it goes on with those who are there, or ends."
    )
    look_back_m: float = Field(
        5.0, ge=1, le=100, description="It turns to look for visitors every so many metres: sensors see only ahead."
    )


class ReachRule(TourPart):
    """What to do where a stop cannot be reached."""

    retry: int = Field(2, ge=0, le=5, description="So often it tries again.")
    ask_s: float = Field(20.0, ge=0, le=600, description="So long it then asks the operator; 0: it does not ask.")
    then: Literal["skip", "present_from_here", "end"] = Field(
        "skip", description="Without an answer: leave the stop out, present it from where the robot is, or end."
    )


class PresentRule(TourPart):
    """What to do where a step fails: no voice, an arm that cannot point there."""

    retry: int = Field(0, ge=0, le=5, description="So often the step is tried again.")
    then: Literal["continue", "skip", "end"] = Field(
        "continue", description="Go on with the next step, leave the rest of the stop out, or end."
    )


class FailureRules(TourPart):
    """What to do on failure, for all stops that do not say otherwise."""

    reach: ReachRule = ReachRule()
    present: PresentRule = PresentRule()


class ReachException(TourPart):
    """A stop's own ReachRule: what is left out is the tour's."""

    retry: int | None = Field(None, ge=0, le=5)
    ask_s: float | None = Field(None, ge=0, le=600)
    then: Literal["skip", "present_from_here", "end"] | None = None


class PresentException(TourPart):
    """A stop's own PresentRule: what is left out is the tour's."""

    retry: int | None = Field(None, ge=0, le=5)
    then: Literal["continue", "skip", "end"] | None = None


class FailureExceptions(TourPart):
    """A stop's own failure rules."""

    reach: ReachException = ReachException()
    present: PresentException = PresentException()


class Stand(TourPart):
    """How the robot places itself at a stop."""

    face: Literal["visitors", "poster", "place"] = Field(
        "visitors", description="Towards visitors, the poster (where the map knows it), or as the place says."
    )
    tolerance_m: float = Field(0.3, ge=0.05, le=2, description="So near the place is there (m).")
    tolerance_rad: float = Field(0.2, ge=0.05, le=3.2, description="So well turned is turned (rad).")


class Stop(TourPart):
    """A place where the robot presents something."""

    id: Id
    place: PlaceId
    title: Title
    poster: CodeText | None = Field(
        None, description="Text of the code that hangs there; HBBA:STOP/ and the id in capitals is read farthest."
    )
    stand: Stand = Stand()
    words: Words = Field(default={}, description="Words by which visitors ask to be led there, by language.")
    do: _Steps = Field((), description="Steps, one after another.")
    questions: tuple[Question, ...] = Field((), max_length=MOST_QUESTIONS)
    on_failure: FailureExceptions = FailureExceptions()
    left_out: bool = Field(False, description="Whether it is passed over for now.")


class Confirmation(TourPart):
    """A question before the tour begins, agreed to by a word or a press."""

    ask: Text
    agree: Words = Field(default={}, description="Words that agree, by language; a button is always there.")
    decline: Words = Field(default={}, description="Words that decline, by language.")
    at_most_s: float = Field(20.0, ge=2, le=120, description="Seconds after which no answer is a no.")


class Greeting(TourPart):
    """What the robot does when visitors come."""

    do: _Steps = ()
    confirm: Confirmation | None = Field(None, description="Asked after it; none: the tour begins at once.")


class Farewell(TourPart):
    """What the robot does before it goes home."""

    do: _Steps = ()


class Commands(TourPart):
    """Words by which visitors steer the tour while it is led, by language; without any, presses alone do."""

    pause: Words = Field(default={}, description="One moment, please.")
    resume: Words = Field(default={}, description="These end only a pause that visitors asked for.")
    skip: Words = Field(default={}, description="On to the next stop.")
    undo_skip: Words = Field(default={}, description="Back to the stop that was skipped.")
    repeat: Words = Field(default={}, description="The whole stop once more.")
    end: Words = Field(default={}, description="Goodbye, and home.")


class Tour(TourPart):
    """A guided tour."""

    format: Literal[1] = Field(description="Of this file.")
    id: Id
    title: Title
    languages: tuple[Language, ...] = Field(
        min_length=1, max_length=MOST_LANGUAGES, description="Spoken on it; every text has the first of them."
    )
    map: str = Field(min_length=1, max_length=100, description="The map that its places are on.")
    home: PlaceId | None = Field(None, description="Where the robot goes afterwards; none: it stays.")
    begin: Begin = Begin()
    schedule: tuple[Slot, ...] = Field((), max_length=50)
    battery: BatteryRule = BatteryRule()
    pace: Pace = Pace()
    on_failure: FailureRules = FailureRules()
    greeting: Greeting = Greeting()
    farewell: Farewell = Farewell()
    commands: Commands = Commands()
    accept: tuple[CodeText, ...] = Field(
        (),
        max_length=100,
        description="Texts of further codes that are obeyed when visitors show them while the tour waits at a stop.",
    )
    stops: tuple[Stop, ...] = Field((), max_length=MOST_STOPS)


def rules_at(tour: Tour, stop: Stop) -> FailureRules:
    """The failure rules at ``stop``: its own, completed by the tour's."""
    own, usual = stop.on_failure, tour.on_failure
    return FailureRules(
        reach=usual.reach.model_copy(update=own.reach.model_dump(exclude_none=True)),
        present=usual.present.model_copy(update=own.present.model_dump(exclude_none=True)),
    )


def tour_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a tour."""
    schema = Tour.model_json_schema(by_alias=True)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
