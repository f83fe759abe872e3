"""Cells wherever they are: what is written is read, and only what is kept stays."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from app.modules.behaviors.navigation.costmap.tiled_grid import NEVER, Box, CellBlock, TiledGrid


def some(box: Box, seed: int) -> CellBlock:
    rng = np.random.default_rng(seed)
    shape = box[1] - box[0], box[3] - box[2]
    last = np.where(rng.random(shape) < 0.3, rng.integers(0, 9, shape), NEVER).astype(np.int32)
    kept = (last != NEVER) & (rng.random(shape) < 0.2)
    return CellBlock(last.copy(), last, rng.integers(0, 99, shape).astype(np.uint16) * (last != NEVER), kept)


PLACES = st.tuples(
    st.integers(-200, 200), st.integers(1, 90), st.integers(-200, 200), st.integers(1, 90)
).map(lambda p: (p[0], p[0] + p[1], p[2], p[2] + p[3]))  # fmt: skip


@settings(max_examples=30)
@given(st.lists(PLACES, min_size=1, max_size=4))
def test_what_is_written_is_read_and_what_is_kept_is_known_wherever_it_is(boxes: list[Box]) -> None:
    tiles = TiledGrid()
    known: dict[tuple[int, int], int] = {}
    for seed, box in enumerate(boxes):
        cells = some(box, seed)
        tiles.write(box, cells)
        back = tiles.read(box)
        assert (back.last == cells.last).all()
        assert (back.first == cells.first).all()
        assert (back.bands == cells.bands).all()
        assert (back.kept == cells.kept).all()
        known = {at: b for at, b in known.items() if not (box[0] <= at[0] < box[1] and box[2] <= at[1] < box[3])}
        rows, columns = np.nonzero(cells.kept)
        known |= {
            (int(r) + box[0], int(c) + box[2]): int(cells.bands[r, c]) for r, c in zip(rows, columns, strict=True)
        }
        found = [(int(r), int(c)) for r, c in tiles.kept()]
        assert dict(zip(found, tiles.bands().tolist(), strict=True)) == known
        assert {(int(r), int(c)) for r, c in tiles.kept(box)} == {
            at for at in known if box[0] <= at[0] < box[1] and box[2] <= at[1] < box[3]
        }


def test_it_holds_no_more_than_what_is_kept_and_where_the_robot_is() -> None:
    tiles = TiledGrid()
    for k in range(50):
        box = (100 * k, 100 * k + 64, 0, 64)
        cells = some(box, k)
        cells.kept[:] = False
        tiles.write(box, cells)
    assert len(tiles) <= 4
    far = np.array([[10**9, -(10**9)], [0, 0]])
    tiles.keep(far, np.array([1, 2], dtype=np.uint16), 5)
    assert sorted(map(tuple, tiles.kept().tolist())) == sorted(map(tuple, far.tolist()))
    assert len(tiles) <= 6


def test_what_is_kept_twice_is_there_once_in_all_bands() -> None:
    tiles = TiledGrid()
    tiles.keep(np.array([[-1, 3], [-1, 3]]), np.array([1, 4], dtype=np.uint16), 5)
    assert tiles.kept().tolist() == [[-1, 3]]
    assert tiles.bands().tolist() == [5]
