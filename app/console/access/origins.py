"""Origins of the console: of its page, and of the 3D view's frame on a second port.

A frame of another origin may have a process of its own, where its drawing does not delay the page that drives. Both
ports are of one host, so that a session's cookie holds for both; see :mod:`app.console.view.scene_port`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from starlette.datastructures import Headers
from starlette.types import Scope

_DEFAULT_PORTS = {"http": 80, "https": 443}

#: A host as a header may name it: a name, an IPv4 address or a bracketed IPv6 address, and a port.
_HOST = re.compile(
    r"(?:([a-z0-9](?:[a-z0-9._-]*[a-z0-9])?)\.?|\[([0-9a-f:.]+)\])(?::[0-9]{1,5})?", re.IGNORECASE | re.ASCII
)


def host_name(host: str) -> str:
    """The name or address in a ``Host`` header, in lower case and without brackets; "" for what is no host."""
    found = _HOST.fullmatch(host)
    return "" if found is None else (found[1] or found[2]).lower()


def scheme_of(scope: Scope) -> str:
    """``http`` or ``https``."""
    return "https" if scope["scheme"] in ("https", "wss") else "http"


@dataclass(frozen=True, slots=True)
class Ports:
    """Where the console listens for its page, and where for the 3D view alone."""

    page: int
    scene: int

    def at_scene(self, scope: Scope) -> bool:
        """Whether a request came in at the port of the 3D view."""
        server = scope.get("server")
        return server is not None and server[1] == self.scene

    def scene_origin(self, scope: Scope) -> str | None:
        """The origin of the 3D view for a page that a request to the page's port belongs to.

        None where the client's port is another (a proxy or a tunnel is between), so that the second one can not be
        guessed; and for an IPv6 address, which a content security policy cannot name.
        """
        return _moved(scope, self.page, self.scene)

    def page_origin(self, scope: Scope) -> str | None:
        """The origin of the page that may frame a view asked for at the scene's port, or None likewise."""
        return _moved(scope, self.scene, self.page)


def _moved(scope: Scope, here: int, there: int) -> str | None:
    scheme, host = scheme_of(scope), Headers(scope=scope).get("host", "").lower()
    name = host_name(host)
    if name == "" or host != _with_port(scheme, name, here):
        return None
    return f"{scheme}://{_with_port(scheme, name, there)}"


def _with_port(scheme: str, name: str, port: int) -> str:
    return name if port == _DEFAULT_PORTS[scheme] else f"{name}:{port}"
