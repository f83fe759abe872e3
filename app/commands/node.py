"""``hbba node``: run modules of a robot's program on this computer."""

from __future__ import annotations

import argparse
import asyncio
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.base import logging_setup
from app.base.errors import ConfigError
from app.commands.arguments import add_config

if TYPE_CHECKING:
    from app.remote.settings import TlsFiles


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "node",
        help="run modules of a robot's program on this computer",
        description="Join a robot and run those of its perceptions here that its configuration lets this computer run "
        "(`nodes`). Where both are the same computer, tcp/127.0.0.1:7447 does; else tls/HOST:PORT, with certificates.",
    )
    add_config(parser)
    parser.add_argument("--join", required=True, metavar="ENDPOINT", help="where the robot listens: tls/HOST:PORT")
    parser.add_argument(
        "--name", metavar="NAME", help="which of the program's computers this is (default: the only one)"
    )
    parser.add_argument(
        "--modules", metavar="A,B", help="what to run, which must be what the robot lets it (default: just that)"
    )
    for option, what in (("ca", "authority's certificate"), ("certificate", "own certificate"), ("key", "private key")):
        parser.add_argument(f"--{option}", type=Path, metavar="FILE", help=f"for tls/: the {what} (PEM)")
    parser.add_argument("--log-level", choices=logging_setup.LEVELS, default="info", help="least severe events to log")
    parser.add_argument("--log-json", action="store_true", help="log one JSON object a line")


def run(args: argparse.Namespace) -> int:
    """Run until a signal comes; 1 where the robot refuses this computer. Raises ConfigError."""
    from app.base import paths
    from app.commands.packaged import program_named
    from app.commands.run import Stopping, until_stopped
    from app.program.config import load_configuration
    from app.program.nodes import described_modules, node_of
    from app.remote.node import Node, Refused
    from app.remote.session import configuration as session_settings

    configuration = load_configuration(program_named(args.config) or paths.config_dir() / "lab.yaml")
    name, settings = node_of(configuration, args.name)
    if args.modules is not None:
        settings = settings.model_copy(update={"modules": tuple(args.modules.split(","))})
    modules = described_modules(configuration, name, settings)
    try:
        session = session_settings(join=args.join, tls=_tls(args))
    except ValueError as failure:
        raise ConfigError(str(failure), "--join") from None
    logging_setup.configure(args.log_level, as_json=args.log_json)
    node = Node(name, modules, configuration.channels, quality=settings.quality if settings.images == "jpeg" else None)

    def joined() -> None:
        print(f"{name} has joined: it runs {', '.join(modules)}  (Ctrl-C stops it)", flush=True)

    try:
        return asyncio.run(until_stopped(node.run(session, joined), Stopping()))
    except Refused as failure:
        print(f"hbba node: the robot refuses {name}: {failure}", file=sys.stderr)
        return 1


def _tls(args: argparse.Namespace) -> TlsFiles | None:
    from app.remote.settings import TlsFiles

    given = {option: getattr(args, option) for option in ("ca", "certificate", "key")}
    absent = [option for option, path in given.items() if path is None]
    if len(absent) == len(given):
        return None
    if absent:
        raise ConfigError("is needed beside the others: --ca, --certificate and --key", f"--{absent[0]}")
    for option, path in given.items():
        if not path.is_file():
            raise ConfigError(f"there is no file {path}", f"--{option}")
    return TlsFiles(**{option: path.absolute() for option, path in given.items()})
