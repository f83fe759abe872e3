"""The folder of recordings: names, listing, deleting."""

from __future__ import annotations

import os
import re
from pathlib import Path

SUFFIX = ".mcap"
#: What a recording may be called: nothing that could leave the folder.
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")


class RecordingLibrary:
    """Recordings in one folder, each ``<name>.mcap``. All methods touch the disk: call them off the event loop."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def path(self, name: str) -> Path:
        """Where the recording ``name`` is or would be. Raises ValueError for a name that may not be."""
        if not NAME.fullmatch(name):
            raise ValueError(
                f"a recording's name has 1 to 100 letters, digits, '.', '_' or '-' and begins with a letter or a digit,"
                f" not {name!r}"
            )
        return self.folder / f"{name}{SUFFIX}"


def default_folder() -> Path:
    """``$HBBA_RECORDINGS``, or ``hbba/recordings`` in the user's data folder (XDG Base Directory Specification)."""
    if named := os.environ.get("HBBA_RECORDINGS"):
        return Path(named)
    data = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(data) / "hbba" / "recordings"
