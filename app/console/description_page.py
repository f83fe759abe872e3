"""The OpenAPI description as a page for people: every request with its body, every answer with its shape."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from html import escape
from typing import Any

Schema = Mapping[str, Any]

_JSON = "application/json"
#: FastAPI's words for an answer of which nothing was said.
_UNSAID = "Successful Response"


def page(document: Schema) -> str:
    """HTML of the OpenAPI ``document`` (3.1); needs nothing from elsewhere."""
    sections = []
    for tag in document["tags"]:
        rows = [
            _row(document, path, method, operation)
            for path, methods in document["paths"].items()
            for method, operation in methods.items()
            if tag["name"] in operation.get("tags", ())
        ]
        sections.append(f"<h2>{escape(tag['name'])}</h2><p>{_marked(tag['description'])}</p>{''.join(rows)}")
    problem = document["components"]["schemas"].get("ProblemDocument", {})
    sections.append(
        f"<h2>refusals</h2><p>{_marked(problem.get('description', ''))}</p>{fields(document, problem, asked=False)}"
        f"{_common(document)}"
    )
    return _PAGE.format(about=_paragraphs(document["info"]["description"]), sections="".join(sections))


def fields(document: Schema, schema: Schema, above: tuple[str, ...] = (), *, asked: bool = True) -> str:
    """The members of an object of ``schema`` as a list: name, type, limits, description, and theirs inside.

    ``above`` names the models it stands in, which are not told again; ``asked``: it is sent, so that it matters which
    members may be left out. Empty for what has no members.
    """
    name, schema = _resolved(document, schema)
    if name in above:
        return ""
    required = schema.get("required", ())
    rows = []
    for member, kind in schema.get("properties", {}).items():
        words = [type_words(document, kind)]
        if asked and member in required:
            words.append("required")
        elif asked and "default" in kind:
            words.append(f"else {_code(json.dumps(kind['default'], ensure_ascii=False))}")
        inner = "".join(fields(document, each, (*above, name), asked=asked) for each in _inside(kind))
        rows.append(f"<li>{_code(member)} ({', '.join(words)}) {_marked(_about(document, kind))}{inner}</li>")
    return f"<ul>{''.join(rows)}</ul>" if rows else ""


def type_words(document: Schema, schema: Schema) -> str:
    """The type of a value and its limits in words, as HTML."""
    _, schema = _resolved(document, schema)
    if choices := schema.get("anyOf"):
        return " or ".join(dict.fromkeys(type_words(document, each) for each in choices))
    if "const" in schema or "enum" in schema:
        return " or ".join(_code(str(word)) for word in schema.get("enum", [schema.get("const")]))
    match schema.get("type"):
        case "string":
            like = f" like {_code(schema['pattern'])}" if "pattern" in schema else ""
            return f"text{_range(schema, 'minLength', 'maxLength', ' characters')}{like}"
        case "number":
            return f"number{_limits(schema)}"
        case "integer":
            return f"whole number{_limits(schema)}"
        case "boolean":
            return "true or false"
        case "null":
            return "null"
        case "array" if "prefixItems" in schema:
            return f"list of {', '.join(type_words(document, each) for each in schema['prefixItems'])}"
        case "array":
            many = _range(schema, "minItems", "maxItems", "")
            return f"list{many and many + ','} of {type_words(document, schema.get('items', {}))}"
        case "object":
            return "object"
    return "anything"


def _row(document: Schema, path: str, method: str, operation: Schema) -> str:
    parts = [_paragraphs(operation.get("description", ""))]
    parameters = "".join(
        f"<li>{_code(p['name'])} ({escape(p['in'])}, {type_words(document, p.get('schema', {}))}"
        f"{', required' if p.get('required') else ''}) {_marked(p.get('description', ''))}</li>"
        for p in operation.get("parameters", ())
    )
    if parameters:
        parts.append(f"<ul>{parameters}</ul>")
    if body := operation.get("requestBody"):
        parts.append(_body(document, body))
    for status, response in operation["responses"].items():
        if "$ref" in response:
            continue  # an answer that many operations share is written once, among the refusals
        shape = response.get("content", {}).get(_JSON, {}).get("schema")
        inner = "" if shape is None else "".join(fields(document, each, asked=False) for each in _inside(shape))
        about = response.get("description", "").replace(_UNSAID, "")
        parts.append(f"<p class=answer>Answer {_code(status)} {_marked(about)}</p>{inner}")
    return (
        f"<details><summary>{_code(f'{method.upper()} {path}')} {_marked(operation.get('summary', ''))}"
        f"</summary>{''.join(parts)}</details>"
    )


def _common(document: Schema) -> str:
    """Refusals that several operations share, each written once."""
    statuses = {
        response["$ref"].rpartition("/")[2]: status
        for methods in document["paths"].values()
        for operation in methods.values()
        for status, response in operation["responses"].items()
        if "$ref" in response
    }
    shared = document["components"].get("responses", {})
    return "".join(
        f"<p class=answer>Answer {_code(status)} {_marked(shared[name]['description'])}</p>"
        for name, status in sorted(statuses.items(), key=lambda pair: pair[1])
    )


def _body(document: Schema, body: Schema) -> str:
    """What is sent: JSON, as far as this console goes."""
    schema = body["content"][_JSON]["schema"]
    models = [each for each in schema.get("anyOf", [schema]) if each.get("type") != "null"]
    (model,) = models[:1]
    _, resolved = _resolved(document, model)
    needed = "" if body.get("required") else ", may be left out"
    text = f"<p>Body (JSON{needed}): {_marked(resolved.get('description', ''))}</p>{fields(document, model)}"
    for example in resolved.get("examples", ())[:1]:
        text += f"<pre>{escape(json.dumps(example, ensure_ascii=False))}</pre>"
    return text


def _resolved(document: Schema, schema: Schema) -> tuple[str, Schema]:
    """The model that ``schema`` refers to and its name, or itself and "" where it refers to none."""
    reference = schema.get("$ref")
    if reference is None:
        return "", schema
    name = reference.rpartition("/")[2]
    return name, document["components"]["schemas"][name]


def _about(document: Schema, schema: Schema) -> str:
    """What is said of a value: by its field, or by one of the types that it may have."""
    own = schema.get("description")
    return own or next((each["description"] for each in schema.get("anyOf", ()) if "description" in each), "")


def _inside(schema: Schema) -> Iterator[Schema]:
    """The models that a value of ``schema`` consists of."""
    if "$ref" in schema:
        yield schema
    for each in (*schema.get("anyOf", ()), *schema.get("prefixItems", ())):
        yield from _inside(each)
    for key in ("items", "additionalProperties"):
        if isinstance(schema.get(key), Mapping):
            yield from _inside(schema[key])


def _limits(schema: Schema) -> str:
    """Of a number: `` over 0, at most 8``, `` from 0 to 8``."""
    if "minimum" in schema and "maximum" in schema:
        return f" from {_figure(schema['minimum'])} to {_figure(schema['maximum'])}"
    words = (("minimum", "from"), ("exclusiveMinimum", "over"), ("maximum", "at most"), ("exclusiveMaximum", "under"))
    told = ", ".join(f"{word} {_figure(schema[key])}" for key, word in words if key in schema)
    return f" {told}" if told else ""


def _figure(value: float) -> str:
    return f"{value:,.0f}" if value == round(value) else f"{value:g}"


def _range(schema: Schema, least: str, most: str, unit: str) -> str:
    low, high = schema.get(least), schema.get(most)
    if low is not None and low == high:
        return f" of {low}{unit}"
    if low is not None and high is not None:
        return f" of {low} to {high}{unit}"
    if high is not None:
        return f" of at most {high}{unit}"
    return f" of at least {low}{unit}" if low is not None else ""


def _marked(text: str) -> str:
    """``text`` as HTML: what stands in backticks is code."""
    return re.sub(r"`+([^`]+)`+", r"<code>\1</code>", escape(text))


def _paragraphs(text: str) -> str:
    return "".join(f"<p>{_marked(part)}</p>" for part in text.split("\n\n"))


def _code(text: str) -> str:
    return f"<code>{escape(text)}</code>"


_PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>HBBA REST</title>
<style>body{{font:16px/1.5 system-ui,sans-serif;max-width:50rem;margin:2rem auto;padding:0 1rem;color:#dde4ee;
background:#0c1016}}code,pre{{background:#1c2430;padding:.1em .4em;border-radius:4px}}pre{{white-space:pre-wrap}}
a{{color:#7db7ff}}summary{{cursor:pointer;padding:.3em 0}}details{{border-bottom:1px solid #223}}
.answer{{margin:.6em 0 0}}ul{{margin:.2em 0;padding-left:1.4em}}</style>
<h1>HBBA over REST</h1>{about}
<p>The same for tools: <a href="openapi.json">openapi.json</a>;
the live stream: <a href="live.json">live.json</a></p>{sections}</html>
"""
