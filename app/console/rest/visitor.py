"""What visitors' phones may do: enter with the key of this run, press what the tour waits for, see what it shows."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Path, Request
from fastapi.responses import FileResponse, Response

from app.console.access.auth import VISITOR_COOKIE, VISITOR_PATHS, Door, cookie_fields, cookie_name
from app.console.access.login_attempts import origin_of
from app.console.access.rate_limit import RateLimit
from app.console.live.messages import VisitorLink
from app.console.live.tour_visitors import TourVisitors
from app.console.live.visitor_link import visitor_link
from app.console.problems import Problem
from app.console.rest.answers import Json, problems
from app.console.rest.media_answer import MEDIA_FILE, media_answer
from app.console.rest.routing import router as api_router
from app.console.rest.visitor_models import VisitorKey, VisitorPress
from app.tours.checks import media_of
from app.tours.run_service import TourRefused

if TYPE_CHECKING:
    from app.program.system import System

#: Presses of one phone, and of all; pictures and parts of videos of one phone.
PRESSES_AT_ONCE, PRESSES_PER_S = 5, 0.5
ALL_PRESSES_AT_ONCE, ALL_PRESSES_PER_S = 20, 4.0
FILES_AT_ONCE, FILES_PER_S = 60, 5.0

_TOO_OFTEN: dict[int | str, dict[str, Any]] = {
    429: {"description": "Too often; `Retry-After` says how many seconds to wait."}
}


def visitor_router(
    system: System, door: Door, visitors: TourVisitors, *, listens: str, names: Sequence[str]
) -> APIRouter:
    """Routes of ``/visitor``, and the link to its page; ``listens`` and ``names`` as of the console."""
    router = api_router("visitors")
    now = time.monotonic
    presses = RateLimit(now, burst=PRESSES_AT_ONCE, per_s=PRESSES_PER_S)
    all_presses = RateLimit(now, burst=ALL_PRESSES_AT_ONCE, per_s=ALL_PRESSES_PER_S)
    files = RateLimit(now, burst=FILES_AT_ONCE, per_s=FILES_PER_S)

    @router.get("/tour-run/visitors", response_model=VisitorLink, summary="The link for visitors' phones")
    async def get_visitor_link(request: Request) -> Response:
        """For operators: the page for visitors with the key of this run, and its QR code. The key changes with each
        run, and opens nothing but that page."""
        base = f"{request.url.scheme}://{request.url.netloc}"
        return Json(visitor_link(door.visitors.key, base=base, listens=listens, names=names, asks=door.asks))

    @router.get(
        "/visitor/session",
        status_code=204,
        summary="Check whether a visitor has entered",
        responses={401: {"description": "This phone has no key of this run."}, **problems(429)},
    )
    async def check_visitor(request: Request) -> Response:
        """204 for one that may see the tour, an operator's browser among them."""
        if door.visitor(request.scope) is None:
            await door.admit(request.scope)
        return Response(status_code=204)

    @router.post(
        "/visitor/session",
        status_code=204,
        summary="Enter as a visitor",
        responses={**problems(400, 422), 401: {"description": "The key is of another run."}, **_TOO_OFTEN},
    )
    async def enter_as_visitor(visitor: VisitorKey, request: Request) -> Response:
        """With the key of the link. Sets a cookie, which no script can read and which is sent below `/visitor` alone;
        it is over with the run."""
        address = request.client.host if request.client else ""
        session = door.visitors.enter(visitor.key, origin_of(address))
        answer = Response(status_code=204)
        fields = cookie_fields(request.scope, VISITOR_PATHS.rstrip("/"))
        answer.set_cookie(cookie_name(request.scope, VISITOR_COOKIE), session, **fields)
        return answer

    @router.post(
        "/visitor/press",
        status_code=204,
        summary="Press as a visitor",
        responses={**_TOO_OFTEN, **problems(400, 409, 422)},
    )
    async def press_as_visitor(press: VisitorPress, request: Request) -> Response:
        """A `button` that the tour waits for, or a question that may be asked now."""
        presses.take(door.visitor(request.scope) or "operator")
        if (press.button is None) == (press.ask is None):
            words = "exactly one of button and ask is needed"
            raise Problem(422, "invalid-request", f"{words[0].upper()}{words[1:]}.", errors=[("button", words)])
        view = visitors.view
        offered = press.button in view.buttons or press.ask in {question.id for question in view.questions}
        if not offered:
            raise Problem(409, "tour-refused", "That cannot be pressed now.")
        all_presses.take(None)
        try:
            server = system.tour_run.server
            if press.button is not None:
                server.press(press.button)
            elif press.ask is not None:
                server.ask(press.ask)
        except TourRefused:
            # Why not may be the operator's business.
            raise Problem(409, "tour-refused", "That cannot be done now.") from None
        return Response(status_code=204)

    @router.get(
        "/visitor/media/{file:path}",
        response_class=FileResponse,
        summary="A picture or a video of the tour",
        responses={200: MEDIA_FILE, **_TOO_OFTEN, **problems(404, 409, 416)},
    )
    async def get_visitor_media(
        file: Annotated[str, Path(description="As the tour names it.", examples=["media/arm.jpg"])], request: Request
    ) -> Response:
        """Only what the tour under way names, out of the folder of tours; also in part (`Range`)."""
        files.take(door.visitor(request.scope) or "operator")
        tour = visitors.tour
        if tour is None or file not in {name for _, name in media_of(tour)}:
            raise Problem(404, "no-such-media", "The tour under way shows no such picture or video.")
        return await media_answer(system.tours.media, file, request.headers.get("range"))

    return router
