"""``hbba log rerun``: shows a recording in Rerun, a viewer of others that reads the same files."""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sysconfig
from collections.abc import Callable
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError

_REMEDY = "Rerun is not installed: pip install 'hbba[rerun]' (170 MB)"


def add_rerun(actions: Any) -> None:
    """The parser of ``hbba log rerun``."""
    parser = actions.add_parser(
        "rerun",
        help="show a log in Rerun",
        description="Open a log in the viewer Rerun, or convert it into a file of Rerun's own. It draws pictures, "
        "depth, points, transforms, maps and the robot, and shows the fields of everything else.",
    )
    parser.add_argument("file", metavar="FILE", help="an MCAP file, or the name of one of your recordings")
    parser.add_argument("-o", "--out", type=Path, metavar="OUT", help="write this .rrd file and show nothing")
    parser.add_argument("--force", action="store_true", help="replace what is there")


def show(args: argparse.Namespace, find: Callable[[str], Path]) -> int:
    """Do it; ``find`` finds the file that a name means. Raises ConfigError."""
    path = find(args.file)
    if path.suffix != ".mcap":
        raise ConfigError(f"Rerun reads MCAP files, and {path.name} is none")
    program = rerun_program()
    if args.out is None:
        return subprocess.run([program, path], check=False).returncode
    if args.out.suffix != ".rrd":
        raise ConfigError(f"Rerun's files are called .rrd, not {args.out.name}")
    if args.out.exists() and not args.force:
        raise ConfigError(f"{args.out} exists; --force replaces it")
    code = subprocess.run([program, "mcap", "convert", path, "-o", args.out], check=False).returncode
    if code == 0:
        print(f"{args.out}: {args.out.stat().st_size / 1e6:.1f} MB; rerun {args.out} shows it")
    return code


def rerun_program() -> Path:
    """The viewer: of this program's environment, or else of the shell. Raises ConfigError where there is none."""
    beside = Path(sysconfig.get_path("scripts"), "rerun")
    found = str(beside) if beside.exists() else shutil.which("rerun")
    if found is None:
        raise ConfigError(_REMEDY)
    return Path(found)
