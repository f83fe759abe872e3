"""The voxel map: bounded, fading, cleared where it is seen through, sent by chunks that changed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from app.console.view import voxels
from app.console.view.voxels import AGES_S, CHUNK_M, VOXEL_M, VoxelMap

EYE = np.array([0.0, 0.0, 1.0])


def wall(x: float, half_width: float = 0.5, half_height: float = 0.4) -> NDArray[np.float32]:
    """Points of a wall across the way, around the height of the eye."""
    y, z = np.meshgrid(np.arange(-half_width, half_width, 0.02), np.arange(1.0 - half_height, 1.0 + half_height, 0.02))
    return np.stack([np.full(y.size, x), y.ravel(), z.ravel()], axis=1).astype(np.float32)


def grey(points: NDArray[np.float32], value: int = 200) -> NDArray[np.uint8]:
    return np.full((len(points), 3), value, np.uint8)


def shown(voxel_map: VoxelMap) -> NDArray[np.float32]:
    """Middles of all voxels, by chunks."""
    return np.concatenate([voxel_map.chunk(chunk).points for chunk in voxel_map.versions()])


@given(st.integers(0, 1000))
@settings(max_examples=25)
def test_every_point_is_in_a_voxel_of_a_chunk_and_no_voxel_is_twice(seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-4, 4, (300, 3)).astype(np.float32)
    voxel_map = VoxelMap()
    voxel_map.add(points, grey(points), EYE, 1.0)
    middles = shown(voxel_map)
    assert len(middles) == len(voxel_map) == len(np.unique(np.round(middles / VOXEL_M, 1), axis=0))
    apart = np.abs(points[:, None] - middles[None]).max(axis=2).min(axis=1)
    assert apart.max() <= VOXEL_M / 2 + 1e-5


def test_what_is_seen_again_is_no_more_voxels_and_no_change() -> None:
    voxel_map, points = VoxelMap(), wall(2.0)
    voxel_map.add(points, grey(points), EYE, 1.0)
    before, count = dict(voxel_map.versions()), len(voxel_map)
    voxel_map.add(points, grey(points), EYE, 1.2)
    assert (len(voxel_map), voxel_map.versions()) == (count, before)


def test_what_is_seen_through_goes_and_what_is_hidden_stays() -> None:
    voxel_map, near, far = VoxelMap(), wall(2.0, 0.2, 0.2), wall(4.0, 1.2, 1.0)
    voxel_map.add(near, grey(near), EYE, 1.0)
    voxel_map.add(far, grey(far), EYE, 2.0)
    assert shown(voxel_map)[:, 0].min() > 3.5
    voxel_map.add(near, grey(near), EYE, 3.0)
    assert {round(float(x)) for x in shown(voxel_map)[:, 0]} == {2, 4}


def test_voxels_fade_in_steps_and_go() -> None:
    voxel_map, points = VoxelMap(), wall(2.0)
    voxel_map.add(points, grey(points), EYE, 10.0)
    (chunk, *_) = voxel_map.versions()
    seen = []
    for age in (0.0, *AGES_S):
        voxel_map.fade(10.0 + age)
        colors = voxel_map.chunk(chunk).colors
        seen.append(int(colors.max()) if len(colors) else 0)
    assert seen == sorted(seen, reverse=True)
    assert len(set(seen)) == len(AGES_S) + 1
    assert (seen[0], seen[-1], len(voxel_map), voxel_map.versions()) == (200, 0, 0, {})


def test_seen_again_a_faded_voxel_is_bright_and_a_change() -> None:
    voxel_map, points = VoxelMap(), wall(2.0)
    voxel_map.add(points, grey(points), EYE, 10.0)
    voxel_map.fade(10.0 + AGES_S[0])
    before = dict(voxel_map.versions())
    voxel_map.add(points, grey(points), EYE, 10.5 + AGES_S[0])
    assert all(voxel_map.versions()[chunk] > version for chunk, version in before.items())
    assert voxel_map.chunk(next(iter(before))).colors.max() == 200


def test_only_chunks_with_something_new_change() -> None:
    voxel_map, here = VoxelMap(), np.array([[0.5, 0.5, 1.0]], np.float32)
    voxel_map.add(here, grey(here), EYE, 1.0)
    there = here + np.float32(3 * CHUNK_M)
    voxel_map.add(there, grey(there), EYE, 1.1)
    assert voxel_map.versions() == {(0, 0): 1, (3, 3): 2}


def test_it_is_bounded_and_the_oldest_go(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(voxels, "MOST_VOXELS", 100)
    voxel_map = VoxelMap()
    for number in range(3):
        line = np.stack([np.full(60, 2.0 + number), np.arange(60) * 0.1, np.full(60, 3.0)], axis=1).astype(np.float32)
        voxel_map.add(line, grey(line), np.array([0.0, 0.0, 50.0]), float(number))
    assert len(voxel_map) == 100
    assert (shown(voxel_map)[:, 0] > 3.5).sum() == 60


def test_another_time_begins_with_an_empty_room() -> None:
    voxel_map, points = VoxelMap(), wall(2.0)
    voxel_map.add(points, grey(points), EYE, 100.0)
    later = wall(3.0)
    voxel_map.add(later, grey(later), np.array([0.0, 9.0, 1.0]), 5.0)
    assert shown(voxel_map)[:, 0].min() > 2.5


def test_points_that_are_nowhere_are_left_out() -> None:
    voxel_map = VoxelMap()
    points = np.array([[np.nan, 0, 0], [np.inf, 0, 0], [1e9, 0, 0], [1, 1, 1]], np.float32)
    voxel_map.add(points, grey(points), EYE, 1.0)
    assert len(voxel_map) == 1


def test_a_part_of_a_chunk_is_spread_over_it() -> None:
    voxel_map, points = VoxelMap(), wall(0.4, 0.7)
    voxel_map.add(points, grey(points), EYE, 1.0)
    ranks = np.concatenate([voxel_map.chunk(chunk).ranks for chunk in voxel_map.versions()])
    assert ranks.min() >= 0.0
    assert ranks.max() < 1.0
    assert (ranks < 0.25).mean() == pytest.approx(0.25, abs=0.1)
