"""What the robot feels of how its desires fare, and what that does to them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from msgspec import Struct

from app.messages.base import Stamp, doc

Emotion = Literal["joy", "anger", "sadness", "fear"]


@dataclass(frozen=True, slots=True)
class Modulation:
    """The intensity of a desire is raised by an emotion."""

    by: Annotated[float, doc("So much is added to its intensity, over 0; the sum is at most 8.")]
    emotion: Annotated[Emotion, doc("The emotion that its neglect has fed.")]


class EmotionSource(Struct, frozen=True, rename={"cls": "class"}):
    """A desire class that an emotion comes from."""

    cls: str
    share: Annotated[float, doc("Its part of the emotion's intensity, over 0 and at most 1.")]
    neglected: Annotated[bool, doc("Whether it is desired, and not exploited, now.")]


@dataclass(frozen=True, slots=True)
class EmotionLevel:
    """One emotion."""

    emotion: Emotion
    intensity: Annotated[float, doc("0 to 1.")]
    sources: Annotated[tuple[EmotionSource, ...], doc("What has fed it, the greatest share first, at most 5.")]


class RaisedIntensity(Struct, frozen=True, rename={"cls": "class"}):
    """A desire whose intensity is raised."""

    id: Annotated[str, doc("Of the desire.")]
    cls: str
    by: float
    emotion: Emotion


@dataclass(frozen=True, slots=True)
class ShownEmotion:
    """The emotion that face and voice show, one at a time."""

    emotion: Emotion
    strength: Annotated[float, doc("How strongly it shows: over 0, to 1.")]
    desire: Annotated[
        str,
        doc(
            "Id of the desire Express that is stated for the face; empty: none, since another expression is desired, "
            "or the robot has no face."
        ),
    ] = ""


@dataclass(frozen=True, slots=True)
class EmotionState:
    """What is felt; published on change, at most once a second."""

    stamp: Stamp
    emotions: Annotated[tuple[EmotionLevel, ...], doc("Joy, anger, sadness, fear, in this order.")]
    modulates: Annotated[bool, doc("Whether emotions raise the intensity of desires that are ignored.")]
    raised: Annotated[tuple[RaisedIntensity, ...], doc("The desires that are raised now.")] = ()
    shows: Annotated[bool, doc("Whether face and voice show what is felt.")] = False
    shown: Annotated[ShownEmotion | None, doc("What they show now; null: nothing.")] = None
