"""``hbba bench``: the project's benchmarks, ours beside its peers."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path
from typing import Any

from app.base import paths
from app.base.errors import ConfigError
from app.commands.output import add_json


def add_parser(subparsers: Any) -> None:
    parser = subparsers.add_parser(
        "bench",
        help="measure this program beside its peers",
        description="Run the benchmarks and print a table of ours beside the peers'. They come with the source: a "
        "checkout, with the peers installed (pip install -e '.[test,bench]', or make bench).",
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="which (default: all; a wrong name lists them)")
    parser.add_argument("--quick", action="store_true", help="rough figures, in seconds instead of minutes")
    add_json(parser, "print all rows as one JSON document instead")
    parser.add_argument("--out", metavar="FILE", help="write that JSON document here")
    parser.add_argument("--markdown", metavar="FILE", help="also write them as a page (docs/benchmarks.md)")


def run(args: argparse.Namespace) -> int:
    """Run them; the exit code counts those that failed. Raises ConfigError where there are none."""
    checkout = paths.checkout_dir()
    if checkout is None or not (checkout / "benchmarks").is_dir():
        raise ConfigError("the benchmarks come with the source: run this in a checkout of the project")
    options = [f"--{option}" for option in ("quick", "json") if getattr(args, option)]
    for option in ("out", "markdown"):
        if getattr(args, option):
            options += [f"--{option}", str(Path(getattr(args, option)).absolute())]
    # Without app.base.child_processes: the benchmarks are in the current folder, and are not installed.
    command = [sys.executable, "-m", "benchmarks", *args.names, *options]
    return subprocess.run(command, cwd=checkout, check=False).returncode
