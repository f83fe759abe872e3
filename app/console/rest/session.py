"""Logging in: the token for a cookie."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response

from app.console.problems import Problem
from app.console.rest.answers import Json, problems
from app.console.rest.program_models import LoginRequest, SessionModel
from app.console.rest.routing import router as api_router
from app.console.security import COOKIE, Door, unauthorized


def session_router(door: Door) -> APIRouter:
    """Routes of ``/session``."""
    router = api_router("session")
    needed = door.cookie is not None

    @router.get("/session", response_model=SessionModel, summary="May I?", responses=problems(401))
    async def get_session(request: Request) -> Response:
        """Answers if this client may use the console; 401 where it must log in."""
        if not door.knows(request.headers):
            raise unauthorized()
        return Json({"authenticated": True, "token_needed": needed})

    @router.post("/session", response_model=SessionModel, summary="Log in", responses=problems(400, 401, 422))
    async def log_in(login: LoginRequest) -> Response:
        """Sets a cookie that no script can read and no other site can use, until the browser is closed."""
        if not door.opens_to(login.token):
            raise Problem(401, "wrong-token", "This is not the token; it was printed when the console was started.")
        answer = Json({"authenticated": True, "token_needed": needed})
        if door.cookie is not None:
            answer.set_cookie(COOKIE, door.cookie, httponly=True, samesite="strict", path="/")
        return answer

    @router.delete("/session", status_code=204, summary="Log out")
    async def log_out() -> Response:
        answer = Response(status_code=204)
        answer.delete_cookie(COOKIE, httponly=True, samesite="strict", path="/")
        return answer

    return router
