"""The folder of recordings: names, listing, deleting."""

from __future__ import annotations

import itertools
import os
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

SUFFIX = ".mcap"
#: What a recording may be called: nothing that could leave the folder.
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
LONGEST_NAME = 100
#: The same in words.
NAME_RULE = (
    f"a recording's name has 1 to {LONGEST_NAME} letters, digits, '.', '_' or '-' and begins with a letter or a digit"
)
#: Of a field that may be left empty, for who checks it elsewhere: a pattern of ECMA-262.
NAME_PATTERN = f"^({NAME.pattern})?$"


def name_or_nothing(name: str) -> str:
    """``name``, which may be empty where a name is made up then. Raises ValueError for one that may not be."""
    if name and not NAME.fullmatch(name):
        raise ValueError(NAME_RULE)
    return name


class RecordingLibrary:
    """Recordings in one folder, each ``<name>.mcap``. All methods touch the disk: call them off the event loop."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def path(self, name: str) -> Path:
        """Where the recording ``name`` is or would be. Raises ValueError for a name that may not be."""
        if not NAME.fullmatch(name):
            raise ValueError(f"{NAME_RULE}, not {name!r}")
        return self.folder / f"{name}{SUFFIX}"

    def candidates(self, name: str, at: float) -> Iterator[Path]:
        """Where a new recording called ``name`` may go, the best place first: ``name``, ``name-2``, ``name-3``, ...

        Empty names become the local date and time ``at`` (Unix, s). Raises ValueError for a name that may not be.
        """
        wanted = name or default_name(at)
        yield self.path(wanted)
        for number in itertools.count(2):
            ending = f"-{number}"
            yield self.path(wanted[: LONGEST_NAME - len(ending)] + ending)

    def free_bytes(self) -> int:
        """Room left on the disk for recordings, for this user. Raises OSError."""
        folder = self.folder
        while not folder.is_dir() and folder != folder.parent:
            folder = folder.parent
        return shutil.disk_usage(folder).free

    @property
    def ring_folder(self) -> Path:
        """Where rings keep their segments: hidden, so that nobody takes them for recordings."""
        return self.folder / ".ring"


def default_name(at: float) -> str:
    """A name made of the local date and time ``at`` (Unix, s), as ``2026-03-14_15-09-26``: they sort by age."""
    return time.strftime("%Y-%m-%d_%H-%M-%S", time.localtime(at))


def default_folder() -> Path:
    """``$HBBA_RECORDINGS``, or ``hbba/recordings`` in the user's data folder (XDG Base Directory Specification)."""
    if named := os.environ.get("HBBA_RECORDINGS"):
        return Path(named)
    data = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(data) / "hbba" / "recordings"
