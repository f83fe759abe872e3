"""Whether places and posters moved: a map that is corrected moves them by small steps, by which no goal changes."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from app.maps.poster_places import Poster
from app.messages import Place

#: What moves by less (m, rad) is where it was.
_SMALL: Final = 0.1


def same_places(before: tuple[Place, ...], now: tuple[Place, ...]) -> bool:
    """Whether all are where they were, in the same order, and nothing else of them has changed."""
    return len(before) == len(now) and all(
        replace(a, x=0.0, y=0.0, heading=0.0) == replace(b, x=0.0, y=0.0, heading=0.0)
        and max(abs(a.x - b.x), abs(a.y - b.y), abs(a.heading - b.heading)) < _SMALL
        for a, b in zip(before, now, strict=True)
    )


def same_posters(before: tuple[Poster, ...], now: tuple[Poster, ...]) -> bool:
    """Whether all hang where they hung, in the same order."""
    return len(before) == len(now) and all(
        (a.number, a.text) == (b.number, b.text) and max(abs(a.x - b.x), abs(a.y - b.y)) < _SMALL
        for a, b in zip(before, now, strict=True)
    )
