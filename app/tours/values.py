"""Values of which tours are made: texts by language, words to hear, ids, points."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    PlainValidator,
    WithJsonSchema,
)
from pydantic_core import CoreSchema, core_schema

from app.maps.zones import FURTHEST_M

#: A longer text is no sentence to say in one go, and Say takes no longer one (characters).
LONGEST_TEXT = 2000
#: A longer text does not fit into a code that a robot's camera can read (bytes in UTF-8, level M).
LONGEST_CODE = 300
LONGEST_TITLE = 100
MOST_LANGUAGES = 12


class Rule:
    """Metadata of an Annotated str: the whole text matches ``pattern``, which ``words`` say in a refusal."""

    def __init__(self, pattern: str, words: str) -> None:
        self._pattern, self._words = re.compile(pattern), words

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self._checked, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {**handler(schema), "pattern": f"^(?:{self._pattern.pattern})$"}

    def _checked(self, text: str) -> str:
        if not self._pattern.fullmatch(text):
            raise ValueError(f"should be {self._words}")
        return text


_SAID = Rule(r"[\s\S]*\S[\s\S]*", "a text, not space alone")
_LINE = Rule(r"[^\n\r]*\S[^\n\r]*", "a text on one line, not space alone")
#: No space, no ASCII beside letters, no signs of Latin-1; a form that regular expressions of JSON Schema share.
_LETTERS = r"[^\s\x00-\x40\x5b-\x60\x7b-\xbf]+"
_HEARD = Rule(
    rf"{_LETTERS}(?:[ ']{_LETTERS})*",
    "a word or short phrase of letters, with single spaces or apostrophes between them",
)

#: Id of a tour, stop or question: it never changes, so that files, codes and reports can refer to it.
Id = Annotated[str, Rule(r"[a-z0-9][a-z0-9-]{0,39}", "an id: 1 to 40 small letters, digits and hyphens")]
#: A language's tag: ``en``, ``fr``, ``en-gb``.
Language = Annotated[str, Rule(r"[a-z]{2,3}(-[a-z0-9]{1,8}){0,4}", "a language's tag, as en, fr or en-gb")]
#: Id of a place on the map.
PlaceId = Annotated[str, Rule(r"[a-z0-9-]{1,40}", "a place's id: 1 to 40 small letters, digits and hyphens")]

_Said = Annotated[str, Field(max_length=LONGEST_TEXT), _SAID]
_Line = Annotated[str, Field(max_length=LONGEST_TITLE), _LINE]
_Heard = Annotated[str, Field(max_length=60), _HEARD]

#: What is said or shown, by language.
Text = Annotated[dict[Language, _Said], Field(min_length=1, max_length=MOST_LANGUAGES)]
#: A heading, by language; it fits on a poster.
Title = Annotated[dict[Language, _Line], Field(min_length=1, max_length=MOST_LANGUAGES)]
#: Words or short phrases to listen for, by language.
Words = Annotated[
    dict[Language, Annotated[tuple[_Heard, ...], Field(min_length=1, max_length=10)]], Field(max_length=MOST_LANGUAGES)
]

_Metres = Annotated[float, Field(ge=-FURTHEST_M, le=FURTHEST_M)]
#: A point x, y, z on the map (m), z above the floor.
Point = tuple[_Metres, _Metres, Annotated[float, Field(ge=-100, le=100)]]

#: The text of a QR code.
CodeText = Annotated[str, Field(max_length=LONGEST_CODE), _SAID]


def _scalar(value: Any) -> Any:
    match value:
        case None | bool():
            return value
        case int() | float() if math.isfinite(value):
            return value
        case str() if not any("\ud800" <= character <= "\udfff" for character in value):
            return value
    raise ValueError("should be a text, a number, true, false or null")


#: A parameter's value.
Scalar = Annotated[
    str | bool | int | float | None,
    PlainValidator(_scalar),
    WithJsonSchema({"type": ["string", "boolean", "number", "null"]}),
]


class TourPart(BaseModel):
    """A part of a tour: frozen, without unknown keys, NaN or infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, populate_by_name=True)


def text_in(text: Mapping[str, str], language: str, fallback: str) -> str:
    """``text`` in ``language``, or in ``fallback``, or in whatever it has, or "" where it has none."""
    return text.get(language) or text.get(fallback) or next(iter(text.values()), "")
