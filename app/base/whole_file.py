"""Files that are written wholly or not at all, also where the program or the computer fails meanwhile."""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path

_NEW_FILE = 0o666


def write_whole(path: Path, data: bytes, *, mode: int | None = None) -> None:
    """Let the file ``path`` have ``data``: it has all of it, or what it had before. Raises OSError.

    It is written under another name in its folder first. ``mode``: its permissions, without those that the umask
    takes; by default those of the file that is replaced, or of any new file.
    """
    beside = path.with_name(f".{path.name}.new")
    beside.unlink(missing_ok=True)
    try:
        write_synced(beside, data, _NEW_FILE if mode is None else mode)
        if mode is None:
            with contextlib.suppress(FileNotFoundError):
                beside.chmod(stat.S_IMODE(path.stat().st_mode))
        beside.replace(path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise


def write_synced(path: Path, data: bytes, mode: int = _NEW_FILE) -> None:
    """Make the file ``path``, which does not exist, with ``data``; it is on the disk when this returns. Raises OSError.

    ``mode``: its permissions, without those that the umask takes.
    """
    number = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, mode)
    with os.fdopen(number, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(number)
