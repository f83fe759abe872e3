"""The occupancy grid: counts that come and go exactly, and what they show."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.modules.perception.slam.occupancy import REACH_M, OccupancyCounts, ScanView, cropped, view_of
from tests.modules.perception.slam.places import HALL, scan

AHEAD = ScanView(np.array([[2.0, 0.0]], np.float32), np.array([True]), (0.0, 0.0))
NOTHING_AHEAD = replace(AHEAD, ends=np.array([[29.0, 0.0]], np.float32), met=np.array([False]))
HERE = Pose2(0.025, 0.025, 0.0)

poses = st.builds(Pose2, st.floats(-40, 40), st.floats(-40, 40), st.floats(-4, 4))


@st.composite
def views(draw: st.DrawFn) -> ScanView:
    count = draw(st.integers(0, 20))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    ends = rng.uniform(-15, 15, (count, 2)).astype(np.float32)
    return ScanView(ends, rng.random(count) < 0.7, (draw(st.floats(-0.5, 0.5)), 0.1))


def value(counts: OccupancyCounts, x: float, y: float) -> int:
    """The value of the cell at x, y."""
    counts.refresh()
    column, row = (math.floor(v / counts.resolution_m) - low for v, low in zip((x, y), counts.lowest, strict=True))
    return int(counts.cells[row, column])


@settings(max_examples=50)
@given(st.lists(st.tuples(views(), poses), max_size=6), st.randoms())
def test_what_is_taken_out_again_leaves_no_trace_whatever_the_grid_grew_meanwhile(
    taken: list[tuple[ScanView, Pose2]], random: object
) -> None:
    counts = OccupancyCounts(side_m=10)
    for view, pose in taken:
        counts.add(view, pose)
    counts.refresh()
    random.shuffle(taken)  # type: ignore[attr-defined]
    for view, pose in taken:
        counts.remove(view, pose)
    assert not counts.hits.any()
    assert not counts.misses.any()
    counts.refresh()
    assert (counts.cells == -1).all()


@settings(max_examples=30)
@given(st.lists(st.tuples(views(), poses), min_size=1, max_size=4))
def test_every_view_counts_once_in_a_cell_and_hits_come_before_misses(taken: list[tuple[ScanView, Pose2]]) -> None:
    counts = OccupancyCounts(side_m=10)
    for view, pose in taken:
        counts.add(view, pose)
    assert (counts.hits.astype(int) + counts.misses).max(initial=0) <= len(taken)


def test_a_ray_clears_the_floor_up_to_what_it_meets() -> None:
    counts = OccupancyCounts()
    counts.add(AHEAD, HERE)
    assert [value(counts, x, 0.025) for x in (0.025, 1.0, 1.96, 2.03, 2.1)] == [0, 0, 0, 100, -1]
    assert value(counts, 1.0, 0.1) == -1


def test_a_ray_that_meets_nothing_clears_only_so_far() -> None:
    counts = OccupancyCounts()
    counts.add(NOTHING_AHEAD, HERE)
    assert value(counts, REACH_M - 0.1, 0.025) == 0
    assert value(counts, REACH_M + 0.2, 0.025) == -1


def test_who_walked_by_is_gone_after_a_few_looks_and_what_stands_stays() -> None:
    counts = OccupancyCounts()
    behind = replace(AHEAD, ends=np.array([[4.0, 0.0]], np.float32))
    counts.add(AHEAD, HERE)
    last_published = []
    for _ in range(20):
        counts.add(behind, HERE)
        last_published.append(value(counts, 2.03, 0.025))
    assert last_published == sorted(last_published, reverse=True)
    assert last_published[3] < 50
    assert last_published[-1] == 0
    assert value(counts, 4.03, 0.025) == 100


def test_a_wall_seen_along_itself_is_not_worn_away() -> None:
    counts = OccupancyCounts()
    x = np.linspace(0.5, 4.0, 200)
    along = ScanView(np.stack((x, np.full_like(x, 0.1)), axis=1).astype(np.float32), np.ones(200, bool), (0.0, 0.2))
    for _ in range(10):
        counts.add(along, Pose2())
    counts.refresh()
    row = math.floor(0.1 / 0.05) - counts.lowest[1]
    columns = slice(math.floor(0.55 / 0.05) - counts.lowest[0], math.floor(3.9 / 0.05) - counts.lowest[0])
    assert (counts.cells[row, columns] == 100).all()


def test_it_grows_where_it_must_and_keeps_what_it_has() -> None:
    counts = OccupancyCounts(side_m=50)
    assert counts.cells.shape == (1000, 1000)
    counts.add(AHEAD, HERE)
    counts.refresh()
    before = counts.cells.copy()
    counts.add(AHEAD, Pose2(-31.02, 40.02, math.pi))
    assert counts.cells.shape == (1400, 1200)
    assert counts.origin == (-35.0, -25.0)
    assert np.array_equal(counts.cells[:1000, 200:], before)
    assert value(counts, -33.02, 40.02) == 100
    assert value(counts, 2.03, 0.025) == 100


def test_only_a_change_of_a_cells_value_is_a_change() -> None:
    counts = OccupancyCounts()
    assert not counts.refresh()
    counts.add(AHEAD, HERE)
    assert counts.refresh()
    counts.add(AHEAD, HERE)
    assert not counts.refresh()


def test_the_view_of_a_scan_is_in_the_bodys_frame_and_leaves_out_what_says_nothing() -> None:
    seen = scan(HALL, Pose2(1.0, 3.0, 0.0), noise_m=0.0)
    values = seen.ranges.copy()
    values[:3] = (np.inf, 0.01, np.nan)
    view = view_of(replace(seen, ranges=values))
    assert len(view.ends) == len(values) - 2
    assert view.met.tolist() == [False] + [True] * (len(values) - 3)
    assert view.sensor_xy == (0.2, 0.0)
    middle = len(view.ends) // 2
    assert view.ends[middle] + (1.0, 3.0) == pytest.approx((12.0, 3.0), abs=0.1)


def test_cropping_leaves_what_is_known_and_a_margin() -> None:
    cells = np.full((100, 200), -1, np.int8)
    assert cropped(cells) == (slice(0, 100), slice(0, 200))
    cells[40:50, 5:100] = 0
    assert cropped(cells) == (slice(30, 60), slice(0, 110))
