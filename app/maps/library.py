"""The folder of maps: names, listing, renaming, deleting.

A map is a folder of its own: ``map.yaml`` and ``map.pgm`` (as ROS's ``map_server`` reads them), ``graph.npz`` (its pose
graph, with which mapping goes on), ``zones.yaml``.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

#: What a map may be called: nothing that could leave the folder.
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")


class MapLibrary:
    """Maps in one folder. All methods touch the disk: call them off the event loop."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def path(self, name: str) -> Path:
        """The folder that the map ``name`` has or would have. Raises ValueError for a name that may not be."""
        if not NAME.fullmatch(name):
            raise ValueError(
                f"a map's name has 1 to 100 letters, digits, '.', '_' or '-' and begins with a letter or a digit,"
                f" not {name!r}"
            )
        return self.folder / name


def default_folder() -> Path:
    """``$HBBA_MAPS``, or ``hbba/maps`` in the user's data folder (XDG Base Directory Specification)."""
    if named := os.environ.get("HBBA_MAPS"):
        return Path(named)
    data = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(data) / "hbba" / "maps"
