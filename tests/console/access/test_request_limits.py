"""What a request may weigh, over a real socket."""

from __future__ import annotations

import json

import httpx
import pytest
import websockets

from app.console.access.request_limits import DRAINED_BYTES, LARGEST_BODY_BYTES
from tests.console.raw import connected, request
from tests.patience import PATIENCE_S

DESIRE = json.dumps({"class": "Telepresence", "intensity": 1, "utility": 1}).encode()
JSON = "Content-Type: application/json"
CHUNKED = "Transfer-Encoding: chunked"


def chunks(*parts: bytes) -> bytes:
    return b"".join(b"%x\r\n%s\r\n" % (len(part), part) for part in (*parts, b""))


@pytest.mark.parametrize("path", ["/api/v1/desires", "/api/v1/session", "/", "/viser/", "/nothing"])
async def test_a_body_of_two_sizes_is_refused_before_it_is_read(url: str, path: str) -> None:
    """RFC 9112, section 6.3: a request that a proxy and we may understand in two ways."""
    async with connected(url) as raw:
        await raw.send(request(f"POST {path}", JSON, "Content-Length: 5", CHUNKED))
        status, said = await raw.answer()  # which ends, though no body came
        assert status == 400
        assert b"urn:hbba:problem:ambiguous-body" in said
        assert b"x-content-type-options: nosniff" in said


async def test_a_body_in_chunks_is_read(url: str) -> None:
    async with connected(url) as raw:
        await raw.send(request("POST /api/v1/desires", JSON, CHUNKED, "Connection: close"))
        await raw.send(chunks(DESIRE[:10], DESIRE[10:]))
        assert (await raw.answer())[0] == 201


@pytest.mark.parametrize("path", ["/api/v1/desires", "/api/v1/session", "/"])
async def test_an_endless_body_in_chunks_is_cut_at_the_limit(url: str, path: str) -> None:
    async with connected(url) as raw:
        await raw.send(request(f"POST {path}", JSON, CHUNKED))
        chunk = b"10000\r\n" + b" " * 0x10000 + b"\r\n"
        for _ in range(DRAINED_BYTES // 0x10000 + 2):
            await raw.send(chunk)  # there is no end
        status, said = await raw.answer()
        assert status == 413
        assert b"urn:hbba:problem:body-too-large" in said


async def test_a_body_that_is_a_little_too_large_is_refused_and_the_connection_stays(url: str) -> None:
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as client:
        for size in (LARGEST_BODY_BYTES + 1, DRAINED_BYTES):
            refused = await client.post("/desires", content=b" " * size)
            assert refused.status_code == 413
            assert "connection" not in refused.headers
        allowed = await client.post("/desires", content=b" " * (LARGEST_BODY_BYTES - len(DESIRE)) + DESIRE)
        assert allowed.status_code == 422  # no header says that it is JSON
        allowed = await client.post(
            "/desires",
            content=DESIRE + b" " * (LARGEST_BODY_BYTES - len(DESIRE)),
            headers={"Content-Type": "application/json"},
        )
        assert allowed.status_code == 201


async def test_a_body_that_says_it_is_huge_is_not_waited_for(url: str) -> None:
    async with connected(url) as raw:
        await raw.send(request("POST /api/v1/desires", JSON, "Content-Length: 400000000"))
        assert (await raw.answer())[0] == 413


@pytest.mark.parametrize(
    ("fields", "status"),
    [
        ([f"X-{number}: a" for number in range(101)], 431),
        ([f"X-{number}: a" for number in range(10_000)], 431),
        (["X: " + "a" * 33_000], 431),
        (["X: " + "a" * 100_000], 431),
        (["X: " + "a" * 1_000_000], 431),
        ([f"X-{number}: a" for number in range(80)], 200),
    ],
)
async def test_a_header_has_its_limits(url: str, fields: list[str], status: int) -> None:
    async with connected(url) as raw:
        await raw.send(request("GET /api/v1/health", "Connection: close", *fields))
        answered, said = await raw.answer()
        assert answered == status
        assert status == 200 or b"urn:hbba:problem:header-too-large" in said


async def test_a_websocket_s_header_has_them_too(url: str) -> None:
    fields = {f"X-{number}": "a" for number in range(100)}
    with pytest.raises(websockets.InvalidStatus) as refused:
        await websockets.connect(
            url.replace("http", "ws") + "/api/v1/live", proxy=None, open_timeout=None, additional_headers=fields
        )
    assert refused.value.response.status_code == 431


async def test_an_address_has_its_limit(url: str) -> None:
    async with connected(url) as raw:
        await raw.send(request("GET /api/v1/health?" + "a" * 9000))
        assert (await raw.answer())[0] == 414


@pytest.mark.parametrize("line", ["\x00\x01", "GET / HTTP/1.1", "GET /\r\n\r\n"])
async def test_what_is_no_http_is_refused_in_words(url: str, line: str) -> None:
    async with connected(url) as raw:
        await raw.send(line.encode() + b"\r\n\r\n")
        status, said = await raw.answer()
        assert status == 400
        assert b"urn:hbba:problem:malformed-request" in said


async def test_a_client_that_leaves_within_its_body_leaves_nothing_behind(
    url: str, caplog: pytest.LogCaptureFixture
) -> None:
    async with connected(url) as raw:
        await raw.send(request("POST /api/v1/desires", JSON, "Content-Length: 50") + b"{")
    async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1") as client:
        assert (await client.get("/health")).status_code == 200
    assert not [
        record for record in caplog.records if record.name.startswith("uvicorn") and record.levelname == "ERROR"
    ]
