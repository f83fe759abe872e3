"""The address by which visitors' phones get in, and the QR code of it; made on this computer."""

from __future__ import annotations

import functools
import ipaddress
import socket
from collections.abc import Iterable, Sequence
from urllib.parse import urlsplit

import psutil
import segno

from app.console.access.auth import is_loopback, own_names
from app.console.access.origins import host_name
from app.console.live.messages import VisitorLink

PAGE = "visitor"
NO_LINK = VisitorLink("", (), "")
_ANYWHERE = frozenset({"0.0.0.0", "::", ""})
ALONE = (
    "The console answers to this computer alone: start it with --host 0.0.0.0, so that phones on its network reach it."
)


def visitor_link(key: str | None, *, base: str, listens: str, names: Sequence[str], asks: bool) -> VisitorLink:
    """The way in with ``key`` (None: there is none) for a client that reached the console at ``base``, as
    ``http://robot.local:8080``.

    One that is on this computer itself is given an address that others reach, too: the first of ``names``, what the
    console ``listens`` at, or the address of a network. ``asks``: whether it asks for a token beyond this computer.
    """
    if key is None:
        return NO_LINK
    parts = urlsplit(base)
    if not asks:
        return VisitorLink(f"{base}/{PAGE}", code_of(f"{base}/{PAGE}"), ALONE)
    host = host_name(parts.netloc)
    if is_loopback(host):
        host = next(iter(names), "") or (listens if listens not in _ANYWHERE else network_address(addresses()))
    if is_loopback(host):
        return VisitorLink(f"{base}/{PAGE}#key={key}", code_of(f"{base}/{PAGE}#key={key}"), ALONE)
    named = f"[{host}]" if ":" in host else host
    port = "" if parts.port is None else f":{parts.port}"
    url = f"{parts.scheme}://{named}{port}/{PAGE}#key={key}"
    return VisitorLink(url, code_of(url), "")


@functools.lru_cache(maxsize=8)
def code_of(text: str) -> tuple[str, ...]:
    """``text`` as the rows of a QR code without its quiet zone: ``1`` for each black module."""
    code = segno.make(text, error="m", micro=False, boost_error=False)
    return tuple("".join("1" if module else "0" for module in row) for row in code.matrix)


def addresses() -> list[str]:
    """The addresses of this computer's networks that are up."""
    up = {name for name, each in psutil.net_if_stats().items() if each.isup}
    inet = (socket.AF_INET, socket.AF_INET6)
    return [
        each.address
        for name, all_ in psutil.net_if_addrs().items()
        if name in up
        for each in all_
        if each.family in inet
    ]


def network_address(found: Iterable[str]) -> str:
    """Of ``found`` the address that phones most likely reach: a private one of IPv4, else any; the computer's name in
    mDNS where there is none."""
    likely: list[tuple[bool, bool, str]] = []
    for address in found:
        parsed = ipaddress.ip_address(address.partition("%")[0])
        if not (parsed.is_loopback or parsed.is_link_local or parsed.is_multicast or parsed.is_unspecified):
            likely.append((parsed.version != 4, not parsed.is_private, str(parsed)))
    names = own_names()
    return min(likely)[2] if likely else (names[-1] if names else "127.0.0.1")
