"""The clients' records and operations are those that the program describes."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import pytest


def test_the_client_is_as_the_program_describes_itself(client_types: ModuleType) -> None:
    for file, text in client_types.generate().items():
        assert file.read_text("utf-8") == client_types.formatted(text), f"{file.name}: run `make types`"


def test_the_typescript_client_is_as_the_program_describes_itself(typescript_client: ModuleType) -> None:
    for file, text in typescript_client.generate().items():
        assert file.read_text("utf-8") == text, f"{file.name}: run `make types`"


def test_names_of_typescript(typescript_client: ModuleType) -> None:
    assert typescript_client.camel("get_tour_posters") == "getTourPosters"


@pytest.mark.parametrize(
    ("schema", "kind"),
    [
        ({"type": "integer"}, "int"),
        ({"type": "string", "format": "binary"}, "bytes"),
        ({"enum": ["map", "odom"]}, "Literal['map', 'odom']"),
        ({"anyOf": [{"$ref": "#/components/schemas/Desire"}, {"type": "null"}]}, "Desire | None"),
        ({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}, "tuple[float, float]"),
        ({"type": "array", "items": {"type": "string"}}, "list[str]"),
        ({"type": "object", "additionalProperties": {"type": "number"}}, "dict[str, float]"),
        ({"type": ["number", "null"]}, "float | None"),
        ({}, "Any"),
    ],
)
def test_a_schema_has_its_type(client_types: ModuleType, schema: dict[str, Any], kind: str) -> None:
    assert client_types.python(schema) == kind


@pytest.mark.parametrize("schema", [{"type": "object", "properties": {"x": {}}}, {"type": "colour"}])
def test_what_has_no_name_is_refused(client_types: ModuleType, schema: dict[str, Any]) -> None:
    with pytest.raises(TypeError):
        client_types.python(schema)


def test_what_may_be_left_out_comes_last_and_is_left_out(client_types: ModuleType) -> None:
    declared = {"properties": {"ttl": {"type": "number"}, "class": {"type": "string"}}, "required": ["class"]}
    text = client_types.struct("Wish", declared)
    assert 'omit_defaults=True, rename={"class_": "class"}' in text
    assert text.index("class_: str") < text.index("ttl: float | UnsetType = UNSET")
