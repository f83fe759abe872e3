"""The address that phones are given."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import zxingcpp

from app.console.live.visitor_link import ALONE, NO_LINK, code_of, network_address, visitor_link

HERE: dict[str, Any] = {"base": "http://127.0.0.1:8080", "listens": "0.0.0.0", "names": (), "asks": True}


def test_a_client_from_elsewhere_came_by_an_address_that_phones_reach_too() -> None:
    link = visitor_link("k", **HERE | {"base": "http://robot.local:8080", "names": ("other.example",)})
    assert (link.url, link.problem) == ("http://robot.local:8080/visitor#key=k", "")
    assert visitor_link("k", **HERE | {"base": "https://tours.example"}).url == "https://tours.example/visitor#key=k"
    assert visitor_link("k", **HERE | {"base": "http://[fd00::1]:80"}).url == "http://[fd00::1]:80/visitor#key=k"


def test_one_on_this_computer_is_given_another() -> None:
    assert visitor_link("k", **HERE | {"names": ("robot.example",)}).url == "http://robot.example:8080/visitor#key=k"
    assert visitor_link("k", **HERE | {"listens": "10.0.0.5"}).url == "http://10.0.0.5:8080/visitor#key=k"
    assert "127.0.0.1" not in visitor_link("k", **HERE).url


def test_a_console_for_this_computer_alone_says_so() -> None:
    link = visitor_link("k", **HERE | {"asks": False, "listens": "127.0.0.1"})
    assert (link.url, link.problem) == ("http://127.0.0.1:8080/visitor", ALONE)
    link = visitor_link("k", **HERE | {"listens": "127.0.0.1"})
    assert link.problem == ALONE
    assert visitor_link(None, **HERE) == NO_LINK


@pytest.mark.parametrize(
    ("found", "chosen"),
    [
        (["127.0.0.1", "::1", "192.168.1.7", "fe80::1%eth0"], "192.168.1.7"),
        (["8.8.8.8", "10.0.0.5"], "10.0.0.5"),
        (["fd00::5", "169.254.3.4"], "fd00::5"),
    ],
)
def test_the_address_of_a_network(found: list[str], chosen: str) -> None:
    assert network_address(found) == chosen


def test_without_a_network_the_computer_s_name_is_left() -> None:
    assert "127" in (name := network_address(["127.0.0.1"])) or name.endswith(".local")


def test_its_code_is_read_as_the_address() -> None:
    url = "http://robot.local:8080/visitor#key=" + "k" * 22
    modules = np.array([[255 * (module == "0") for module in row] for row in code_of(url)], np.uint8)
    picture = np.pad(np.kron(modules, np.ones((4, 4), np.uint8)), 16, constant_values=255)
    assert [code.text for code in zxingcpp.read_barcodes(picture)] == [url]
