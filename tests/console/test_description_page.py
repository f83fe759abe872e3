"""The page on REST: every request with its body, every answer with its shape."""

from __future__ import annotations

import re
from html import escape
from typing import Any

import httpx
import pytest
from fastapi import FastAPI

from app.console.description_page import fields, page, type_words


def row_of(html: str, route: str) -> str:
    """What the page says of ``METHOD path``."""
    (row,) = re.findall(rf"<details><summary><code>{re.escape(escape(route))}</code>.*?</details>", html, re.DOTALL)
    return str(row)


async def test_the_body_of_a_desire_is_told_with_types_and_limits(client: httpx.AsyncClient) -> None:
    response = await client.get("/docs")
    assert response.status_code == 200
    row = row_of(response.text, "POST /api/v1/desires")
    asked, _, answered = row.partition("<p class=answer>")
    for words in (
        "Body (JSON): A desire to create.",
        "<code>class</code> (text, required) A class of GET /api/v1/desire-classes.",
        "<code>intensity</code> (number over 0, at most 8, required) How much it is desired.",
        "<code>utility</code> (number from 0 to 8, required)",
        "<code>security</code> (true or false, else <code>false</code>)",
        "<code>params</code> (object, else <code>{}</code>)",
        "<code>ttl</code> (number over 0, at most 2,592,000 or null)",
        "&quot;class&quot;: &quot;FindQRCodes&quot;",
    ):
        assert words in asked
    assert "<code>expires</code> (number or null)" in answered


def test_every_member_of_every_body_and_answer_is_on_the_page(app: FastAPI) -> None:
    document = app.openapi()
    html = page(document)

    def models(schema: Any) -> set[str]:
        if isinstance(schema, list):
            return set().union(*map(models, schema))
        if not isinstance(schema, dict):
            return set()
        name = schema.get("$ref", "").rpartition("/")[2]
        inside = models(list(schema.values()))
        return inside | ({name} | models(document["components"]["schemas"][name]) if name else set())

    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            row = row_of(html, f"{method.upper()} {path}")
            answers = {status: r for status, r in operation["responses"].items() if status.startswith("2")}
            for name in models([operation.get("requestBody", {}), answers]):
                for member in document["components"]["schemas"][name].get("properties", {}):
                    assert f"<code>{member}</code> (" in row, (path, method, name, member)
            assert ("Body (JSON" in row) == ("requestBody" in operation)
    assert "`" not in html
    assert "<h2>refusals</h2>" in html


@pytest.mark.parametrize(
    ("schema", "words"),
    [
        ({"type": "integer", "minimum": 1}, "whole number from 1"),
        ({"type": "number", "exclusiveMinimum": 0.5}, "number over 0.5"),
        ({"type": "string", "minLength": 1, "maxLength": 9}, "text of 1 to 9 characters"),
        ({"type": "string", "pattern": "^<a>$"}, "text like <code>^&lt;a&gt;$</code>"),
        ({"enum": ["a", "b"], "type": "string"}, "<code>a</code> or <code>b</code>"),
        ({"const": "a"}, "<code>a</code>"),
        ({"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}}, "list of 2, of number"),
        ({"type": "array", "items": {}}, "list of anything"),
        ({"type": "array", "prefixItems": [{"type": "number"}, {"type": "boolean"}]}, "list of number, true or false"),
        ({"anyOf": [{"type": "string"}, {"type": "string"}, {"type": "null"}]}, "text or null"),
    ],
)
def test_types_in_words(schema: dict[str, Any], words: str) -> None:
    assert type_words({}, schema) == words


def test_a_model_within_itself_is_told_once() -> None:
    tree = {
        "type": "object",
        "properties": {"branches": {"type": "array", "items": {"$ref": "#/components/schemas/Tree"}}},
    }
    document = {"components": {"schemas": {"Tree": tree}}}
    told = fields(document, {"$ref": "#/components/schemas/Tree"})
    assert told == "<ul><li><code>branches</code> (list of object) </li></ul>"
