"""A folder of named entries (recordings, maps): valid names, the path of each, the default folder."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

LONGEST_NAME = 100
#: A valid name; none of these leaves the folder, and hidden files are no names.
NAME = re.compile(rf"[A-Za-z0-9][A-Za-z0-9._-]{{0,{LONGEST_NAME - 1}}}")


def name_rule(kind: str) -> str:
    """The sentence that states the valid names of a ``kind`` ("recording")."""
    return (
        f"a {kind}'s name has 1 to {LONGEST_NAME} letters, digits, '.', '_' or '-' and begins with a letter or a digit"
    )


class NamedLibrary:
    """Entries in one folder: files or folders called name + :attr:`suffix`. Methods that read the disk say so."""

    #: The noun for an entry in error messages.
    kind: ClassVar[str] = "thing"
    #: Ending of the file or folder of each entry.
    suffix: ClassVar[str] = ""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def path(self, name: str) -> Path:
        """Path of the entry ``name``, which need not exist. Raises ValueError for an invalid name."""
        if not NAME.fullmatch(name):
            raise ValueError(f"{name_rule(self.kind)}, not {name!r}")
        return self.folder / f"{name}{self.suffix}"

    def entries(self) -> Iterator[tuple[str, Path]]:
        """Name and path of everything in the folder with a valid name, in no order; reads the disk.

        Nothing where there is no folder yet. Raises OSError if it cannot be read.
        """
        try:
            with os.scandir(self.folder) as found:
                paths = [Path(entry.path) for entry in found if entry.name.endswith(self.suffix)]
        except FileNotFoundError:
            return
        for path in paths:
            name = path.name.removesuffix(self.suffix)
            if NAME.fullmatch(name):
                yield name, path


def data_folder(variable: str, name: str) -> Path:
    """The folder in the environment ``variable``, or ``hbba/name`` in the user's data folder (XDG Base Directory
    Specification)."""
    if chosen := os.environ.get(variable):
        return Path(chosen)
    data = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(data) / "hbba" / name
