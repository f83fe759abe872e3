"""Submaps while a drive goes on: two overlap, and each keyframe is in one at least."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from app.base.geometry import Pose2
from app.modules.perception.slam.submap_builder import SubmapBuilder
from app.modules.perception.slam.surfels import SurfelGrid
from app.modules.perception.slam.types import Submap

POINTS = np.array([[1.0, 0.0, -1.0, 0.0], [1.0, 0.1, -1.0, 0.0]], np.float32)


def driven(builder: SubmapBuilder, ids: range) -> None:
    for id in ids:
        for submap in builder.active:
            submap.add(id, POINTS, Pose2(0.1 * (id - submap.first)))
        builder.begin_if_due(id, POINTS)


@pytest.mark.parametrize("full", [4, 10, 30])
def test_two_overlap_by_half(full: int) -> None:
    builder = SubmapBuilder(full)
    driven(builder, range(100))
    assert [submap.id for submap in builder.finished] == list(range(len(builder.finished)))
    assert all(len(submap.keyframes) == full for submap in builder.finished)
    everyone = [*(submap.keyframes for submap in builder.finished), *(submap.keyframes for submap in builder.active)]
    assert {id for ids in everyone for id in ids} == set(range(100))
    begins = [ids[0] for ids in everyone]
    assert {later - earlier for earlier, later in pairwise(begins)} <= {full // 2 - 1, full // 2}


def test_finished_submaps_go_on_in_number_after_those_of_a_saved_map() -> None:
    builder = SubmapBuilder(4, [(0, 1, 2, 3), (2, 3, 4, 5)])
    driven(builder, range(6, 9))
    builder.finish()
    assert builder.active == []
    assert builder.finished[:2] == [Submap(0, (0, 1, 2, 3)), Submap(1, (2, 3, 4, 5))]
    assert builder.finished[2] == Submap(2, (6, 7, 8))


def test_pruning_leaves_alone_what_was_finished_meanwhile() -> None:
    builder = SubmapBuilder(4, [(0, 1, 2, 3), (2, 3, 4, 5)])
    known = len(builder.finished)
    driven(builder, range(6, 20))
    later = builder.finished[known:]
    assert later
    builder.replace([Submap(1, (4, 5))], known)
    assert builder.finished == [Submap(1, (4, 5)), *later]


def test_a_local_map_is_gone_on_with_alone() -> None:
    builder = SubmapBuilder(10)
    driven(builder, range(9))
    grid = SurfelGrid()
    grid.insert(POINTS, Pose2())
    builder.begin_on(grid, 3)
    assert [submap.keyframes for submap in builder.active] == [[3]]
    assert builder.active[0].grid is grid
    assert builder.finished == []


def test_a_grid_is_made_ready_for_searches_once_for_each_change() -> None:
    builder = SubmapBuilder(10)
    driven(builder, range(1))
    submap = builder.active[0]
    first = submap.pyramid()
    assert submap.pyramid() is first
    submap.add(1, POINTS, Pose2(0.2))
    assert submap.pyramid() is not first
