"""Logging in: the token, or a role's password, for a cookie."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response
from pydantic import Field

from app.console.access.auth import Door, cookie_fields, cookie_name
from app.console.access.identity import Identity, role_name
from app.console.records.program import Session
from app.console.rest.answers import Json, problems
from app.console.rest.models import Request as RequestBody
from app.console.rest.routing import router as api_router


class LoginRequest(RequestBody):
    """The console's token, or the password of a role."""

    token: str = Field(max_length=512)


def session_router(door: Door) -> APIRouter:
    """Routes of ``/session``."""
    router = api_router("session")

    @router.get("/session", response_model=Session, summary="Check the login", responses=problems(401, 429))
    async def get_session(request: Request) -> Response:
        """200 if this client may use the console; 401 where it must log in."""
        return Json(Session(True, door.asks, role_name(await door.admit(request.scope))))

    @router.post("/session", response_model=Session, summary="Log in", responses=problems(400, 401, 422, 429, 503))
    async def log_in(login: LoginRequest, request: Request) -> Response:
        """Begins a session and sets its cookie, which no script can read and no other site can use, until the browser
        is closed. The session is over when nothing was asked in it for 12 hours, at the logout, or with the console.
        It has the role of the password; with the token it is a supervisor's. After five wrong tokens an address waits,
        longer with each further one."""
        session, role = await door.log_in(login.token, request.scope)
        answer = Json(Session(True, door.asks, role_name(Identity(role, ""))))
        if session is not None:
            answer.set_cookie(cookie_name(request.scope), session, **cookie_fields(request.scope))
        return answer

    @router.delete("/session", status_code=204, summary="Log out")
    async def log_out(request: Request) -> Response:
        """Ends this browser's session, and its WebSockets."""
        door.log_out(request.scope)
        answer = Response(status_code=204)
        answer.delete_cookie(cookie_name(request.scope), **cookie_fields(request.scope))
        return answer

    return router
