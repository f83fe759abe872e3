"""JSON Schema as every tool understands it."""

from __future__ import annotations

from typing import Any


def with_plain_lists(schema: Any) -> None:
    """Say in ``schema``, at any depth, that a list has N values of one type in the older words: ``items`` and how many,
    where pydantic says ``prefixItems``."""
    inside = schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ()
    for each in inside:
        with_plain_lists(each)
    if isinstance(schema, dict) and isinstance(places := schema.get("prefixItems"), list):
        first = places[0]
        if all(place == first for place in places):
            del schema["prefixItems"]
            schema["items"] = first
