"""Estimated times of words and mouth, for engines that report none."""

from __future__ import annotations

from collections.abc import Sequence

from app.speech.text_spans import Span, words_of
from app.speech.utterance import MouthMoment, SpokenWord
from app.speech.visemes import Viseme, of_letter

#: Length of a pause, in letters, after punctuation.
_PAUSES = {",": 2.0, ";": 3.0, ":": 3.0, ".": 5.0, "!": 5.0, "?": 5.0, "…": 5.0}
#: Length of a word beyond its letters, in letters.
_WORD = 1.0


def estimated_duration_s(text: str, words_per_minute: float) -> float:
    """Length (s) of ``text`` spoken at ``words_per_minute``, of five letters and a space each."""
    weights = [_spoken(text, span) + _pause(text, span) for span in words_of(text)]
    return sum(weights) * 60.0 / (words_per_minute * (5 + _WORD))


def estimated_words(text: str, duration_s: float, start_s: float = 0.0) -> tuple[SpokenWord, ...]:
    """Words of ``text`` spread over ``duration_s`` from ``start_s`` on, each by its number of letters."""
    spans = words_of(text)
    whole = sum(_spoken(text, span) + _pause(text, span) for span in spans)
    if not whole:
        return ()
    words = []
    time_s, letter_s = start_s, duration_s / whole
    for span in spans:
        end_s = time_s + _spoken(text, span) * letter_s
        words.append(SpokenWord(*span, time_s, end_s))
        time_s = end_s + _pause(text, span) * letter_s
    return tuple(words)


def estimated_mouth(text: str, words: Sequence[SpokenWord]) -> tuple[MouthMoment, ...]:
    """Visemes of the letters of ``words``, spread evenly over each; closed between words with a pause between."""
    moments: list[MouthMoment] = []
    for index, word in enumerate(words):
        letters = [character for character in text[word.begin : word.end] if character.isalnum()]
        step_s = (word.end_s - word.start_s) / max(1, len(letters))
        moments += [MouthMoment(word.start_s + n * step_s, of_letter(letter)) for n, letter in enumerate(letters)]
        if index + 1 == len(words) or words[index + 1].start_s > word.end_s:
            moments.append(MouthMoment(word.end_s, Viseme.CLOSED))
    return tuple(moments)


def _spoken(text: str, span: Span) -> float:
    return sum(character.isalnum() for character in text[slice(*span)]) + _WORD


def _pause(text: str, span: Span) -> float:
    return _PAUSES.get(text[span[1] - 1], 0.0)
