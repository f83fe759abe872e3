"""Other programs, run with our output as their own, and lines of progress between. Standard library only."""

from __future__ import annotations

import subprocess
import sys


def run(command: list[object]) -> int:
    """Run ``command`` with our output as its own."""
    return subprocess.run([str(word) for word in command], stdin=subprocess.DEVNULL, check=False).returncode


def say(text: str) -> None:
    """Print one line of progress."""
    over = "\r\x1b[K" if sys.stdout.isatty() else ""  # pip's progress, which goes on below
    sys.stdout.write(f"{over}hbba: {text}\n")
    sys.stdout.flush()
