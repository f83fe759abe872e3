"""The origins of page and 3D view, from where a request came in."""

from __future__ import annotations

from typing import Any

import pytest

from app.console.access.origins import Ports

PORTS = Ports(8080, 8081)


def asked(host: str, *, port: int = 8080, scheme: str = "http") -> dict[str, Any]:
    """The scope of a request to ``port`` of this computer."""
    headers = [(b"host", host.encode())]
    return {"type": "http", "scheme": scheme, "path": "/", "server": ("127.0.0.1", port), "headers": headers}


@pytest.mark.parametrize(
    ("host", "scheme", "origin"),
    [
        ("127.0.0.1:8080", "http", "http://127.0.0.1:8081"),
        ("LocalHost:8080", "http", "http://localhost:8081"),
        ("robot.local:8080", "https", "https://robot.local:8081"),
        ("robot.local", "http", None),
        ("robot.local:443", "https", None),
        ("localhost:9000", "http", None),
        ("localhost:08080", "http", None),
        ("localhost.:8080", "http", None),
        ("[::1]:8080", "http", None),
        ("evil; frame-src *:8080", "http", None),
        ("", "http", None),
    ],
)
def test_the_view_is_beside_a_page_that_reached_the_console_by_its_own_port(
    host: str, scheme: str, origin: str | None
) -> None:
    """Through a proxy or a tunnel the second port's address is not known; a policy cannot name IPv6 addresses."""
    assert PORTS.scene_origin(asked(host, scheme=scheme)) == origin


def test_the_page_that_may_frame_the_view_is_of_the_same_host_and_the_other_port() -> None:
    assert PORTS.page_origin(asked("robot:8081", port=8081)) == "http://robot:8080"
    assert PORTS.page_origin(asked("robot:8080", port=8081)) is None
    assert PORTS.page_origin(asked("robot:9081", port=8081)) is None


def test_a_default_port_is_not_written() -> None:
    ports = Ports(80, 8081)
    assert ports.scene_origin(asked("robot", port=80)) == "http://robot:8081"
    assert ports.page_origin(asked("robot:8081", port=8081)) == "http://robot"
    assert ports.scene_origin(asked("robot:80", port=80)) is None


def test_where_a_request_came_in_is_the_port_of_this_computer_not_what_it_says() -> None:
    assert PORTS.at_scene(asked("robot:8080", port=8081))
    assert not PORTS.at_scene(asked("robot:8081", port=8080))
    assert not PORTS.at_scene({"type": "http", "server": None})
