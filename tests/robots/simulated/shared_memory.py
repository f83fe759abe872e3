"""Pieces of the computer's shared memory that have names, and stay until somebody removes them."""

from __future__ import annotations

from pathlib import Path

import psutil

FOLDER = Path("/dev/shm")


def shared_memory(process: psutil.Process) -> set[Path]:
    """Those that ``process`` has mapped or open."""
    mapped = {Path(each.path) for each in process.memory_maps()}
    opened = {Path(each.path) for each in process.open_files()}
    return {file for file in mapped | opened if FOLDER in file.parents and file.exists()}
