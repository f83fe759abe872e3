"""The page as its build packed it: to clients that take it so, each form with an entity tag of its own."""

from __future__ import annotations

import gzip
from pathlib import Path

import httpx
import pytest
from fastapi import FastAPI

from app.console.page import accepts, install_page

SCRIPT = b"console.log('drive');\n" * 200
HTML = b"<!doctype html><title>HBBA</title>" + b" " * 2000


@pytest.fixture
def client(tmp_path: Path) -> httpx.AsyncClient:
    """A page with a packed script, a packed start and an icon that is not packed."""
    (tmp_path / "assets").mkdir()
    for name, content in (("assets/index-1.js", SCRIPT), ("index.html", HTML)):
        (tmp_path / name).write_bytes(content)
        (tmp_path / f"{name}.br").write_bytes(b"brotli of " + name.encode())
        (tmp_path / f"{name}.gz").write_bytes(gzip.compress(content))
    (tmp_path / "favicon.svg").write_text("<svg/>")
    app = FastAPI(openapi_url=None)
    install_page(app, tmp_path)
    return httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://127.0.0.1")


async def raw(client: httpx.AsyncClient, path: str, **headers: str) -> tuple[httpx.Response, bytes]:
    """The answer, and its body as it was sent."""
    async with client.stream("GET", path, headers={"accept-encoding": "identity", **headers}) as answer:
        return answer, b"".join([part async for part in answer.aiter_raw()])


async def test_a_browser_gets_brotli(client: httpx.AsyncClient) -> None:
    answer, body = await raw(client, "/assets/index-1.js", **{"accept-encoding": "gzip, deflate, br, zstd"})
    assert body == b"brotli of assets/index-1.js"
    assert answer.headers["content-encoding"] == "br"
    assert answer.headers["content-type"] == "text/javascript; charset=utf-8"
    assert answer.headers["vary"] == "Accept-Encoding"
    assert answer.headers["content-length"] == str(len(body))


async def test_one_on_plain_http_gets_gzip(client: httpx.AsyncClient) -> None:
    answer, body = await raw(client, "/", **{"accept-encoding": "gzip, deflate"})
    assert gzip.decompress(body) == HTML
    assert answer.headers["content-encoding"] == "gzip"
    assert answer.headers["content-type"] == "text/html; charset=utf-8"


async def test_who_takes_neither_gets_the_file(client: httpx.AsyncClient) -> None:
    answer, body = await raw(client, "/assets/index-1.js")
    assert body == SCRIPT
    assert "content-encoding" not in answer.headers
    assert answer.headers["vary"] == "Accept-Encoding"


async def test_what_was_not_packed_is_served_as_it_is(client: httpx.AsyncClient) -> None:
    answer, body = await raw(client, "/favicon.svg", **{"accept-encoding": "br"})
    assert body == b"<svg/>"
    assert "content-encoding" not in answer.headers


async def test_each_form_has_an_entity_tag_of_its_own(client: httpx.AsyncClient) -> None:
    tags = {}
    for coding in ("br", "gzip", "identity"):
        answer, _ = await raw(client, "/assets/index-1.js", **{"accept-encoding": coding})
        tags[coding] = answer.headers["etag"]
    assert len(set(tags.values())) == 3
    same, body = await raw(client, "/assets/index-1.js", **{"accept-encoding": "br", "if-none-match": tags["br"]})
    assert (same.status_code, body) == (304, b"")
    assert same.headers["vary"] == "Accept-Encoding"
    other, _ = await raw(client, "/assets/index-1.js", **{"accept-encoding": "br", "if-none-match": tags["gzip"]})
    assert other.status_code == 200


@pytest.mark.parametrize(
    ("header", "taken"),
    [("br", True), ("gzip, br;q=0.5", True), ("br;q=0", False), ("br; q=0.000", False), ("", False), ("brotli", False)],
)
def test_what_a_client_takes(header: str, taken: bool) -> None:
    assert accepts(header, "br") is taken
