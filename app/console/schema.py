"""JSON Schemas of the records that cross between the program and its clients.

A record is declared once, as a frozen dataclass or msgspec Struct. From its schema follow the OpenAPI and AsyncAPI
descriptions and the page's TypeScript (``scripts/page_types.py``).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal

import msgspec
import numpy as np
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

#: Where OpenAPI and AsyncAPI documents keep schemas.
REFERENCE = "#/components/schemas/{name}"

Schema = dict[str, Any]


def sent(records: Iterable[type[Any]], reference: str = REFERENCE) -> dict[str, Schema]:
    """The schemas by name of ``records`` and of all records in them, as the console sends them: every member is there.

    ``reference`` is where one schema finds another by its ``{name}``. Raises TypeError for what is no record.
    """
    found = _schemas(records, reference, "serialization")
    for schema in found.values():
        if "properties" in schema:
            schema["required"] = list(schema["properties"])
    return found


def received(records: Iterable[type[Any]], reference: str = REFERENCE) -> dict[str, Schema]:
    """The same of what clients send: a member with a default may be left out."""
    return _schemas(records, reference, "validation")


def _schemas(
    records: Iterable[type[Any]], reference: str, mode: Literal["serialization", "validation"]
) -> dict[str, Schema]:
    models: dict[str, type[BaseModel]] = {}

    def of_model(cls: type[Any]) -> Schema:
        if issubclass(cls, np.ndarray):
            return {"type": "array"}
        if not issubclass(cls, BaseModel):
            raise NotImplementedError(f"{cls.__qualname__} is no record")
        models[cls.__name__] = cls
        return {"$ref": reference.format(name=cls.__name__)}

    _, found = msgspec.json.schema_components(records, schema_hook=of_model, ref_template=reference)
    if models:
        asked = [(model, mode) for model in models.values()]
        _, document = models_json_schema(asked, ref_template=reference.replace("{name}", "{model}"))
        found |= document["$defs"]
    with_plain_lists(found)
    _with_null(found)
    return found


def _with_null(schema: Any) -> None:
    """Describe in ``schema``, at any depth, a number that may be NaN or infinite as a number or null."""
    inside = schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ()
    for each in inside:
        _with_null(each)
    if isinstance(schema, dict) and schema.get("nullable") is True:
        del schema["nullable"]
        schema["anyOf"] = [{"type": schema.pop("type")}, {"type": "null"}]


def with_type(kind: str, schema: Schema) -> Schema:
    """``schema`` of a record, as a message of the live stream: ``type`` before its members."""
    members = {"type": {"const": kind}, **schema["properties"]}
    return schema | {"properties": members, "required": ["type", *schema.get("required", [])]}


def with_plain_lists(schema: Any) -> None:
    """Describe in ``schema``, at any depth, a list of N values of one type by ``items``, ``minItems`` and ``maxItems``.

    Not every tool understands ``prefixItems``.
    """
    inside = schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ()
    for each in inside:
        with_plain_lists(each)
    if isinstance(schema, dict) and isinstance(places := schema.get("prefixItems"), list):
        first = places[0]
        if all(place == first for place in places):
            del schema["prefixItems"]
            schema["items"] = first
