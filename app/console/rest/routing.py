"""Routers of REST: they take a JSON body as it stands, and none that says one thing twice."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Coroutine
from typing import Any

from fastapi import APIRouter
from fastapi.routing import APIRoute
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from app.console.problems import Problem
from app.json_source import BeyondBounds, load_json
from app.yaml_source import suggestion


def router(tag: str) -> APIRouter:
    """A router whose routes are described under ``tag``."""
    return APIRouter(tags=[tag], route_class=_Route)


class _Route(APIRoute):
    """A route that refuses what JSON leaves open (RFC 8259: names in an object should be unique), and parameters
    that it does not know beside those that it does."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """The handler, which reads bodies our way."""
        handle = super().get_route_handler()
        known = [parameter.alias for parameter in self.dependant.query_params]

        async def handle_strictly(request: Request) -> Response:
            # A route that takes none is asked with one by caches' users, to have it anew.
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
    """Reads a body that says one thing twice as one that is malformed: which of both was meant, nobody knows."""

    async def json(self) -> Any:
        """The body's value. Raises json.JSONDecodeError, BeyondBounds."""
        if not hasattr(self, "_strict_json"):
            body = (await self.body()).decode()

            def member(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
                members = dict(pairs)
                if len(members) < len(pairs):
                    name = Counter(name for name, _ in pairs).most_common(1)[0][0]
                    second = max(body.rfind(json.dumps(name, ensure_ascii=plain)) for plain in (True, False))
                    raise json.JSONDecodeError(f"{name!r} stands twice in one object", body, max(second, 0))
                return members

            self._strict_json = load_json(body, member)
        return self._strict_json
