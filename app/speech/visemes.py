"""Visemes: the shapes of the mouth, of phonemes (IPA) or, without these, of letters."""

from __future__ import annotations

import unicodedata
from enum import StrEnum


class Viseme(StrEnum):
    """A shape of the mouth, from closed lips to an open jaw.

    ``closed``: lips together, and silence; ``teeth``: lower lip at the teeth (f, v); ``narrow``: consonants made behind
    the lips (t, s, k); ``spread``: i, e; ``mid``: the neutral vowels; ``open``: a; ``round``: o; ``pursed``: u, w.
    """

    CLOSED = "closed"
    TEETH = "teeth"
    NARROW = "narrow"
    SPREAD = "spread"
    MID = "mid"
    OPEN = "open"
    ROUND = "round"
    PURSED = "pursed"


_PHONEMES = {
    Viseme.CLOSED: "pbmɓʙ",
    Viseme.TEETH: "fvɱⱱ",
    Viseme.SPREAD: "ieɪyɨʏeɛj",
    Viseme.MID: "əɜɚɝʌɐɘɵɤøœ",
    Viseme.OPEN: "aæɑɒɶ",
    Viseme.ROUND: "oɔ",
    Viseme.PURSED: "uʊwʉɯʍɥ",
}
_BY_PHONEME = {character: viseme for viseme, characters in _PHONEMES.items() for character in characters}
_LETTERS = {
    Viseme.CLOSED: "bmp",
    Viseme.TEETH: "fv",
    Viseme.SPREAD: "eiy",
    Viseme.OPEN: "a",
    Viseme.ROUND: "o",
    Viseme.PURSED: "uw",
}
_BY_LETTER = {letter: viseme for viseme, letters in _LETTERS.items() for letter in letters}
#: Stress and length marks, tone letters: signs of a phoneme that is named after or before them.
_MARKS = frozenset("ˈˌːˑ‿.˥˦˧˨˩0123456789")


def of_phoneme(ipa: str) -> Viseme:
    """The viseme of a phoneme's IPA name; "" is a pause."""
    for character in unicodedata.normalize("NFD", ipa):
        if character in _MARKS or unicodedata.combining(character):
            continue
        return _BY_PHONEME.get(character, Viseme.NARROW)
    return Viseme.CLOSED


def of_letter(letter: str) -> Viseme:
    """An estimate of the viseme of a letter or digit, by the letter's usual sound."""
    plain = unicodedata.normalize("NFD", letter.lower())[:1]
    return _BY_LETTER.get(plain, Viseme.NARROW)
