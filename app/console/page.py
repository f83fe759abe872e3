"""The pages that Vite built (the operator's, the robot's face, that of a tour's visitors, the one on REST), or a plain
one that says how to build them."""

from __future__ import annotations

import asyncio
import mimetypes
import stat
from pathlib import Path

from fastapi import FastAPI
from fastapi.responses import HTMLResponse, Response
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.staticfiles import StaticFiles
from starlette.types import Receive, Scope, Send

# Reads the computer's tables of types, which must not happen first in the middle of a request.
mimetypes.init()

#: Pages at an address without the file's ending.
ADDRESSES = {"face": "face.html", "visitor": "visitor.html"}

#: How the build packs its files, the best first, and the endings of the packed ones.
CODINGS = {"br": ".br", "gzip": ".gz"}

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
            if (packed := await asyncio.to_thread(self._packed, path, scope)) is not None:
                return packed
            response = await super().get_response(path, scope)
            response.headers.add_vary_header("Accept-Encoding")
            return response
        except HTTPException as error:
            if error.status_code == 404 and path in (".", "index.html", "face.html", "visitor.html", "rest.html"):
                return HTMLResponse(_NOT_BUILT)
            raise

    def _packed(self, path: str, scope: Scope) -> Response | None:
        """The file as it was packed when the page was built, in the best coding that the client takes; else None."""
        if scope["method"] not in ("GET", "HEAD"):
            return None
        asked = Headers(scope=scope).get("accept-encoding", "")
        name = "index.html" if path == "." else path
        for coding, ending in CODINGS.items():
            if not accepts(asked, coding):
                continue
            file, found = self.lookup_path(name + ending)
            if found is not None and stat.S_ISREG(found.st_mode):
                # Its entity tag is its own, for it is made of the packed file's time and size.
                response = self.file_response(file, found, scope)
                response.headers.add_vary_header("Accept-Encoding")
                if response.status_code != 304:
                    response.headers["Content-Encoding"] = coding
                    response.headers["Content-Type"] = _type(name)
                return response
        return None


def accepts(header: str, coding: str) -> bool:
    """Whether a client that sends ``header`` as Accept-Encoding takes ``coding`` (RFC 9110, 12.5.3)."""
    for part in header.lower().split(","):
        name, _, parameters = part.partition(";")
        if name.strip() == coding:
            return not parameters.replace(" ", "").startswith("q=0") or any(
                digit in "123456789" for digit in parameters
            )
    return False


def _type(name: str) -> str:
    kind = mimetypes.guess_type(name)[0] or "text/plain"
    return f"{kind}; charset=utf-8" if kind.startswith("text/") else kind


def install_page(app: FastAPI, folder: Path) -> None:
    """Serve ``folder`` wherever no route of ``app`` is; but below ``/api`` nothing else is."""
    page, nothing = Page(folder), app.router.not_found

    async def elsewhere(scope: Scope, receive: Receive, send: Send) -> None:
        is_page = scope["type"] == "http" and not scope["path"].startswith("/api/")
        await (page if is_page else nothing)(scope, receive, send)

    # A mount at / would also take what other routes know by another method: a 404 where a 405 is due.
    app.router.default = elsewhere
