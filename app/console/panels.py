"""Panels of packages: an ES module of the package, served by us and loaded by the page beside its own panels.

An entry point of the group ``hbba.panels`` names a :class:`Panel`; its name is the module's in ``/panels/NAME.js``. The
module is served under the page's own content policy, and to those alone who may use the console. What it exports and
what it is given: docs/extending.md.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fastapi import APIRouter
from fastapi.responses import FileResponse, JSONResponse, Response

from app.base.errors import ConfigError
from app.base.extensions import Extension, extensions
from app.console.problems import Problem

GROUP = "hbba.panels"
#: Prefix of a kind that is a channel's messages, and no type of the live stream.
CHANNEL = "channel/"

log = logging.getLogger("hbba.console")


@dataclass(frozen=True, slots=True)
class Panel:
    """A panel of the page: its ``title`` for people and the ES module ``script``.

    ``kinds``: what of the live stream it is given: types of its frames (``status``), and ``channel/NAME`` for the
    messages of the channel NAME.
    """

    title: str
    script: Path
    kinds: tuple[str, ...] = ()

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels that it wants messages of."""
        return tuple(kind.removeprefix(CHANNEL) for kind in self.kinds if kind.startswith(CHANNEL))


def load_panels() -> dict[str, Panel]:
    """The panels of all packages by name; one that cannot be used is left out, and logged in one sentence."""
    found: dict[str, Panel] = {}
    try:
        for name, extension in extensions(GROUP).items():
            try:
                found[name] = _loaded(extension)
            except ConfigError as failure:
                log.warning("panel %s is left out: %s", name, failure)
    except ConfigError as failure:
        log.warning("no panels of packages: %s", failure)
    return found


def _loaded(extension: Extension) -> Panel:
    panel = extension.load()
    if not re.fullmatch(r"[a-z0-9][a-z0-9_-]*", extension.name):
        raise ConfigError(f"the name {extension.name!r} has other characters than a-z, 0-9, _ and -")
    if not isinstance(panel, Panel):
        raise ConfigError(f"{extension.value} of {extension.distribution} is no Panel")
    if not panel.script.is_file():
        raise ConfigError(f"there is no file {panel.script} of {extension.distribution}")
    return panel


def panels_router(panels: Mapping[str, Panel]) -> APIRouter:
    """The routes that serve ``panels`` under ``/panels``: ``index.json``, which lists them, and a script each.

    Addresses in the list are relative to the page's, which may be served below another path.
    """
    router = APIRouter(prefix="/panels", include_in_schema=False)
    index: list[dict[str, Any]] = [
        {"name": name, "title": panel.title, "url": f"panels/{name}.js", "kinds": panel.kinds}
        for name, panel in panels.items()
    ]

    @router.get("/index.json")
    async def panels_index() -> Response:
        return JSONResponse(index)

    @router.get("/{name}.js")
    async def panel_script(name: str) -> Response:
        panel = panels.get(name)
        if panel is None:
            raise Problem(404, "no-such-panel", f"No package brings a panel {name!r}.")
        return FileResponse(panel.script, media_type="text/javascript")

    return router
