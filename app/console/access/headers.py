"""Security and cache headers of every answer."""

from __future__ import annotations

from starlette.datastructures import MutableHeaders
from starlette.types import Scope

from app.console.access.origins import Ports

_PAGE_POLICY = (
    "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; connect-src 'self'{scene}; "
    "frame-src 'self'{scene}; object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors 'self'"
)
# viser's client is one file that unpacks and runs itself, with workers and WebAssembly.
_VIEW_POLICY = (
    "default-src 'self' data: blob:; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; "
    "style-src 'self' 'unsafe-inline'; worker-src 'self' blob: data:; connect-src 'self' data: blob:; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors {page}"
)


def add_headers(headers: MutableHeaders, scope: Scope, ports: Ports | None) -> None:
    """Set the security and cache headers of the answer to ``scope``; what is set already stays."""
    path = scope["path"]
    headers.setdefault("x-content-type-options", "nosniff")
    headers.setdefault("referrer-policy", "same-origin")
    headers.setdefault("cross-origin-opener-policy", "same-origin")
    headers.setdefault("cross-origin-resource-policy", "same-origin")
    headers.setdefault("content-security-policy", _policy(scope, ports))
    if ports is not None and ports.at_scene(scope):
        # Same site as the page: without this, browsers give both one process.
        headers.setdefault("origin-agent-cluster", "?1")
    if path.startswith("/assets/"):
        # Vite names these by their content.
        headers.setdefault("cache-control", "public, max-age=31536000, immutable")
    else:
        headers.setdefault("cache-control", "no-store" if path.startswith("/api") else "no-cache")


def _policy(scope: Scope, ports: Ports | None) -> str:
    """The content security policy: page and frame name each other."""
    if ports is not None and ports.at_scene(scope):
        return _VIEW_POLICY.format(page=ports.page_origin(scope) or "'none'")
    if scope["path"].startswith("/viser"):
        return _VIEW_POLICY.format(page="'self'")
    scene = None if ports is None else ports.scene_origin(scope)
    return _PAGE_POLICY.format(scene="" if scene is None else f" {scene}")
