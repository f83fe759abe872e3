"""Encryption of the console's connections: a certificate and its key, and handshakes that keep no other client out."""

from __future__ import annotations

import asyncio
import logging
import socket
import ssl
from collections.abc import Callable
from pathlib import Path

from app.base.errors import ConfigError

HANDSHAKE_WITHIN_S = 10.0
#: Of more at once, the one that began first is ended.
MOST_HANDSHAKES = 64

log = logging.getLogger("hbba.console")


def tls_context(cert: Path, key: Path) -> ssl.SSLContext:
    """TLS 1.2 or newer with the certificate (chain) in ``cert`` and its private ``key``, in PEM. Raises ConfigError."""
    for option, file in (("--cert", cert), ("--key", key)):
        try:
            with file.open("rb"):
                pass
        except OSError as failure:
            raise ConfigError(f"{option} {file}: cannot be read: {failure.strerror or failure}") from None
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    context.set_alpn_protocols(["http/1.1"])
    try:
        # Without a password given here, OpenSSL would ask for one at the terminal.
        context.load_cert_chain(cert, key, password=lambda: "")
    except (ssl.SSLError, OSError) as failure:
        raise ConfigError(
            f"--cert {cert} and --key {key}: are no certificate and its key in PEM, or the key needs a password, which "
            f"cannot be given here: {getattr(failure, 'reason', None) or failure}"
        ) from None
    return context


class Handshakes:
    """TLS handshakes under way: beside accepting, each with its time, and bounded in number."""

    def __init__(self, context: ssl.SSLContext, protocol: Callable[[], asyncio.Protocol]) -> None:
        self._context = context
        self._protocol = protocol
        #: The oldest first.
        self._tasks: dict[asyncio.Task[None], None] = {}

    def begin(self, connection: socket.socket) -> None:
        """Shake hands with who connected; it is served from then on."""
        if len(self._tasks) >= MOST_HANDSHAKES:
            oldest = next(iter(self._tasks))
            del self._tasks[oldest]
            oldest.cancel()
        task = asyncio.create_task(self._shake(connection), name="TLS handshake")
        self._tasks[task] = None
        task.add_done_callback(lambda done: self._tasks.pop(done, None))

    async def _shake(self, connection: socket.socket) -> None:
        try:
            await asyncio.get_running_loop().connect_accepted_socket(
                self._protocol, connection, ssl=self._context, ssl_handshake_timeout=HANDSHAKE_WITHIN_S
            )
        except (OSError, asyncio.CancelledError) as failure:
            # A client that speaks no TLS, or does not believe the certificate: none of ours.
            connection.close()
            log.debug("no TLS with a client: %s", failure)

    async def end(self) -> None:
        """End those under way."""
        tasks = [*self._tasks]
        for task in tasks:
            task.cancel()
        if tasks:
            await asyncio.wait(tasks)
