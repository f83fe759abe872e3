"""Encrypted connections: the cookie is then for them alone, and a handshake that stops keeps no one out."""

from __future__ import annotations

import asyncio
import shutil
import socket
import ssl
import subprocess
from pathlib import Path

import httpx
import pytest
import websockets

from app.base.errors import ConfigError
from app.console import tls
from app.console.app import create_app
from app.console.server import listen, serve
from app.console.tls import tls_context
from app.program.system import System
from tests.patience import PATIENCE_S

TOKEN = "correct horse battery"

needs_openssl = pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes the certificates")


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A certificate for 127.0.0.1, and its key."""
    folder = tmp_path_factory.mktemp("tls")
    cert, key = folder / "cert.pem", folder / "key.pem"
    options = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2"]
    names = ["-subj", "/CN=127.0.0.1", "-addext", "subjectAltName=IP:127.0.0.1"]
    files = ["-keyout", str(key), "-out", str(cert)]
    subprocess.run(["openssl", "req", "-x509", *options, *names, *files], check=True, capture_output=True)
    return cert, key


@needs_openssl
async def test_over_tls_all_goes_on_and_the_cookie_is_for_tls_alone(
    system: System, page: Path, pair: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tls, "MOST_HANDSHAKES", 2)
    cert, _ = pair
    trusting = await asyncio.to_thread(ssl.create_default_context, cafile=str(cert))
    app = create_app(system, static_dir=page, token=TOKEN, early_view=False)
    listener = listen("127.0.0.1", 0)
    port = listener.getsockname()[1]
    up: asyncio.Future[str] = asyncio.get_running_loop().create_future()
    context = await asyncio.to_thread(tls_context, *pair)
    serving = asyncio.create_task(serve(app, "127.0.0.1", port, listener=listener, tls=context, started=up.set_result))
    try:
        url = await up
        assert url == f"https://127.0.0.1:{port}"
        # Clients that say nothing: more than there may be handshakes.
        silent = [await asyncio.open_connection("127.0.0.1", port) for _ in range(4)]
        async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"{url}/api/v1", verify=trusting) as client:
            answer = await client.post("/session", json={"token": TOKEN}, headers={"Origin": url})
            assert answer.status_code == 200
            assert "secure" in answer.headers["set-cookie"].lower()
            cookie = answer.headers["set-cookie"].partition(";")[0]
            async with websockets.connect(
                f"wss://127.0.0.1:{port}/api/v1/live",
                ssl=trusting,
                proxy=None,
                origin=websockets.Origin(url),
                additional_headers={"Cookie": cookie},
            ) as live:
                assert '"hello"' in str(await live.recv())
        with pytest.raises(httpx.HTTPError):  # plain text, answered with nothing
            async with httpx.AsyncClient(timeout=PATIENCE_S, base_url=f"http://127.0.0.1:{port}") as client:
                await client.get("/api/v1/health")
        for _, writer in silent:
            writer.close()
    finally:
        serving.cancel()
        await asyncio.wait({serving})


@needs_openssl
def test_what_is_no_certificate_and_key_is_refused_in_one_sentence(tmp_path: Path, pair: tuple[Path, Path]) -> None:
    cert, key = pair
    with pytest.raises(ConfigError, match=r"--key .*cannot be read: No such file"):
        tls_context(cert, tmp_path / "missing.pem")
    with pytest.raises(ConfigError, match="are no certificate and its key"):
        tls_context(key, cert)
    locked = tmp_path / "locked.pem"
    subprocess.run(
        ["openssl", "pkcs8", "-topk8", "-in", key, "-out", locked, "-passout", "pass:secret"],
        check=True,
        capture_output=True,
    )
    with pytest.raises(ConfigError, match="or the key needs a password"):
        tls_context(cert, locked)


def test_a_listener_has_an_https_address_over_tls() -> None:
    from app.console.server import url_of

    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        assert url_of(listener, secure=True).startswith("https://127.0.0.1:")
