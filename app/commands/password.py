"""``hbba password``: the line of an access file for a role's password."""

from __future__ import annotations

import argparse
import getpass
import sys
from typing import Any

from app.base.errors import ConfigError


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "password",
        help="make the line of an access file for a role's password",
        description="Ask for a password and print the line with its hash, for the file that `hbba run --access` reads. "
        "Without a terminal, the first line of the standard input is the password.",
    )
    parser.add_argument(
        "--role",
        choices=("spectator", "operator", "supervisor"),
        default="operator",
        help="whose password it is (default: operator)",
    )


def run(args: argparse.Namespace) -> int:
    """Print the line. Raises ConfigError for a password that cannot be."""
    from app.console.access.passwords import hash_of

    try:
        hashed = hash_of(_asked())
    except ValueError as refusal:
        raise ConfigError(f"{refusal}") from None
    print(f'{args.role}: "{hashed}"')
    return 0


def _asked() -> str:
    if not sys.stdin.isatty():
        return sys.stdin.readline().rstrip("\r\n")
    password = getpass.getpass("Password: ")
    if getpass.getpass("Again: ") != password:
        raise ConfigError("the two passwords are not the same")
    return password
