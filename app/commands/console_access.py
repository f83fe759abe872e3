"""Who may use a console that a command serves, and whether its connections are encrypted: from the options."""

from __future__ import annotations

import argparse
import logging
import ssl
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.base.errors import ConfigError
from app.commands.arguments import file_named

if TYPE_CHECKING:
    from app.console.access.credentials import Passwords

log = logging.getLogger("hbba.console")


def add_access_options(parser: argparse.ArgumentParser) -> None:
    """``--token-file``, ``--access``, ``--cert`` and ``--key``."""
    parser.add_argument(
        "--token-file",
        type=file_named,
        metavar="FILE",
        help="file with the token that a browser must present (else: the variable HBBA_TOKEN; made up beyond loopback)",
    )
    parser.add_argument(
        "--access",
        type=file_named,
        metavar="FILE",
        help="file with hashes of the passwords of spectators, operators and supervisors (`hbba password` makes them)",
    )
    parser.add_argument("--cert", type=file_named, metavar="FILE", help="certificate for HTTPS (PEM), with its chain")
    parser.add_argument("--key", type=file_named, metavar="FILE", help="the certificate's private key (PEM)")


@dataclass(frozen=True, slots=True)
class ConsoleAccess:
    """``token`` and ``passwords``, neither of them: anyone on this computer; ``tls`` None: plain connections.

    ``replay_options`` make a replay that is started from the console ask for the same.
    """

    token: str | None
    passwords: Passwords
    tls: ssl.SSLContext | None
    replay_options: tuple[str, ...]

    @property
    def scheme(self) -> str:
        """``http`` or ``https``."""
        return "http" if self.tls is None else "https"


def console_access(args: argparse.Namespace, host: str) -> ConsoleAccess:
    """The access to a console on ``host``. Raises ConfigError."""
    from app.console.access.auth import is_loopback
    from app.console.access.credentials import read_access
    from app.console.access.token import given_token, new_token
    from app.console.tls import tls_context

    if (args.cert is None) != (args.key is None):
        raise ConfigError("--cert and --key are a certificate and its private key: give both, or neither")
    passwords = () if args.access is None else read_access(args.access)
    token = given_token(args.token_file) or (None if is_loopback(host) or passwords else new_token())
    tls = None if args.cert is None else tls_context(args.cert, args.key)
    files = {"--access": args.access, "--cert": args.cert, "--key": args.key}
    options = tuple(
        part for option, file in files.items() if file is not None for part in (option, str(file.absolute()))
    )
    return ConsoleAccess(token, passwords, tls, options)


def warn_of_plain_connections(access: ConsoleAccess, host: str) -> None:
    """Log that all on the network can read what others send, where that is so."""
    from app.console.access.auth import is_loopback

    if access.tls is None and not is_loopback(host):
        log.warning(
            "the console's connections are not encrypted: others on the network can read pictures, sound and logins; "
            "give --cert and --key, or put a TLS proxy on this computer in front"
        )
