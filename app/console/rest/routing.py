"""Routers of REST: strict about JSON bodies, which may not repeat a key, and about query parameters."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Coroutine, Iterable
from typing import Any

from fastapi import APIRouter, FastAPI
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from app.base.json_source import BeyondBounds, load_json
from app.base.yaml_source import suggestion
from app.console import schema
from app.console.access.identity import identity_of, require
from app.console.access.roles import needed_role
from app.console.problems import Problem

#: The prefix of REST and of the live streams.
API = "/api/v1"

#: Pairs of these make one character; one alone is none, though JSON can say it.
_ESCAPED_SURROGATE = re.compile(r"\\u[dD][89a-fA-F][0-9a-fA-F]{2}")


def operation_id(route: APIRoute) -> str:
    """The name of an operation: its function's, which client generators make their own functions' of."""
    return route.name


def router(tag: str) -> APIRouter:
    """A router of routes under :data:`API`, described under ``tag``: for :func:`add_routes`."""
    return APIRouter(prefix=API, tags=[tag], route_class=_Route, generate_unique_id_function=operation_id)


def add_routes(app: FastAPI, routers: Iterable[APIRouter]) -> None:
    """Add the routes of ``routers`` to ``app`` as they are.

    ``include_router`` would make each of them once more, which took half of the time that the console needs to start.
    """
    app.router.routes.extend(route for router in routers for route in router.routes)


def records(routers: Iterable[APIRouter]) -> list[type[Any]]:
    """The records that the routes of ``routers`` answer with."""
    routes = [route for router in routers for route in router.routes if isinstance(route, _Route)]
    return [route.record for route in routes if route.record is not None]


class _Route(APIRoute):
    """A route whose answer is a record.

    It refuses clients without the role that it needs (:data:`app.console.access.roles.OPERATIONS`); a route that is not
    in that table cannot be made. It refuses what JSON leaves open (RFC 8259: names in an object should be unique), and
    parameters that it does not know beside those that it does.
    """

    def __init__(self, path: str, endpoint: Callable[..., Any], *, response_model: Any = None, **options: Any) -> None:
        """``response_model`` is the record; the route describes its answer by it, and leaves encoding to the answer."""
        #: The record it answers with; None: nothing, or no record.
        self.record: type[Any] | None = response_model if isinstance(response_model, type) else None
        if self.record is not None:
            content = {"application/json": {"schema": {"$ref": schema.REFERENCE.format(name=self.record.__name__)}}}
            status = options.get("status_code") or 200
            responses = options.get("responses") or {}
            options["responses"] = {**responses, status: {"content": content, **responses.get(status, {})}}
        super().__init__(path, endpoint, response_model=None, **options)

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """The handler, which reads bodies our way."""
        handle = super().get_route_handler()
        known = [parameter.alias for parameter in self.dependant.query_params]
        needed = needed_role(self.name)

        async def handle_strictly(request: Request) -> Response:
            if needed is not None:
                require(identity_of(request.scope), needed, f"{request.method} {request.url.path}")
            # A route without parameters may be asked with one, to get past a cache.
            if known and (unknown := [name for name in request.query_params if name not in known]):
                errors = [(f"query.{name}", f"unknown parameter; {suggestion(name, known)}") for name in unknown]
                raise Problem(422, "invalid-request", "; ".join(map(": ".join, errors)), errors=errors)
            try:
                return await handle(_StrictRequest(request.scope, request.receive))
            except HTTPException as failure:
                # What reading a body raises, FastAPI says to be malformed: this is JSON, and is not taken.
                if isinstance(failure.__cause__, BeyondBounds):
                    message = str(failure.__cause__)
                    raise Problem(
                        422, "invalid-request", f"The body is not taken: {message}.", errors=[("body", message)]
                    ) from None
                raise

        return handle_strictly


class _StrictRequest(Request):
    """Refuses as malformed a body with a key given twice (either value could be meant), and one with text that no
    answer could repeat."""

    async def json(self) -> Any:
        """The body's value. Raises json.JSONDecodeError, BeyondBounds."""
        if not hasattr(self, "_strict_json"):
            body = (await self.body()).decode()

            def member(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
                members = dict(pairs)
                if len(members) < len(pairs):
                    name = Counter(name for name, _ in pairs).most_common(1)[0][0]
                    second = max(body.rfind(json.dumps(name, ensure_ascii=plain)) for plain in (True, False))
                    raise json.JSONDecodeError(f"{name!r} occurs twice in one object", body, max(second, 0))
                return members

            value = load_json(body, member)
            if (escaped := _ESCAPED_SURROGATE.search(body)) is not None and _has_half_characters(value):
                raise json.JSONDecodeError("it holds half a character, which UTF-8 cannot write", body, escaped.start())
            self._strict_json = value
        return self._strict_json


def _has_half_characters(value: Any) -> bool:
    """Whether any text in ``value``, names of members among it, holds a surrogate."""
    waiting = [value]
    while waiting:
        match waiting.pop():
            case str() as text:
                if any("\ud800" <= character <= "\udfff" for character in text):
                    return True
            case dict() as members:
                waiting.extend((*members, *members.values()))
            case list() as values:
                waiting.extend(values)
    return False
