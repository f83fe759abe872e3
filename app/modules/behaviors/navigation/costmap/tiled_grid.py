"""An unbounded grid of tiles: memory grows with the kept cells and the robot's surroundings, not with the map."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: Time of a cell that was never hit, ms.
NEVER = -(2**30)
#: Cells along a tile's side.
TILE = 64

#: The first row, the row after the last, the first column, the column after the last.
Box = tuple[int, int, int, int]


@dataclass(frozen=True, slots=True, eq=False)
class CellBlock:
    """Cells of a rectangle, (rows, columns) each: times of the ``first`` and ``last`` hit (int32, ms), occupied height
    ``bands`` (uint16, a bit each), and whether the cell is ``kept`` (bool)."""

    first: NDArray[np.int32]
    last: NDArray[np.int32]
    bands: NDArray[np.uint16]
    kept: NDArray[np.bool_]

    @staticmethod
    def empty(rows: int, columns: int) -> CellBlock:
        """Cells that were never hit."""
        shape = (rows, columns)
        return CellBlock(
            np.full(shape, NEVER, dtype=np.int32), np.full(shape, NEVER, dtype=np.int32),
            np.zeros(shape, dtype=np.uint16), np.zeros(shape, dtype=np.bool_),
        )  # fmt: skip


class TiledGrid:
    """Cells by row and column, which may be negative. Kept cells stay; others only while their tile is in use."""

    def __init__(self) -> None:
        self._grid: dict[tuple[int, int], CellBlock] = {}
        #: Row and column (N, 2) int64 of the kept cells of those tiles that have any.
        self._kept: dict[tuple[int, int], NDArray[np.int64]] = {}

    def __len__(self) -> int:
        return len(self._grid)

    def read(self, box: Box) -> CellBlock:
        """A copy of the cells in ``box``."""
        out = CellBlock.empty(box[1] - box[0], box[3] - box[2])
        for key, inside, part in _parts(box):
            if (tile := self._grid.get(key)) is not None:
                out.first[part], out.last[part] = tile.first[inside], tile.last[inside]
                out.bands[part], out.kept[part] = tile.bands[inside], tile.kept[inside]
        return out

    def write(self, box: Box, cells: CellBlock) -> None:
        """Replace the cells in ``box``. Cells of other tiles that are not kept are dropped: their hits are too old."""
        seen = set()
        for key, inside, part in _parts(box):
            seen.add(key)
            tile = self._grid.get(key)
            if tile is None:
                if (cells.last[part] == NEVER).all():
                    continue
                tile = self._grid[key] = CellBlock.empty(TILE, TILE)
            changed = (tile.kept[inside] != cells.kept[part]).any()
            tile.first[inside], tile.last[inside] = cells.first[part], cells.last[part]
            tile.bands[inside], tile.kept[inside] = cells.bands[part], cells.kept[part]
            if changed:
                self._note(key, tile)
        for key in [key for key in self._grid if key not in seen and key not in self._kept]:
            del self._grid[key]

    def keep(self, cells: NDArray[np.int64], bands: NDArray[np.uint16], stamp: int) -> None:
        """Keep ``cells`` (N, 2), row and column, with a hit at ``stamp`` in ``bands`` (N,)."""
        tiles = cells // TILE
        for i, j in np.unique(tiles, axis=0).tolist():
            tile = self._grid.setdefault((i, j), CellBlock.empty(TILE, TILE))
            here = (tiles == (i, j)).all(axis=1)
            rows, columns = (cells[here] - np.array([i, j]) * TILE).T
            tile.first[rows, columns] = tile.last[rows, columns] = stamp
            np.bitwise_or.at(tile.bands, (rows, columns), bands[here])
            tile.kept[rows, columns] = True
            self._note((i, j), tile)

    def recount(self) -> None:
        """Set the times of kept cells to 0, of all others to never, for a new epoch."""
        for tile in self._grid.values():
            tile.first[:] = tile.last[:] = np.where(tile.kept, 0, NEVER)

    def kept(self, box: Box | None = None) -> NDArray[np.int64]:
        """Row and column (N, 2) int64 of the kept cells, in ``box`` or of all tiles."""
        if box is None:
            parts = [self._kept[key] for key in sorted(self._kept)]
            return np.concatenate(parts) if parts else np.empty((0, 2), dtype=np.int64)
        parts = [self._kept[key] for key, _, _ in _parts(box) if key in self._kept]
        if not parts:
            return np.empty((0, 2), dtype=np.int64)
        cells = np.concatenate(parts)
        return cells[((cells >= box[::2]) & (cells < box[1::2])).all(axis=1)]

    def bands(self) -> NDArray[np.uint16]:
        """The bands (N,) of all kept cells, in the order of :meth:`kept`."""
        parts = [self._grid[key].bands[self._grid[key].kept] for key in sorted(self._kept)]
        return np.concatenate(parts) if parts else np.empty(0, dtype=np.uint16)

    def _note(self, key: tuple[int, int], tile: CellBlock) -> None:
        cells = np.argwhere(tile.kept) + np.array(key) * TILE
        if len(cells):
            self._kept[key] = cells
        else:
            self._kept.pop(key, None)


def _parts(box: Box) -> Iterator[tuple[tuple[int, int], tuple[slice, slice], tuple[slice, slice]]]:
    """Each tile that overlaps ``box``: its key, the overlap in the tile, and the overlap in the box."""
    r0, r1, c0, c1 = box
    for i in range(r0 // TILE, -(-r1 // TILE)):
        for j in range(c0 // TILE, -(-c1 // TILE)):
            top, bottom = max(r0, i * TILE), min(r1, (i + 1) * TILE)
            left, right = max(c0, j * TILE), min(c1, (j + 1) * TILE)
            inside = slice(top - i * TILE, bottom - i * TILE), slice(left - j * TILE, right - j * TILE)
            yield (i, j), inside, (slice(top - r0, bottom - r0), slice(left - c0, right - c0))
