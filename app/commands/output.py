"""``--json``, which means the same in every command: one JSON document on standard output, and nothing else there."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError


def add_json(parser: argparse.ArgumentParser, text: str = "print one JSON document instead", **options: Any) -> None:
    """Declare ``--json``; ``options`` are those of ``add_argument``."""
    parser.add_argument("--json", action="store_true", help=text, **options)


def json_text(document: Any) -> str:
    """``document`` as JSON can show it: paths as text, numbers that are not finite (NaN, ∞) as null."""
    unicode = (sys.stdout.encoding or "").lower().startswith("utf")
    return json.dumps(_plain(document), indent=2, ensure_ascii=not unicode, allow_nan=False)


def print_json(document: Any) -> None:
    """Print ``document`` as JSON on standard output."""
    print(json_text(document))


def aligned(rows: Sequence[Sequence[str]], right: Collection[int]) -> list[str]:
    """Lines of aligned columns, those of ``right`` to the right; never wrapped, so that others can read them.

    A column without any text is left out.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell.rjust(width) if index in right else cell.ljust(width)
            for index, (cell, width) in enumerate(zip(row, widths, strict=True))
            if width
        ).rstrip()
        for row in rows
    ]


def check_writable(file: Path | None) -> None:
    """Raise ConfigError if the folder of ``file`` (``--out``) does not exist; called before the work, not after it."""
    if file is not None and not file.absolute().parent.is_dir():
        raise ConfigError("there is no such folder", str(file.parent))


def write_text(file: Path, text: str) -> None:
    """To what ``--out FILE`` names. Raises ConfigError."""
    try:
        file.write_text(text, encoding="utf-8")
    except OSError as failure:
        raise ConfigError(f"cannot be written: {failure.strerror or failure}", str(file)) from None


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, Path):
        return str(value)
    return None if isinstance(value, float) and not math.isfinite(value) else value
