"""Texts of QR codes that carry their interaction, and what a tour's author accepted of them.

    HBBA:STOP/ARM                          the stop "arm" of the tour in use
    HBBA:STOP/ARM/EN/IT YIELDS WHEN PUSHED.    the same, with what to say there
    HBBA:SAY/FR/Bonjour !                  a text to say

Capitals, digits and `` $%*+-./:`` take two thirds of the modules of other characters, so that they are read from
farther. A code of up to 20 such characters has the fewest modules there are (21 x 21 at level M).

What a code says is data from a stranger: ``parse`` makes values of it, and ``accepted`` finds what of it a tour's
author named. All else is text to show.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass

from app.tours.model import Stop, Tour
from app.tours.values import LONGEST_CODE

PREFIX = "HBBA:"
#: Characters of a code's alphanumeric mode (ISO/IEC 18004).
ALPHANUMERIC = frozenset("0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ $%*+-./:")

_ID = re.compile(r"[A-Z0-9][A-Z0-9-]{0,39}")
_LANGUAGE = re.compile(r"[A-Z]{2,3}(?:-[A-Z0-9]{1,8}){0,4}")
_SHOWN = 60


class CodeError(ValueError):
    """A text that begins as a code of ours and is none; the message is one sentence with what is allowed."""


@dataclass(frozen=True, slots=True)
class CarriedText:
    """What to say: ``text`` in ``language`` (a tag such as en)."""

    language: str
    text: str


@dataclass(frozen=True, slots=True)
class StopCode:
    """The code of the stop ``stop`` (its id), with what to say there, if it carries that."""

    stop: str
    says: CarriedText | None = None

    def __str__(self) -> str:
        """The text of the code."""
        return f"{PREFIX}STOP/{self.stop.upper()}" + ("" if self.says is None else f"/{_carried(self.says)}")


@dataclass(frozen=True, slots=True)
class SayCode:
    """A code with something to say."""

    says: CarriedText

    def __str__(self) -> str:
        """The text of the code."""
        return f"{PREFIX}SAY/{_carried(self.says)}"


Code = StopCode | SayCode


@dataclass(frozen=True, slots=True)
class Accepted:
    """What a code does on a tour: leads to ``stop``, says ``says``, or both; one of them is not None."""

    stop: Stop | None
    says: CarriedText | None


def parse(text: str) -> Code | None:
    """The code that ``text`` is, or None for a text of others.

    Raises CodeError for a text that begins with ``HBBA:`` and is of no known form, or longer than ``LONGEST_CODE``
    bytes. Prefix, kind, id and language may be of any case.
    """
    if text[: len(PREFIX)].upper() != PREFIX:
        return None
    if len(text) > LONGEST_CODE or len(text.encode("utf-8", "replace")) > LONGEST_CODE:
        raise CodeError(f"a code of a tour has at most {LONGEST_CODE} bytes")
    kind, _, rest = text[len(PREFIX) :].partition("/")
    match kind.upper() if kind.isascii() else "":
        case "STOP":
            stop, slash, carried = rest.partition("/")
            if not _ID.fullmatch(stop.upper()) or not stop.isascii():
                raise CodeError(f"after HBBA:STOP/ comes a stop's id (letters, digits, hyphens), not {_shown(stop)}")
            return StopCode(stop.lower(), _says(carried) if slash else None)
        case "SAY":
            return SayCode(_says(rest))
    raise CodeError(f"after HBBA: comes STOP/ or SAY/, not {_shown(kind)}")


def accepted(text: str, tour: Tour) -> Accepted | None:
    """What the code ``text`` does on ``tour``; None for nothing: it is only shown.

    A code counts only where the tour's author named exactly this text: as a stop's poster, or in ``accept``. What a
    code of a stop carries is said where the code leads: to a stop that is left out, or is of another tour, none does.
    """
    poster = next((stop for stop in tour.stops if stop.poster == text), None)
    if poster is None and text not in tour.accept:
        return None
    try:
        code = parse(text)
    except CodeError:
        code = None
    if isinstance(code, SayCode) and poster is None:
        return Accepted(None, code.says)
    named = code if isinstance(code, StopCode) else None
    stop = poster or next((stop for stop in tour.stops if named is not None and stop.id == named.stop), None)
    if stop is None or stop.left_out:
        return None
    return Accepted(stop, named.says if named is not None and named.stop == stop.id else None)


def obeys_codes(tour: Tour) -> bool:
    """Whether there is a code that does something on ``tour``."""
    return bool(tour.accept) or any(stop.poster is not None and not stop.left_out for stop in tour.stops)


def is_capitals(text: str) -> bool:
    """Whether ``text`` takes a code's alphanumeric mode, which needs fewer modules."""
    return set(text) <= ALPHANUMERIC


def _carried(says: CarriedText) -> str:
    return f"{says.language.upper()}/{says.text}"


def _says(text: str) -> CarriedText:
    language, slash, words = text.partition("/")
    if not slash or not language.isascii() or not _LANGUAGE.fullmatch(language.upper()):
        raise CodeError(f"what a code says comes as LANGUAGE/TEXT, for example EN/HELLO, not {_shown(text)}")
    if not words.strip():
        raise CodeError("what a code says must not be empty")
    if any(unicodedata.category(character) in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp") for character in words):
        raise CodeError("what a code says is plain text on one line, without control characters")
    return CarriedText(language.lower(), words)


def _shown(text: str) -> str:
    return repr(text if len(text) <= _SHOWN else text[: _SHOWN - 1] + "…")
