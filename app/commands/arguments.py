"""Arguments of several commands: the name of a log, times in it, names, numbers."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from datetime import datetime
from pathlib import Path

from app.base.errors import ConfigError
from app.commands.output import add_json

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


def real(
    least: float = -math.inf, most: float = math.inf, *, above: bool = False, rule: str = ""
) -> Callable[[str], float]:
    """A function for argparse that reads a finite number from ``least`` (``above``: greater than that) to ``most``.

    ``rule`` says in its error what is allowed, where "must be a number from … to …" does not.
    """
    rule = rule or f"must be a number {'above' if above else 'from'} {least:g} to {most:g}"

    def read(text: str) -> float:
        value = number(text)
        if value is None or not least <= value <= most or (above and value == least):
            raise argparse.ArgumentTypeError(f"{rule}, not {text!r}")
        return value

    return read


def add_config(parser: argparse.ArgumentParser) -> None:
    """Declare ``--config``, the program."""
    parser.add_argument(
        "--config", type=Path, metavar="FILE", help="the program: a file, or a name as jackal (default: lab)"
    )


def add_results_options(parser: argparse.ArgumentParser, jobs: str) -> None:
    """Declare the options of an experiment of many trials; ``jobs`` is the noun for these."""
    parser.add_argument("--jobs", type=whole(1, 256), metavar="N", help=f"{jobs} at a time (default: one a core)")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="where results are kept (default: your data folder)")
    parser.add_argument("--fresh", action="store_true", help="start again; earlier results are moved aside")
    add_json(parser)


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


def numbers(least: float, most: float) -> Callable[[str], tuple[float, ...]]:
    """A function for argparse that reads ``X,Y,Z``, each from ``least`` to ``most``."""
    one = real(least, most)
    return lambda text: tuple(one(part) for part in text.split(","))


def whole(least: int, most: int | None = None) -> Callable[[str], int]:
    """A function for argparse that reads a whole number from ``least`` to ``most``."""

    def read(text: str) -> int:
        if text.isdecimal() and least <= (value := int(text)) and (most is None or value <= most):
            return value
        to = "" if most is None else f" to {most}"
        raise argparse.ArgumentTypeError(f"must be a whole number from {least}{to}, not {text!r}")

    return read
