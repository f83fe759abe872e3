"""A room as a map: 6 m by 4 m, its walls one cell thick, a pillar in it; the one that robots of parts are played in."""

from __future__ import annotations

from pathlib import Path

from app.maps.library import MapLibrary
from app.robots.simulated.parts.world import CELL_M, room

__all__ = ["CELL_M", "kept", "room"]


def kept(folder: Path, name: str = "room") -> Path:
    """The room as a kept map in the library ``folder``; returns its YAML file."""
    MapLibrary(folder).keep(name, room())
    return folder / name / "map.yaml"
