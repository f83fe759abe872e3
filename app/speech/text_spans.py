"""Words and sentences of a text, as spans of its characters."""

from __future__ import annotations

import re
from collections.abc import Sequence

from app.speech.utterance import SpokenWord

Span = tuple[int, int]

#: An abbreviation with a point (``Mr.``, ``z.B.``) is taken for a sentence's end only where a capital does not decide:
#: a wrong cut is a pause that is a little longer.
_SENTENCE = re.compile(r"\S.*?(?:[.!?…]+[\"'»”’)\]]*(?=\s|$)|[。！？]+|\n\s*\n|$)", re.DOTALL)


def words_of(text: str) -> list[Span]:
    """Spans of what stands between spaces and has a letter or digit."""
    return [
        found.span() for found in re.finditer(r"\S+", text) if any(character.isalnum() for character in found.group())
    ]


def sentences_of(text: str) -> list[Span]:
    """Spans of the sentences with something to say, in order; together they hold every word of the text."""
    return [
        (found.start(), found.start() + len(found.group().rstrip()))
        for found in _SENTENCE.finditer(text)
        if words_of(found.group())
    ]


def spoken_words(text: str, events: Sequence[tuple[int, float, float]]) -> tuple[SpokenWord, ...]:
    """Words of ``text`` with the times of an engine's ``events``: the position of a character, start and end (s).

    An engine may cut a word (``3.5``, ``jusqu'à``) or leave out a part of it; a word here is what stands between
    spaces, from its first event to its last.
    """
    times: dict[Span, tuple[float, float]] = {}
    spans = words_of(text)
    for position, start_s, end_s in events:
        span = next((span for span in spans if position < span[1]), None)
        if span is not None:
            known = times.get(span, (start_s, end_s))
            times[span] = min(known[0], start_s), max(known[1], end_s)
    return tuple(SpokenWord(*span, *times[span]) for span in spans if span in times)
