"""The OpenAPI description and a page to read it on, both served without anything from elsewhere."""

from __future__ import annotations

import asyncio
from typing import Any

from fastapi import FastAPI, Request
from fastapi.openapi.utils import get_openapi
from fastapi.responses import HTMLResponse, Response

from app.console.description_page import page
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

    ``app.openapi()`` takes a fifth of a second the first time, long enough to be felt by who drives: call it off the
    event loop.
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
        return Json(await asyncio.to_thread(request.app.openapi))

    @app.get(f"{prefix}/docs", include_in_schema=False)
    async def docs(request: Request) -> Response:
        return HTMLResponse(page(await asyncio.to_thread(request.app.openapi)))


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
