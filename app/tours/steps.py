"""What the robot does at a stop: steps one after another; everything that one step names goes on at once."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from app.tours.values import Id, Point, Rule, Scalar, Text, Title, TourPart, Words

#: Longest time (s) that a step waits.
LONGEST_WAIT_S = 600.0
#: Endings of files that a browser shows as a picture, or plays.
PICTURES, VIDEOS = ("jpg", "jpeg", "png", "webp", "gif"), ("mp4", "webm")

_SUFFIXES = "|".join((*PICTURES, *VIDEOS))
#: A relative path without hidden parts, which leaves no folder.
_MEDIA = Rule(
    rf"(?:[A-Za-z0-9_][A-Za-z0-9._ -]*/)*[A-Za-z0-9_][A-Za-z0-9._ -]*\.(?:{_SUFFIXES})",
    "a path within the folder of tours, of letters, digits, '.', '_', '-' and '/', that ends in "
    + ", ".join(f".{suffix}" for suffix in (*PICTURES, *VIDEOS)),
)
_CLASS = Rule(r"[A-Za-z][A-Za-z0-9]{0,59}", "a desire class, as Wave")
_WORD = Rule(r"[a-z][a-z_]{0,39}", "a word in small letters, as happy")


def _kind_of_look(value: object) -> str:
    return "[word]" if isinstance(value, str) else "[point]"


#: Where to look.
Look = Annotated[
    Annotated[Literal["visitors", "poster"], Tag("[word]")] | Annotated[Point, Tag("[point]")],
    Discriminator(_kind_of_look),
]


class Media(TourPart):
    """A picture or a video."""

    file: Annotated[str, _MEDIA] = Field(
        max_length=200, description="Its path in the folder of tours, as media/arm.jpg."
    )
    alt: Title = Field(description="What it shows, for those who do not see it.")

    @property
    def is_video(self) -> bool:
        """Whether it has an end."""
        return self.file.rpartition(".")[2] in VIDEOS


class Gesture(TourPart):
    """A desire of a class of the body's, such as Wave."""

    cls: Annotated[str, _CLASS] = Field(alias="class", description="The desire class, as Wave or Reach.")
    params: dict[Annotated[str, Field(max_length=60)], Scalar] = Field(
        default={}, max_length=30, description="Its parameters."
    )


class Wait(TourPart):
    """A wait until the first of what it names, or until its time is over."""

    at_most_s: float = Field(gt=0, le=LONGEST_WAIT_S, description="Seconds after which the tour goes on in any case.")
    words: Words = Field(default={}, description="A word that is heard ends it, by language.")
    claps: int | None = Field(None, ge=1, le=5, description="So many claps in a row end it.")
    call: bool = Field(False, description="Somebody who calls out ends it: a loud noise while a voice is located.")
    press: Title | None = Field(None, description="A button with this text, on the page and for visitors, ends it.")
    all_left: bool = Field(False, description="It ends when all visitors have left.")


class Step(TourPart):
    """What goes on at once; the step is over when all of it is. A picture stays until the next, or the stop's end."""

    say: Text | None = Field(None, description="What to say, by language.")
    look: Look | None = Field(
        None, description="Where to look: visitors, the stop's poster, or a point x, y, z on the map (m)."
    )
    point: Point | None = Field(None, description="Where an arm points: x, y, z on the map (m), z above the floor.")
    show: Media | None = Field(None, description="What visitors see on their page.")
    gesture: Gesture | None = Field(None, description="A gesture of the body's.")
    expression: Annotated[str, _WORD] | None = Field(None, description="What the face expresses, as happy.")
    wait: Wait | None = Field(None, description="How long, and for what, to wait.")

    @model_validator(mode="after")
    def _does_something(self) -> Self:
        if all(value is None for value in (getattr(self, name) for name in type(self).model_fields)):
            raise ValueError("a step needs at least one of " + ", ".join(type(self).model_fields))
        return self


class Question(TourPart):
    """A question that visitors may ask at a stop, and its answer."""

    id: Id
    question: Title = Field(description="As visitors read it, to press it.")
    words: Words = Field(default={}, description="Words by which it is recognized when it is asked aloud, by language.")
    answer: Step = Field(description="The answer: a step that says or shows something.")
