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
