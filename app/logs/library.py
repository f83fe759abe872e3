"""The folder of recordings: names, paths, room on the disk."""

from __future__ import annotations

import itertools
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

from app.base.named_library import LONGEST_NAME, NAME, NamedLibrary, data_folder, name_rule

SUFFIX = ".mcap"
#: Pattern (ECMA-262) of a field that holds a recording's name or is empty.
NAME_PATTERN = f"^({NAME.pattern})?$"


def name_or_nothing(name: str) -> str:
    """``name``, unchanged; an empty one is valid: the recording is then named by its time. Raises ValueError."""
    if name and not NAME.fullmatch(name):
        raise ValueError(name_rule(RecordingLibrary.kind))
    return name


class RecordingLibrary(NamedLibrary):
    """Recordings in one folder, each ``<name>.mcap``. All methods touch the disk: call them off the event loop."""

    kind = "recording"
    suffix = SUFFIX

    def candidates(self, name: str, at: float) -> Iterator[Path]:
        """Paths for a new recording ``name``, in order of preference: ``name``, ``name-2``, ``name-3``, ...

        Empty names become the local date and time ``at`` (Unix, s). Raises ValueError for an invalid name.
        """
        wanted = name or default_name(at)
        yield self.path(wanted)
        for number in itertools.count(2):
            ending = f"-{number}"
            yield self.path(wanted[: LONGEST_NAME - len(ending)] + ending)

    def free_bytes(self) -> int:
        """Free bytes of the disk for this user. Raises OSError."""
        folder = self.folder
        while not folder.is_dir() and folder != folder.parent:
            folder = folder.parent
        return shutil.disk_usage(folder).free

    @property
    def ring_folder(self) -> Path:
        """The folder of rings' segments: hidden, so that it is not listed as a recording."""
        return self.folder / ".ring"


def default_name(at: float) -> str:
    """The local date and time ``at`` (Unix, s) as a name, ``2026-03-14_15-09-26``: such names sort by age."""
    return time.strftime("%Y-%m-%d_%H-%M-%S", time.localtime(at))


def default_folder() -> Path:
    """``$HBBA_RECORDINGS``, or ``hbba/recordings`` in the user's data folder."""
    return data_folder("HBBA_RECORDINGS", "recordings")
