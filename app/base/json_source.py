"""JSON of unknown origin, read within bounds that no text in good faith reaches."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

#: Greatest depth of nested values,
DEEPEST = 64
#: and no whole number has more digits: what is greater is no float either.
MOST_DIGITS = 250


class BeyondBounds(ValueError):
    """JSON, but of a number or a depth that is not read; the message is for people."""


def load_json(text: str, of_pairs: Callable[[list[tuple[str, Any]]], Any] | None = None) -> Any:
    """The value of ``text``; ``of_pairs`` makes an object of its members, if they are not to be a dict.

    Raises json.JSONDecodeError for what is no JSON, BeyondBounds for a number of more than ``MOST_DIGITS`` digits and
    for values more than ``DEEPEST`` deep.
    """
    try:
        value = json.loads(text, parse_int=whole_number, object_pairs_hook=of_pairs)
    except RecursionError:
        raise BeyondBounds(_TOO_DEEP) from None
    if text.count("[") + text.count("{") > DEEPEST and _depth_exceeds(value, DEEPEST):
        raise BeyondBounds(_TOO_DEEP)
    return value


def whole_number(text: str) -> int:
    """The number of the digits ``text``. Raises BeyondBounds for more than ``MOST_DIGITS``."""
    if len(text) > MOST_DIGITS:
        raise BeyondBounds(f"a number has {len(text)} digits; at most {MOST_DIGITS} are read")
    return int(text)


_TOO_DEEP = f"it is nested too deeply: values lie at most {DEEPEST} deep within others"


def _depth_exceeds(value: Any, most: int) -> bool:
    level = [value]
    for _ in range(most + 1):
        level = [
            inner
            for outer in level
            if isinstance(outer, dict | list)
            for inner in (outer.values() if isinstance(outer, dict) else outer)
        ]
        if not level:
            return False
    return True
