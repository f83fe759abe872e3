"""Maps out of nothing."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from app.messages import OccupancyGrid, read_only


def room(side: int = 40, cell_m: float = 0.05) -> OccupancyGrid:
    """A square room with a pillar, unknown around its walls."""
    cells = np.full((side, side), -1, np.int8)
    cells[5:-5, 5:-5] = 100
    cells[6:-6, 6:-6] = 0
    cells[12:15, 20:24] = 100
    return OccupancyGrid(100.0, "map", read_only(cells), cell_m, (-1.0, 2.5), 3)


@st.composite
def trinary_grids(draw: st.DrawFn) -> OccupancyGrid:
    """Grids whose cells a trinary picture can distinguish."""
    shape = draw(st.integers(1, 30)), draw(st.integers(1, 30))
    cells = draw(arrays.arrays(np.int8, shape, elements=st.sampled_from([-1, 0, 100])))
    figures = draw(st.floats(0.01, 1)), (draw(st.floats(-1e3, 1e3)), draw(st.floats(-1e3, 1e3)))
    return OccupancyGrid(0.0, "map", cells, *figures, 0)
