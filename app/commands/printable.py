"""Text from files and from others, made harmless for a terminal."""

from __future__ import annotations

import unicodedata

_KEPT = "\n\t"


def printable(text: str) -> str:
    """``text`` with what steers a terminal, or turns the direction of writing, written out: ``\\x1b``, ``\\u202e``.

    Lines and tabs stay.
    """
    if text.isprintable():
        return text
    return "".join(_written(each) if each not in _KEPT else each for each in text)


def one_line(text: str) -> str:
    """``text`` as :func:`printable` makes it, its ends of lines written out too."""
    return printable(text).replace("\n", "\\n").replace("\t", "\\t")


def _written(character: str) -> str:
    # Control characters, directions and the like, half of a pair that has no other half.
    harmful = unicodedata.category(character) in ("Cc", "Cf", "Cs", "Zl", "Zp")
    return character.encode("unicode_escape").decode() if harmful else character
