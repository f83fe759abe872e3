"""What the robot says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from app.messages.base import Stamp, doc

SpeechState = Literal["silent", "speaking"]


@dataclass(frozen=True, slots=True)
class Speech:
    """What the robot says now, for subtitles and for its mouth; published with each change."""

    stamp: Stamp
    state: SpeechState
    text: Annotated[str, doc("The sentence that is said, or was said last.")]
    word_begin: Annotated[int, doc("The word of it that is said: its first character, from 0.")]
    word_end: Annotated[int, doc("The character after its last; equal to the first before the first word.")]
    viseme: Annotated[str, doc("The mouth: `closed`, `teeth`, `narrow`, `spread`, `mid`, `open`, `round` or `pursed`.")]
    language: Annotated[str, doc("Of the text, as `en`.")]
    desire: Annotated[str, doc("Id of the desire that is being fulfilled; empty while silent.")]
    waiting: Annotated[int, doc("Number of other texts that wait.")]


@dataclass(frozen=True, slots=True)
class HeardWords:
    """An utterance heard while words were listened for, also where it was none of them."""

    stamp: Annotated[float, doc("When the utterance began: seconds of the robot's clock.")]
    text: Annotated[str, doc("The word or phrase that was said; empty where that is unsure.")]
    unsure: Annotated[bool, doc("Whether to ask again: nothing may be done upon it.")]
    confidence: Annotated[float, doc("Of `likeliest`, 0 to 1.")]
    likeliest: Annotated[str, doc("Which of the words is the likeliest, also where it is unsure; empty: none.")]
    direction: Annotated[
        tuple[float, float, float],
        doc("Where it came from: a unit vector in `base_link`, from the array's middle."),
    ]
    words: Annotated[tuple[str, ...], doc("What was listened for.")]
    language: Annotated[str, doc("Of the words, as `en`.")]
