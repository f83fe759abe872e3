"""``make lock``: every package that set-up installs, with version and hashes, into ``requirements/NEED.lock``.

uv resolves pyproject.toml once for all Pythons and platforms. A need's file has what it takes beside ``run.lock``, in
the same versions; no file names a package index. Every platform that set-up installs by the locks
(:data:`installing.COVERED`) must have wheels of all of it. Standard library only.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import installing

UV_REQUIREMENT = "uv>=0.8,<1"
HEADER = "# Made by `make lock` from pyproject.toml; not to be edited.\n"
#: The extras of pyproject.toml that the Makefile's tasks need.
EXTRAS = ("test", "bench", "docs", "speech", "video", "remote", "ros2")
#: Packages of these have no wheel, and are pure Python.
_SOURCE_ONLY = ("empy", "forbiddenfruit")
_OLDEST_GLIBC = "manylinux_2_34"


class LockFailed(Exception):
    """The locks cannot be made; the message says why."""


def write_locks(uv: Path, root: Path, *, upgrade: bool = True) -> None:
    """Resolve and write ``requirements/*.lock`` under ``root``; without ``upgrade`` versions stay where they fit.

    Raises LockFailed, having written nothing.
    """
    folder = root / "requirements"
    kept = [] if upgrade else [installing.lock_file(root, need) for need in ("build", "run", *EXTRAS)]
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory() as scratch:
        everything = Path(scratch) / "all.lock"
        everything.write_text("".join(file.read_text(encoding="utf-8") for file in kept), encoding="utf-8")
        build = Path(scratch) / "build.in"
        # An editable installation is built by hatchling with editables.
        build.write_text("\n".join([*project["build-system"]["requires"], "editables"]), encoding="utf-8")
        sources = [str(root / "pyproject.toml"), str(build)]
        extras = [f"--extra={extra}" for extra in EXTRAS]
        _compile(uv, [*sources, *extras], everything)
        wanted = {"build": [str(build)], "run": sources[:1]}
        wanted |= {extra: [sources[0], f"--extra={extra}"] for extra in EXTRAS}
        locks = {}
        for need, arguments in wanted.items():
            output = Path(scratch) / f"{need}.lock"
            _compile(uv, [*arguments, f"--constraint={everything}"], output)
            locks[need] = blocks(output.read_text(encoding="utf-8"))
        _check_wheels(uv, everything)
    folder.mkdir(exist_ok=True)
    for need, lock in locks.items():
        known = locks["run"] if need in EXTRAS else {}
        lines = [text for name, text in lock.items() if name not in known]
        installing.lock_file(root, need).write_text(HEADER + "".join(lines), encoding="utf-8")


def blocks(lock: str) -> dict[str, str]:
    """What a lock says of each package, by name: all its lines, hashes included."""
    found: dict[str, str] = {}
    name = ""
    for line in lock.splitlines(keepends=True):
        if match := re.match(r"[A-Za-z0-9][\w.-]*(?===)", line):
            name = match[0]
        if name and not line.startswith("#"):
            found[name] = found.get(name, "") + line
    return found


def _compile(uv: Path, arguments: list[str], output: Path) -> None:
    options = ["--universal", "--python-version=3.11", "--generate-hashes", "--no-header", "--no-annotate", "--quiet"]
    _run([str(uv), "pip", "compile", *options, *arguments, f"--output-file={output}"])


def _check_wheels(uv: Path, lock: Path) -> None:
    """Raise LockFailed where a covered platform has no wheel of a locked package."""
    kept = blocks(lock.read_text(encoding="utf-8"))
    binary = lock.with_name("binary.lock")
    binary.write_text("".join(text for name, text in kept.items() if name not in _SOURCE_ONLY), encoding="utf-8")
    options = ["--dry-run", "--quiet", "--no-deps", "--only-binary=:all:", "--require-hashes", "-r", str(binary)]
    for machine in installing.COVERED_MACHINES:
        for minor in range(installing.COVERED[0][1], installing.COVERED[1][1] + 1):
            platform = [f"--python-version=3.{minor}", f"--python-platform={machine}-{_OLDEST_GLIBC}"]
            _run([str(uv), "pip", "install", *options, *platform, f"--target={lock.parent / 'target'}"])


def _run(command: list[str]) -> None:
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode:
        raise LockFailed(f"uv cannot lock the packages ({' '.join(command[1:3])}): {done.stderr.strip()[-3000:]}")


def main(uv: Path, root: Path, arguments: list[str]) -> int:
    """``make lock``, with ``--keep`` in ``arguments`` for versions that stay where they fit."""
    try:
        write_locks(uv, root, upgrade="--keep" not in arguments)
    except LockFailed as failure:
        sys.stderr.write(f"{failure}\n")
        return 1
    return 0
