"""The OpenAPI description and a page to read it on, both served without anything from elsewhere."""

from __future__ import annotations

from html import escape
from typing import Any

from fastapi import FastAPI, Request
from fastapi.openapi.utils import get_openapi
from fastapi.responses import HTMLResponse, Response

from app.console.problems import MEDIA_TYPE, ProblemDocument
from app.console.rest.answers import Json

_ABOUT = """Desires in, intentions out: create a desire and see which strategies attention selects for it, which
filters move, and why. Every refusal is a problem document (RFC 9457). Stamps are the robot's clock in seconds; angles
are radians.

Beyond loopback every request needs the console's token as `Authorization: Bearer`. What changes faster than is worth
polling goes over the WebSocket `/api/v1/live`.
"""

_TAGS = [
    {"name": "desires", "description": "What the robot shall want."},
    {"name": "attention", "description": "What it chose, from what, and what happened."},
    {"name": "robot", "description": "Its body: pose, guard, emergency stop."},
    {"name": "maps", "description": "Where the robot has been, where it is, and where it shall go."},
    {"name": "program", "description": "Modules and channels."},
    {"name": "recordings", "description": "What the robot lived, kept on disk and lived again."},
    {"name": "playback", "description": "Where a recording is played: its transport."},
    {"name": "session", "description": "Logging in."},
]


def describe(app: FastAPI, prefix: str) -> None:
    """Serve ``openapi.json`` and ``docs`` under ``prefix``; must come after the routes it describes.

    ``app.openapi()`` takes a tenth of a second the first time, long enough to be felt by who drives: call it before
    anybody does, off the event loop.
    """

    def document() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = _document(app)
        return app.openapi_schema

    # mypy takes a method for something that cannot be replaced.
    app.openapi = document  # type: ignore[method-assign]

    # FastAPI remembers endpoints for as long as the process lives: one that held the application would keep it.
    @app.get(f"{prefix}/openapi.json", include_in_schema=False)
    async def openapi(request: Request) -> Response:
        return Json(request.app.openapi())

    @app.get(f"{prefix}/docs", include_in_schema=False)
    async def docs(request: Request) -> Response:
        return HTMLResponse(_page(request.app.openapi()))


def _document(app: FastAPI) -> dict[str, Any]:
    schema = get_openapi(
        title="HBBA console",
        version="1",
        summary="A robot with selective attention.",
        description=_ABOUT,
        tags=_TAGS,
        routes=app.routes,
    )
    components = schema.setdefault("components", {}).setdefault("schemas", {})
    problem = ProblemDocument.model_json_schema(ref_template="#/components/schemas/{model}")
    components.update(problem.pop("$defs", {}))
    components["ProblemDocument"] = problem
    # FastAPI describes its own shape of a refused body, which never leaves this console.
    for name in ("HTTPValidationError", "ValidationError"):
        components.pop(name, None)
    reference = {"$ref": "#/components/schemas/ProblemDocument"}
    for path in schema["paths"].values():
        for operation in path.values():
            for status, response in operation["responses"].items():
                if status.startswith("4"):
                    response["content"] = {MEDIA_TYPE: {"schema": reference}}
    return schema


def _page(document: dict[str, Any]) -> str:
    sections = []
    for tag in document["tags"]:
        rows = [
            _row(path, method, operation)
            for path, methods in document["paths"].items()
            for method, operation in methods.items()
            if tag["name"] in operation.get("tags", ())
        ]
        sections.append(f"<h2>{escape(tag['name'])}</h2><p>{escape(tag['description'])}</p>{''.join(rows)}")
    return _PAGE.format(about=escape(document["info"]["description"]), sections="".join(sections))


def _row(path: str, method: str, operation: dict[str, Any]) -> str:
    parts = [f"<p>{escape(operation.get('description', ''))}</p>"]
    parameters = "".join(
        f"<li><code>{escape(p['name'])}</code> ({escape(p['in'])}{', required' if p.get('required') else ''}) "
        f"{escape(p.get('description', ''))}</li>"
        for p in operation.get("parameters", ())
    )
    if parameters:
        parts.append(f"<ul>{parameters}</ul>")
    answers = ", ".join(
        f"<code>{escape(status)}</code> {escape(response.get('description', ''))}"
        for status, response in operation["responses"].items()
    )
    parts.append(f"<p>Answers: {answers}</p>")
    return (
        f"<details><summary><code>{method.upper()} {escape(path)}</code> {escape(operation.get('summary', ''))}"
        f"</summary>{''.join(parts)}</details>"
    )


_PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>HBBA REST</title>
<style>body{{font:16px/1.5 system-ui,sans-serif;max-width:50rem;margin:2rem auto;padding:0 1rem;color:#dde4ee;
background:#0c1016}}code{{background:#1c2430;padding:.1em .4em;border-radius:4px}}a{{color:#7db7ff}}
summary{{cursor:pointer;padding:.3em 0}}details{{border-bottom:1px solid #223}}.about{{white-space:pre-line}}</style>
<h1>HBBA over REST</h1><p class="about">{about}</p>
<p>Whole description, with the shape of every answer: <a href="openapi.json">openapi.json</a></p>{sections}</html>
"""
