"""A* over a cost field with 8 neighbours, fast on whole maps (thesis 4.2.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.modules.behaviors.navigation.costmap.inflation import CostField

_UNREACHED = np.iinfo(np.int32).max


@dataclass(frozen=True, slots=True, eq=False)
class ReachedCells:
    """Result of a search from ``start`` (row, column of a cell): ``blocks``, ``cost`` and ``came`` as in
    ``astar_kernels``.

    Blocks begin at even cells of the map frame's origin, not of the array's, so that a growing map keeps its paths.
    """

    field: CostField
    start: tuple[int, int]
    blocks: NDArray[np.int32]
    cost: NDArray[np.int32]
    came: NDArray[np.uint8]
    odd: tuple[int, int]
    fee: float

    def block(self, cell: tuple[int, int]) -> int:
        """The flat index of a cell's block."""
        return _block(cell, self.odd, self.blocks.shape[1])

    def has(self, cell: tuple[int, int]) -> bool:
        """Whether a path to the cell was found."""
        bit = ((cell[0] + self.odd[0]) % 2) * 2 + (cell[1] + self.odd[1]) % 2
        block = self.block(cell)
        return bool(self.cost[block] != _UNREACHED and int(self.blocks.flat[block]) & (1 << bit))

    def way(self, cell: tuple[int, int]) -> NDArray[np.int64]:
        """The path as cells (N, 2) row, column from ``start`` to ``cell``, which was reached; each touches the one
        before."""
        from app.modules.behaviors.navigation.planning.astar_kernels import trace

        return trace(self.blocks, self.came, self.block(cell), self.start, cell, self.field.cost, self.fee, *self.odd)


def explore(
    field: CostField,
    start: tuple[int, int],
    goal: tuple[int, int] | None = None,
    passable: int = 0,
    fee: float = 50.0,
) -> ReachedCells:
    """A* from cell ``start`` (not lethal) to ``goal``; without a goal, or if it cannot be reached, Dijkstra's search of
    all reachable cells.

    Cells that are lethal only for reasons in ``passable`` (bits AT_... of ``inflation``), or for being unknown, may be
    crossed at ``fee`` per metre if ``fee`` is not zero.
    """
    from app.modules.behaviors.navigation.planning.astar_kernels import pool, search

    frame = field.frame
    odd = (round(frame.y / frame.resolution_m) % 2, round(frame.x / frame.resolution_m) % 2)
    blocks = pool(field.cost, field.layers, passable, fee, *odd)
    width = blocks.shape[1]
    cost, came = search(blocks, _block(start, odd, width), -1 if goal is None else _block(goal, odd, width))
    return ReachedCells(field, start, blocks=blocks, cost=cost, came=came, odd=odd, fee=fee)


def _block(cell: tuple[int, int], odd: tuple[int, int], width: int) -> int:
    return ((cell[0] + odd[0]) // 2 + 1) * width + (cell[1] + odd[1]) // 2 + 1
