"""What is left in the computer's shared memory."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path("/dev/shm")


def shared_memory() -> set[str]:
    """The named pieces of shared memory, but for those of browsers, which other tests may run at the same time."""
    return {file.name for file in FOLDER.glob("*") if "chromium" not in file.name}
