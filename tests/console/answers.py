"""Answers of REST as the records that they are declared to be."""

from __future__ import annotations

import json
from typing import Any, TypeVar

import httpx
import jsonschema
import msgspec

from app.console import schema

RecordT = TypeVar("RecordT")


def answered(response: httpx.Response, record: type[RecordT]) -> RecordT:
    """The ``record`` that ``response`` holds: all its members, of their types, and no others."""
    assert response.is_success, response.text
    found = msgspec.json.decode(response.content, type=record)
    assert json.loads(msgspec.json.encode(found)) == response.json()
    return found


def described(response: httpx.Response, record: type[Any]) -> None:
    """Raises ValidationError unless ``response`` holds what is described of ``record``, member by member."""
    assert response.is_success, response.text
    components = {"schemas": strict(schema.sent([record]))}
    whole = {"$ref": schema.REFERENCE.format(name=record.__name__), "components": components}
    jsonschema.Draft202012Validator(whole).validate(response.json())


def strict(schema: Any) -> Any:
    """``schema`` without the room for what is not described, which it has for later versions."""
    if isinstance(schema, list):
        return [strict(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    closed = {"additionalProperties": False} if "properties" in schema else {}
    return {**closed, **{key: strict(value) for key, value in schema.items()}}


def is_problem(response: httpx.Response, status: int, kind: str) -> dict[str, Any]:
    """Check that ``response`` is this problem and return the document."""
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    document: dict[str, Any] = response.json()
    assert document["type"] == f"urn:hbba:problem:{kind}"
    assert document["status"] == status
    assert document["title"]
    assert document["detail"]
    return document
