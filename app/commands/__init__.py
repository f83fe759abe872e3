"""The commands of ``hbba``, one file each: ``add_parser(subparsers)`` declares it, ``run(args)`` does it."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any, Protocol

from app.commands import (
    bench,
    calibrate,
    check,
    completion,
    detect,
    doctor,
    experiment,
    log,
    new,
    replay,
    run,
    slam,
    solve,
)

#: The object that ``argparse`` returns for adding commands; its own type is private and generic.
Subparsers = Any


class CliCommand(Protocol):
    """The functions of each command's file."""

    def add_parser(self, subparsers: Subparsers) -> None:
        """Declare the command's name, help and arguments."""
        ...

    def run(self, args: argparse.Namespace) -> int:
        """Do it and return the exit code. May raise ConfigError for a person's mistake."""
        ...


COMMANDS: Mapping[str, CliCommand] = {
    "run": run,
    "replay": replay,
    "log": log,
    "doctor": doctor,
    "check": check,
    "solve": solve,
    "calibrate": calibrate,
    "detect": detect,
    "experiment": experiment,
    "slam": slam,
    "new": new,
    "bench": bench,
    "completion": completion,
}
