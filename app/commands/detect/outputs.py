"""What all of ``hbba detect`` do with files: find them, go through them, name what is written."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from app.base.errors import ConfigError
from app.commands.progress import Progress, part, shown

#: What was found in one file, as JSON shows it; with "error" for one that cannot be read, or not to its end.
Document = dict[str, Any]


def find_files(paths: Iterable[Path], suffixes: frozenset[str], what: str, without: tuple[str, ...] = ()) -> list[Path]:
    """The files among ``paths``, and all with ``suffixes`` in the folders and below, in the order of their names.

    Names that end with one of ``without`` are read only where they are named themselves. Raises ConfigError where there
    is no such file or folder, or nothing (``what``) in a folder.
    """
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            named = (p for p in path.rglob("*") if p.suffix.lower() in suffixes and not p.name.endswith(without))
            inside = sorted(p for p in named if p.is_file())
            if not inside:
                endings = ", ".join(sorted(suffixes))
                raise ConfigError(f"{path}: there is no {what} in this folder or below (looked for {endings})")
            found += inside
        elif path.exists():
            found.append(path)
        else:
            raise ConfigError(f"there is no file or folder {path}")
    return list(dict.fromkeys(found))


def each_file(
    paths: list[Path], title: str, command: str, look: Callable[[Path, Progress], Document]
) -> list[Document]:
    """What ``look`` finds in each file; the errors of files are printed on standard error, too."""
    documents = []
    with shown(title) as progress:
        for done, path in enumerate(paths):
            progress(done, len(paths), path.name)
            document = look(path, part(progress, done, len(paths), path.name))
            if "error" in document:
                print(f"{command}: {path}: {document['error']}", file=sys.stderr)
            documents.append(document)
        progress(len(paths), len(paths))
    return documents


def exit_code(documents: list[Document], key: str) -> int:
    """2 if a file could not be read, else 0 if anything was found in any (its list ``key``), else 1."""
    if any("error" in document for document in documents):
        return 2
    return 0 if any(document[key] for document in documents) else 1


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
