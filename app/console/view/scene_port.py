"""The port of the 3D view alone: viser's page and sockets behind the same access rules, and a sign of life."""

from __future__ import annotations

from fastapi import FastAPI, Request
from fastapi.responses import JSONResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from app.console.access.origins import Ports
from app.console.problems import install_problem_handlers
from app.console.view.relay import view_router
from app.console.view.view import View

#: Reached without a login, and readable by the console's page alone, which finds out by it whether the port is reached.
HEALTH = "/viser/health"


class AtPorts:
    """ASGI: requests to the port of the 3D view go to ``scene``, all others to ``page``."""

    def __init__(self, page: ASGIApp, scene: ASGIApp, ports: Ports) -> None:
        self._page = page
        self._scene = scene
        self._ports = ports

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on."""
        to_scene = scope["type"] != "lifespan" and self._ports.at_scene(scope)
        await (self._scene if to_scene else self._page)(scope, receive, send)


def scene_app(view: View, ports: Ports) -> FastAPI:
    """What is served at the port of the 3D view. Takes a while to build."""
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)
    install_problem_handlers(app)

    @app.get(HEALTH)
    async def health(request: Request) -> Response:
        page = ports.page_origin(request.scope)
        # Without the exact origin the browser keeps the answer from the page.
        shared = {} if page is None else {"Access-Control-Allow-Origin": page}
        return JSONResponse({"status": "ok"}, headers={**shared, "Cache-Control": "no-store"})

    app.include_router(view_router(view, ports.page_origin))
    return app
