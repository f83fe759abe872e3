"""The page's types are those of the Python records."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import pytest


def test_the_pages_types_are_as_the_records_declare(page_types: ModuleType) -> None:
    assert page_types.FILE.read_text("utf-8") == page_types.generate(), "run `make types`"


@pytest.mark.parametrize(
    ("schema", "typescript"),
    [
        ({"type": "integer"}, "number"),
        ({"type": "string"}, "string"),
        ({"enum": ["map", "odom"]}, '"map" | "odom"'),
        ({"const": "ok"}, '"ok"'),
        ({"anyOf": [{"$ref": "Desire"}, {"type": "null"}]}, "Desire | null"),
        ({"type": "array", "items": {"type": "number"}}, "number[]"),
        ({"type": "array", "items": {"anyOf": [{"type": "number"}, {"type": "null"}]}}, "(number | null)[]"),
        ({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}, "[number, number]"),
        ({"type": "array", "prefixItems": [{"type": "string"}, {"$ref": "Zone"}]}, "[string, Zone]"),
        ({"type": "object", "additionalProperties": {"$ref": "Reason"}}, "Record<string, Reason>"),
        ({"type": "object", "additionalProperties": True}, "Record<string, unknown>"),
        ({"type": "object", "title": "JsonSchema"}, "JsonSchema"),
        ({}, "unknown"),
    ],
)
def test_a_schema_has_its_type(page_types: ModuleType, schema: dict[str, Any], typescript: str) -> None:
    assert page_types.typescript(schema) == typescript


@pytest.mark.parametrize("schema", [{"type": "object", "properties": {"x": {}}}, {"type": "colour"}])
def test_what_has_no_name_is_refused(page_types: ModuleType, schema: dict[str, Any]) -> None:
    with pytest.raises(TypeError):
        page_types.typescript(schema)


def test_a_member_is_described_and_optional_only_where_it_may_be_left_out(page_types: ModuleType) -> None:
    schema = {
        "description": "A pose.",
        "properties": {"x": {"type": "number", "description": "In m."}, "theta": {"type": "number"}},
        "required": ["x"],
    }
    assert page_types.interface("Pose", schema) == (
        "/** A pose. */\nexport interface Pose {\n  /** In m. */\n  x: number;\n  theta?: number;\n}\n"
    )


def test_what_is_too_long_for_a_line_is_broken(page_types: ModuleType) -> None:
    names = [f"{letter * 20}" for letter in "abcdefg"]
    text = page_types.interface(
        "Long", {"description": " ".join(names), "properties": {"kind": {"enum": names}}, "required": ["kind"]}
    )
    assert max(map(len, text.splitlines())) <= page_types.WIDTH
    assert f'    | "{names[-1]}";\n' in text
