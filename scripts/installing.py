"""pip, with its progress on one line and its failures in one sentence. Standard library only."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

#: Without a terminal: a line after this time (s), and at most one in it.
LINE_EVERY_S = 10.0
#: Compiling all of twelve thousand files to bytecode takes pip as long as all else it does, on one core; Python does it
#: for each that is imported, a quarter of them.
OPTIONS = ("--disable-pip-version-check", "--progress-bar=off", "--no-compile")
_PROXY = re.compile(r"ProxyError\(.*?(Tunnel connection failed: [^'\")]+|Connection refused|Name or service not known)")


#: What the locks were made for: CPython from the first to the last of these, on Linux on these machines.
COVERED = ((3, 11), (3, 14))
COVERED_MACHINES = ("x86_64", "aarch64")
_NOT_AS_LOCKED = re.compile(r"DO NOT MATCH THE HASHES|No matching distribution found for (\S+)")


class PipFailed(Exception):
    """pip did not do it; the message says why, and what to do."""


class NotAsLocked(PipFailed):
    """The package index serves other versions or builds than those that the locks name."""


def lock_file(root: Path, need: str) -> Path:
    """The lock of what ``need`` (``build``, ``run`` or an extra) takes."""
    return root / "requirements" / f"{need}.lock"


def not_covered() -> str | None:
    """Why the locks are not for this computer and Python, in words; None where they are."""
    version = sys.version_info[:2]
    if not COVERED[0] <= version <= COVERED[1] or platform.python_implementation() != "CPython":
        return f"{platform.python_implementation()} {version[0]}.{version[1]}"
    if sys.platform != "linux" or platform.machine() not in COVERED_MACHINES:
        return f"{platform.system()} on {platform.machine()}"
    return None


def install_locked(python: Path, root: Path, needs: Iterable[str], *, title: str) -> None:
    """Install into the environment of ``python`` what the locks of ``needs`` name, nothing else.

    Raises NotAsLocked where the index has other files than those, and PipFailed.
    """
    files = [argument for need in needs for argument in ("-r", str(lock_file(root, need)))]
    install(python, "--no-deps", "--require-hashes", *files, title=title)


class Progress:
    """Progress of pip, read from its output."""

    def __init__(self) -> None:
        self._collected: set[str] = set()

    def read(self, line: str) -> str | None:
        """The progress after this ``line``, in words; None if the line contains none."""
        if found := re.match(r"\s*Collecting ([\w.-]+)", line):
            self._collected.add(found[1])
            return f"{len(self._collected)} packages so far, now {found[1]}"
        if line.startswith("Installing collected packages:"):
            return f"putting {line.count(',') + 1} packages into place"
        if "Retrying (" in line:
            return "the package index does not answer, trying again"
        return None


def install(
    python: Path,
    *arguments: str,
    title: str,
    environment: Mapping[str, str] | None = None,
    out: TextIO | None = None,
) -> None:
    """``pip install ARGUMENTS`` for ``python``, saying how far it is on ``out`` (standard output). Raises PipFailed.

    ``environment`` is added to this process's own.
    """
    said: list[str] = []
    command = [str(python), "-m", "pip", "install", *OPTIONS, *arguments]
    with (
        _shown(title, sys.stdout if out is None else out) as show,
        subprocess.Popen(
            command,
            env={**os.environ, "PIP_ROOT_USER_ACTION": "ignore", **(environment or {})},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        ) as process,
    ):
        assert process.stdout is not None
        progress = Progress()
        for line in process.stdout:
            said.append(line)
            if (now := progress.read(line)) is not None:
                show(now)
    if process.returncode:
        raise failure("".join(said))


def failure(said: str) -> PipFailed:
    """The failure of pip, which wrote ``said``, with what is to be done about it."""
    if found := _PROXY.search(said):
        return PipFailed(
            f"The proxy does not let pip through to the Python package index ({found[1].strip()}): correct the "
            "environment variable HTTPS_PROXY, or name an index that it allows in PIP_INDEX_URL."
        )
    if "NewConnectionError" in said or "Name or service not known" in said:
        return PipFailed(
            "The Python package index cannot be reached: connect this computer to the network, "
            "or name a mirror in the environment variable PIP_INDEX_URL."
        )
    kind = NotAsLocked if _NOT_AS_LOCKED.search(said) else PipFailed
    return kind(f"pip could not install the project:\n{said.strip()[-3000:]}")


@contextmanager
def _shown(title: str, out: TextIO) -> Iterator[Callable[[str], None]]:
    """A function that shows how far it is: on a terminal in one line, which counts the seconds; else now and then."""
    began = time.monotonic()
    now = ""
    over = threading.Event()
    terminal = out.isatty()

    def show(text: str) -> None:
        nonlocal now
        now = text

    def write() -> None:
        while not over.wait(0.5 if terminal else LINE_EVERY_S):
            line = f"hbba: {title}: {now or 'beginning'} ({time.monotonic() - began:.0f} s)"
            out.write(f"\r\x1b[K{line}" if terminal else f"{line}\n")
            out.flush()

    writer = threading.Thread(target=write, daemon=True)
    writer.start()
    try:
        yield show
    finally:
        over.set()
        writer.join()
        if terminal:
            out.write("\r\x1b[K")
            out.flush()
