"""Output files of ``hbba detect``: a folder chosen by the user, and free names in it."""

from __future__ import annotations

from pathlib import Path

from app.base.errors import ConfigError


def make_folder(folder: Path, option: str) -> None:
    """Make ``folder`` if it is not there. Raises ConfigError, naming ``option``, where that cannot be."""
    if folder.exists() and not folder.is_dir():
        raise ConfigError(f"{option}: {folder} is a file; give a folder to write into, there or to be made")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as failure:
        raise ConfigError(f"{option}: the folder {folder} cannot be made: {failure.strerror or failure}") from None


def unused(stem: str, names: set[str]) -> str:
    """``stem``, with a number where two files have one name; ``names`` are those taken, and then this one too."""
    name, number = stem, 1
    while name in names:
        number += 1
        name = f"{stem}-{number}"
    names.add(name)
    return name
