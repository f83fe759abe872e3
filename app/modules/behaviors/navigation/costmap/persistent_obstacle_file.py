"""File format of persistent obstacles: NumPy's npz."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.base.errors import ConfigError
from app.base.npz_source import read_arrays
from app.modules.behaviors.navigation.costmap.tiled_grid import TILE

_VERSION = 1
#: Greatest number of tiles (3.2 m square) with low obstacles; more would exhaust memory, and no building has them.
_MOST_TILES = 10_000


@dataclass(frozen=True, slots=True, eq=False)
class PersistentObstacles:
    """Cells with a persistent obstacle: rows and columns ``cells`` (N, 2) int64 on the map, and occupied height
    ``bands`` (N,) uint16."""

    cells: NDArray[np.int64]
    bands: NDArray[np.uint16]

    @staticmethod
    def none() -> PersistentObstacles:
        return PersistentObstacles(np.empty((0, 2), dtype=np.int64), np.empty(0, dtype=np.uint16))


def write_obstacles(file: Path, obstacles: PersistentObstacles, resolution_m: float) -> None:
    """Write ``obstacles``, in cells of ``resolution_m``, and sync the file. Raises OSError."""
    with file.open("wb") as out:
        np.savez_compressed(
            out,
            version=_VERSION,
            resolution_m=resolution_m,
            cells=obstacles.cells.astype(np.int32),
            bands=obstacles.bands,
        )
        out.flush()
        os.fsync(out.fileno())


def read_obstacles(file: Path, resolution_m: float) -> PersistentObstacles:
    """The obstacles in ``file``; none where there is no file. Raises ConfigError for a file that is unreadable,
    damaged, or of another cell size than ``resolution_m``."""
    if not file.exists():
        return PersistentObstacles.none()
    kept = read_arrays(file, "the file of low obstacles")
    try:
        version, resolution, cells, bands = (kept[name] for name in ("version", "resolution_m", "cells", "bands"))
    except KeyError as missing:
        raise ConfigError(f"the file of low obstacles has no {missing.args[0]}", str(file)) from None
    if version.shape != () or version != _VERSION or resolution.shape != () or resolution != resolution_m:
        raise ConfigError("the file of low obstacles is of another version", str(file))
    fits = cells.ndim == 2 and cells.shape[1] == 2 and bands.shape == (len(cells),)
    if not fits or cells.dtype != np.int32 or bands.dtype != np.uint16:
        raise ConfigError("the file of low obstacles is damaged: cells and bands do not go together", str(file))
    if len(np.unique(cells // TILE, axis=0)) > _MOST_TILES:
        raise ConfigError("the file of low obstacles is damaged: they are too far apart", str(file))
    return PersistentObstacles(cells.astype(np.int64), bands)
