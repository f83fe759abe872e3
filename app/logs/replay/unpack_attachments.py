"""A recording's files put back on disk: a log is of unknown origin, and its files may not be written anywhere else."""

from __future__ import annotations

import posixpath
from pathlib import Path

from app.logs.log import LogError
from app.logs.manifest import AttachedFile, Manifest

#: Levels that a program's files may be above the program itself.
_MOST_ABOVE = 16


def extract(manifest: Manifest, folder: Path) -> Path:
    """Write the files of ``manifest`` under ``folder``, as they lay to each other; return the folder of the program.

    Names may begin with ``..``: the program's own folder is made deep enough. Raises LogError for a name that is not
    relative, or leads further up than any program's would, having written nothing.
    """
    names = {file: _checked(file) for file in manifest.files}
    above = max((_parents(name) for name in names.values()), default=0)
    home = folder.joinpath(*(f"above-{number}" for number in range(above, 0, -1)), "program")
    home.mkdir(parents=True, exist_ok=True)
    for file, name in names.items():
        path = Path(posixpath.normpath(home.as_posix() + "/" + name))
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(file.data)
    return home


def _checked(file: AttachedFile) -> str:
    name = posixpath.normpath(file.name)
    if not file.name or "\\" in name or "\0" in name or posixpath.isabs(name) or name in (".", ".."):
        raise LogError(f"the recording carries a file named {file.name!r}, which is no relative path; it is not used")
    if _parents(name) > _MOST_ABOVE or name.endswith("/.."):
        raise LogError(f"the recording carries a file named {file.name!r}, far outside of its folder; it is not used")
    return name


def _parents(name: str) -> int:
    """Number of levels above its own folder at which a normal path begins."""
    return sum(1 for part in name.split("/") if part == "..")
