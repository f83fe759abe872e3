"""A record's schema says what is sent of it, and the wire sends it so."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import jsonschema
import msgspec
import pytest
from pydantic import BaseModel, Field

from app.console import schema
from app.console.wire import frame
from app.messages.base import doc


class Model(BaseModel):
    """Declared with pydantic."""

    colour: str = Field("red", description="A colour.")


class Step(msgspec.Struct, frozen=True, rename={"cls": "class"}):
    """With a name that Python cannot write."""

    cls: str
    after: Annotated[float | None, doc("In seconds; null: at once.")] = None


@dataclass(frozen=True, slots=True)
class Plan:
    """A record with others in it."""

    steps: tuple[Step, ...]
    corner: tuple[float, float]
    model: Model
    costs: Mapping[str, float | None]


def test_a_schema_says_what_is_sent() -> None:
    schemas = schema.sent([Plan], "#/$defs/{name}")
    assert schemas.keys() == {"Plan", "Step", "Model"}
    assert schemas["Step"]["required"] == ["class", "after"], "a default is sent, too"
    assert schemas["Step"]["properties"]["after"]["description"] == "In seconds; null: at once."
    assert schemas["Model"]["required"] == ["colour"]
    assert schemas["Plan"]["properties"]["corner"]["items"] == {"type": "number"}
    message = schema.with_type("plan", schemas["Plan"])
    text = frame("plan", {"steps": [Step("a")], "corner": (0.0, 1.5), "model": {"colour": "red"}, "costs": {"x": None}})
    assert text.startswith('{"type":"plan","steps":[{"class":"a","after":null}],')
    decoded = json.loads(text)
    checker = jsonschema.Draft202012Validator({**message, "$defs": schemas})
    assert checker.is_valid(decoded)
    assert not checker.is_valid({**decoded, "type": "jump"})
    for member in message["required"]:
        assert not checker.is_valid({name: value for name, value in decoded.items() if name != member})


def test_what_is_no_number_is_null_on_the_wire() -> None:
    assert json.loads(frame("plan", {"a": math.nan, "b": math.inf})) == {"type": "plan", "a": None, "b": None}


def test_of_what_clients_send_a_default_may_be_left_out() -> None:
    (step,) = schema.received([Step]).values()
    assert step["required"] == ["class"]


@pytest.mark.parametrize("record", [object, type("Thing", (), {})])
def test_what_is_no_record_has_no_schema(record: type[Any]) -> None:
    with pytest.raises(TypeError):
        schema.sent([record])
