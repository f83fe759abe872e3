"""What of the voxel map a viewer is sent: what changed, the nearest first, a share that its points allow."""

from __future__ import annotations

import asyncio

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.console.view.voxel_nodes import MOST_CHUNKS, SENT_AT_ONCE, due, share_of
from app.messages import PointCloud, read_only
from app.program.system import System
from tests.console.view.test_relay import looking
from tests.patience import PATIENCE_S


@given(st.integers(0, 120_000), st.integers(0, 76_800))
def test_the_share_keeps_within_the_points_and_wastes_little(voxels: int, points: int) -> None:
    share = share_of(voxels, points)
    assert 0.0 <= share <= 1.0
    assert share * voxels <= points * (1 + 1e-9) or share == 1.0
    assert share == 1.0 or share * voxels >= 0.7 * points


def test_only_what_changed_is_sent_the_nearest_first_a_few_at_once() -> None:
    versions = {(x, 0): 1 for x in range(20)}
    first, hidden = due(versions, {}, 1.0, Pose2(0.5, 0.5, 0.0))
    assert first == [(x, 0) for x in range(SENT_AT_ONCE)]
    assert hidden == []
    sent = dict.fromkeys(versions, (1, 1.0))
    assert due(versions, sent, 1.0, Pose2()) == ([], [])
    assert due({**versions, (3, 0): 2}, sent, 1.0, Pose2()) == ([(3, 0)], [])
    assert len(due(versions, sent, 0.5, Pose2())[0]) == SENT_AT_ONCE


def test_chunks_that_are_empty_or_far_are_hidden() -> None:
    versions = {(x, 0): 1 for x in range(MOST_CHUNKS + 3)}
    sent = dict.fromkeys([*versions, (0, 9)], (1, 1.0))
    changed, hidden = due(versions, sent, 1.0, Pose2())
    assert changed == []
    assert set(hidden) == {(0, 9), *((MOST_CHUNKS + extra, 0) for extra in range(3))}


@pytest.mark.filterwarnings("default::DeprecationWarning")
async def test_what_was_seen_stays_in_the_view_when_the_robot_looks_elsewhere(url: str, system: System) -> None:
    wall = np.stack(np.meshgrid([2.0], np.arange(-0.5, 0.5, 0.04), np.arange(0.2, 1.0, 0.04)), axis=-1).reshape(-1, 3)
    colors = read_only(np.full((len(wall), 3), 180, np.uint8))
    channel = system.graph.channel("point_cloud")
    async with looking(url) as viewer, asyncio.timeout(PATIENCE_S):
        await viewer.until(("PointCloudMessage", "/odom/cloud"))
        now = system.clock.now()
        for number in range(2):
            X_OB = Pose2(1.0, 0.0, number * np.pi)
            channel.publish(PointCloud(now + number, read_only(wall.astype(np.float32)), colors, X_OB))
            # Two chunks on each side: y from -0.5 to 0.5.
            await viewer.until(*(("PointCloudMessage", f"/odom/voxels_{2 * number + side}") for side in range(2)))
    assert not [
        m
        for m in viewer.seen
        if m["type"] == "SetSceneNodeVisibilityMessage" and m["name"] == "/odom/voxels_0" and not m["visible"]
    ]
