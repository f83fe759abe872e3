"""Arguments of several commands: the name of a log, times in it, names, numbers."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from app.base.errors import ConfigError

#: A time on the command line, once the begin of the log (robot's clock, s) is known.
Moment = Callable[[float], float]

TIMES = "seconds from the log's begin, M:SS, H:MM:SS, or a date and time as 2026-03-14T15:09:26"


def find_log(text: str) -> Path:
    """The file people mean: a path, or the bare name of a recording. Raises ConfigError."""
    from app.logs.library import RecordingLibrary, default_folder

    if not text:
        raise ConfigError(
            "a log is named by its file or, for a recording of yours, by its bare name; this name is empty"
        )
    path = Path(text)
    try:
        if path.exists():
            return path
    except OSError as failure:
        raise ConfigError(f"there is no file {text}: {failure.strerror}") from None
    library = RecordingLibrary(default_folder())
    try:
        recording = library.path(text.removesuffix(".mcap"))
    except ValueError:
        raise ConfigError(f"there is no file {text}") from None
    if not recording.is_file():
        raise ConfigError(f"there is no file {text}, and no recording of that name in {library.folder}")
    return recording


def recording_name(text: str) -> str:
    """The name of a new recording (empty: by date and time), for argparse."""
    from app.logs.library import name_or_nothing

    try:
        return name_or_nothing(text)
    except ValueError as rule:
        raise argparse.ArgumentTypeError(f"{rule}, not {text!r}") from None


def file_named(text: str) -> Path:
    """A file or folder, for argparse: no name at all would be the current folder."""
    if not text:
        raise argparse.ArgumentTypeError("the name of a file is empty")
    return Path(text)


def number(text: str) -> float | None:
    """``text`` as a finite number, or None where it is none."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def moment(text: str) -> Moment:
    """A time as people write it: 90, 90.5, 1:30, 1:02:03.5, or ISO 8601 (local where it names no zone)."""
    parts = [number(part) for part in text.split(":")]
    numbers = [part for part in parts if part is not None]
    if len(numbers) == len(parts) <= 3 and all(part >= 0 for part in numbers):
        seconds = 0.0
        for part in numbers:
            seconds = 60 * seconds + part
        return lambda begin: begin + seconds
    try:
        at = datetime.fromisoformat(text).timestamp()
    except (ValueError, OverflowError):
        raise argparse.ArgumentTypeError(f"a time is {TIMES}, not {text!r}") from None
    return lambda begin: at


def names(text: str) -> tuple[str, ...]:
    """``A,B,C``, for argparse."""
    found = tuple(name.strip() for name in text.split(","))
    if not all(found):
        raise argparse.ArgumentTypeError(f"names are written A,B,C, not {text!r}")
    return found


def whole(least: int, most: int | None = None) -> Callable[[str], int]:
    """A function for argparse that reads a whole number from ``least`` to ``most``."""

    def read(text: str) -> int:
        if text.isdecimal() and least <= (value := int(text)) and (most is None or value <= most):
            return value
        to = "" if most is None else f" to {most}"
        raise argparse.ArgumentTypeError(f"must be a whole number from {least}{to}, not {text!r}")

    return read
