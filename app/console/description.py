"""REST (OpenAPI) and the live stream (AsyncAPI) described for tools; ``docs`` leads to a page that shows REST."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Any

from fastapi import FastAPI, Request
from fastapi.openapi.utils import get_openapi
from fastapi.responses import RedirectResponse, Response

from app.console import schema
from app.console.access.auth import COOKIE, OPEN_PATHS, VISITOR_COOKIE, VISITOR_PATHS, cookie_name
from app.console.access.roles import Role, needed_role
from app.console.problems import ProblemDocument
from app.console.rest.answers import Json, problem_content

_ABOUT = """Desires in, intentions out: create a desire and see which strategies attention selects for it, which
filters move, and why. Every refusal is a problem document (RFC 9457). Stamps are the robot's clock in seconds; angles
are radians.

Beyond loopback every request needs the console's token, or the password of a role, as `Authorization: Bearer`, or the
cookie that `POST /api/v1/session` gives for it. The role that an operation needs is its `x-role`: a spectator may do
what says `spectator`, an operator also what says `operator`, a supervisor everything. What changes faster than is worth
polling goes over the WebSocket `/api/v1/live`, which `/api/v1/live.json` describes (AsyncAPI).
"""

_TAGS = [
    {"name": "desires", "description": "What the robot is asked to do: create, change and remove desires."},
    {"name": "attention", "description": "The intention and its reasons, strategies, budgets, timeline."},
    {"name": "robot", "description": "The body: pose, guard, emergency stop."},
    {"name": "maps", "description": "Maps, the robot's place on them, and its goal."},
    {"name": "memory", "description": "What the robot remembers: export it, delete it."},
    {"name": "tours", "description": "Guided tours: edit, check, exchange, print posters, lead, report."},
    {"name": "visitors", "description": "What phones of a tour's visitors may do, by the key of its run."},
    {"name": "program", "description": "Modules and channels."},
    {"name": "recordings", "description": "Logs of the robot: record, list, download, replay."},
    {"name": "playback", "description": "The transport of a played recording: play, pause, seek, speed."},
    {"name": "webhooks", "description": "Other programs that are called when something happens."},
    {"name": "session", "description": "Log in and out."},
]


#: Swagger UI on ``openapi.json``, as Vite built it; relative to ``docs``.
REST_PAGE = "../../rest.html"

#: How a client authenticates.
_SCHEMES = {
    "token": {
        "type": "http",
        "scheme": "bearer",
        "description": "The token printed when the console was started, or the password of a role.",
    },
    "session": {
        "type": "apiKey",
        "in": "cookie",
        "name": COOKIE,
        "description": "What `POST /api/v1/session` gives a browser for the token or a password.",
    },
}
#: How a visitor's phone does, in the few operations that are for visitors.
_VISITOR = {
    "type": "apiKey",
    "in": "cookie",
    "name": VISITOR_COOKIE,
    "description": "What `POST /api/v1/visitor/session` gives a phone for the key of this run.",
}

#: Refusals by the authentication or the router, possible before any operation: name, status, when.
_LOGIN_NEEDED = ("LoginNeeded", "401", "The console's token, or the password of a role, is needed.")
_FORBIDDEN = ("Forbidden", "403", "Another role is needed, or a web page of another origin asks for a change.")
_METHOD_NOT_ALLOWED = ("MethodNotAllowed", "405", "Another method, or with an empty name another path; see `Allow`.")
_AMBIGUOUS = ("AmbiguousBody", "400", "A body states its size in one way: `Content-Length` or chunks.")
_TOO_SLOW = ("TooSlow", "408", "A body comes within 20 s.")
_BODY_TOO_LARGE = ("BodyTooLarge", "413", "A body has at most 64 KiB.")
_WRONG_HOST = ("WrongHost", "421", "Without a token, the console answers to this computer's own names only.")
_TOO_MANY_LOGINS = ("TooManyLogins", "429", "Too many wrong tokens: wait as long as `Retry-After` says.")
_HEADER_TOO_LARGE = ("HeaderTooLarge", "431", "A header has at most 32 KiB and 100 fields.")
_TOO_MANY_CONNECTIONS = ("TooManyConnections", "503", "All connections are taken; see `Retry-After`.")
_COMMON = (
    _LOGIN_NEEDED,
    _FORBIDDEN,
    _METHOD_NOT_ALLOWED,
    _AMBIGUOUS,
    _TOO_SLOW,
    _BODY_TOO_LARGE,
    _WRONG_HOST,
    _TOO_MANY_LOGINS,
    _HEADER_TOO_LARGE,
    _TOO_MANY_CONNECTIONS,
)


def describe(app: FastAPI, prefix: str, *, answers: Sequence[type[Any]] = (), token_needed: bool = False) -> None:
    """Serve ``openapi.json``, ``live.json`` and ``docs`` under ``prefix``; must come after the routes it describes.

    ``answers`` are the records that its routes answer with. ``token_needed``: requests need the token or a session.
    The first call of ``app.openapi()`` takes 0.2 s, which a driver would notice: call it off the event loop.
    """

    def document() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = _document(app, answers, token_needed)
        return app.openapi_schema

    # mypy takes a method for something that cannot be replaced.
    app.openapi = document  # type: ignore[method-assign]

    # FastAPI keeps endpoints until the process ends: one that held the application would keep it in memory.
    @app.get(f"{prefix}/openapi.json", include_in_schema=False)
    async def openapi(request: Request) -> Response:
        document = await asyncio.to_thread(request.app.openapi)
        schemes = _SCHEMES | {
            "session": _SCHEMES["session"] | {"name": cookie_name(request.scope)},
            "visitor": _VISITOR | {"name": cookie_name(request.scope, VISITOR_COOKIE)},
        }
        return Json(document | {"components": document["components"] | {"securitySchemes": schemes}})

    @app.get(f"{prefix}/live.json", include_in_schema=False)
    async def live(request: Request) -> Response:
        def described() -> dict[str, Any]:
            from app.console.live.asyncapi import description  # seldom asked for: not at the program's start

            cookie = cookie_name(request.scope)
            secure = request.url.scheme == "https"
            return description(request.url.netloc, secure=secure, token_needed=token_needed, cookie=cookie)

        return Json(await asyncio.to_thread(described))

    @app.get(f"{prefix}/docs", include_in_schema=False)
    async def docs() -> Response:
        # A built page beside the operator page: relative, so that a proxy may serve the console under a path.
        return RedirectResponse(REST_PAGE)


def _document(app: FastAPI, answers: Sequence[type[Any]], token_needed: bool) -> dict[str, Any]:
    document = get_openapi(
        title="HBBA console",
        version="1",
        summary="A robot with selective attention.",
        description=_ABOUT,
        tags=_TAGS,
        # Relative to where the description was had: under whatever name and port this console was reached.
        servers=[{"url": "/", "description": "The console that serves this description."}],
        routes=app.routes,
    )
    components = document.setdefault("components", {})
    models = components.setdefault("schemas", {})
    problem = ProblemDocument.model_json_schema(ref_template="#/components/schemas/{model}")
    models.update(problem.pop("$defs", {}))
    models.update(schema.sent(answers))
    models["ProblemDocument"] = problem
    # FastAPI describes its own shape of a refused body, which never leaves this console.
    for name in ("HTTPValidationError", "ValidationError"):
        models.pop(name, None)
    components["responses"] = {name: {"description": when, "content": problem_content()} for name, _, when in _COMMON}
    components["securitySchemes"] = _SCHEMES | {"visitor": _VISITOR}
    document["security"] = [{name: []} for name in _SCHEMES] + ([] if token_needed else [{}])
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            _complete(path, method, operation)
            if path.startswith(VISITOR_PATHS) and path not in OPEN_PATHS:
                operation["security"] = [*document["security"], {"visitor": []}]
    schema.with_plain_lists(document)
    return document


def _complete(path: str, method: str, operation: dict[str, Any]) -> None:
    """Add to an operation what its route does not say: its permission, and the answers of authentication and router."""
    responses = operation["responses"]
    for status, response in responses.items():
        if status >= "400":
            response["content"] = problem_content()
    common = [_WRONG_HOST, _HEADER_TOO_LARGE, _TOO_MANY_CONNECTIONS]
    if path in OPEN_PATHS:
        operation["security"] = []
    else:
        common += [_LOGIN_NEEDED, _TOO_MANY_LOGINS]
    role = needed_role(operation["operationId"])
    if role is not None:
        operation["x-role"] = role.value
        if role is not Role.SPECTATOR:
            common.append(_FORBIDDEN)
    if "{" in path:
        common.append(_METHOD_NOT_ALLOWED)
    if method != "get":
        common += [_FORBIDDEN, _AMBIGUOUS, _TOO_SLOW, _BODY_TOO_LARGE]
    if operation["operationId"] == "log_in":
        common.append(_TOO_MANY_LOGINS)
    for name, status, _ in common:
        responses.setdefault(status, {"$ref": f"#/components/responses/{name}"})
    operation["responses"] = dict(sorted(responses.items()))
