"""Answers of REST as the records that they are declared to be."""

from __future__ import annotations

import json
from typing import TypeVar

import httpx
import msgspec

RecordT = TypeVar("RecordT")


def answered(response: httpx.Response, record: type[RecordT]) -> RecordT:
    """The ``record`` that ``response`` holds: all its members, of their types, and no others."""
    assert response.is_success, response.text
    found = msgspec.json.decode(response.content, type=record)
    assert json.loads(msgspec.json.encode(found)) == response.json()
    return found
