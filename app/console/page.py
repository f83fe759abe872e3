"""The pages that Vite built (the operator's, the robot's face, that of a tour's visitors, the one on REST), or a plain
one that says how to build them."""

from __future__ import annotations

import mimetypes
from pathlib import Path

from fastapi import FastAPI
from fastapi.responses import HTMLResponse, Response
from starlette.exceptions import HTTPException
from starlette.staticfiles import StaticFiles
from starlette.types import Receive, Scope, Send

# Reads the computer's tables of types, which must not happen first in the middle of a request.
mimetypes.init()

#: Pages at an address without the file's ending.
ADDRESSES = {"face": "face.html", "visitor": "visitor.html"}

_NOT_BUILT = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>HBBA console</title>
<style>body{font:16px/1.5 system-ui,sans-serif;max-width:40rem;margin:4rem auto;padding:0 1rem;color:#dde4ee;
background:#0c1016}code{background:#1c2430;padding:.1em .4em;border-radius:4px}a{color:#7db7ff}</style>
<h1>The robot runs, its page is not built</h1>
<p>In a checkout, <code>make run</code> builds it. By hand: <code>cd web &amp;&amp; npm ci
&amp;&amp; npm run build</code>, then reload this page.</p>
<p>REST works without it: see <a href="api/v1/openapi.json">its description</a>.</p></html>
"""


class Page(StaticFiles):
    """The built page; where there is none yet, how to build it. Looked for with each request, so a reload is enough."""

    def __init__(self, folder: Path) -> None:
        super().__init__(directory=folder, html=True, check_dir=False)
        # Starlette would refuse to serve from a folder that is not there yet.
        self.config_checked = True

    async def get_response(self, path: str, scope: Scope) -> Response:
        path = ADDRESSES.get(path, path)
        try:
            return await super().get_response(path, scope)
        except HTTPException as error:
            if error.status_code == 404 and path in (".", "index.html", "face.html", "visitor.html", "rest.html"):
                return HTMLResponse(_NOT_BUILT)
            raise


def install_page(app: FastAPI, folder: Path) -> None:
    """Serve ``folder`` wherever no route of ``app`` is; but below ``/api`` nothing else is."""
    page, nothing = Page(folder), app.router.not_found

    async def elsewhere(scope: Scope, receive: Receive, send: Send) -> None:
        is_page = scope["type"] == "http" and not scope["path"].startswith("/api/")
        await (page if is_page else nothing)(scope, receive, send)

    # A mount at / would also take what other routes know by another method: a 404 where a 405 is due.
    app.router.default = elsewhere
