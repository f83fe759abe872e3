"""The 3D view on a recording: a paused scene is shown to a new viewer too, and nothing of another time stays."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from typing import Any

import pytest

from tests.console.view.test_relay import Viewer, looking, unpack
from tests.logs.replay.logs import BEGIN, lab_log
from tests.logs.replay.playing import Played, prepare
from tests.patience import PATIENCE_S

pytestmark = pytest.mark.filterwarnings("default::DeprecationWarning")


@pytest.fixture
def prepared() -> Any:
    """Some seconds of the lab; the cloud was wanted from 1 s to 3 s."""
    return prepare(lab_log(5.0))


async def until(viewer: Viewer, kind: str, node: str, field: str, holds: Callable[[Any], bool]) -> None:
    """Read until ``holds`` of the last message to ``node``."""
    async with asyncio.timeout(PATIENCE_S):
        while True:
            said = [m[field] for m in viewer.seen if m["type"] == kind and m["name"] == node]
            if said and holds(said[-1]):
                return
            viewer.seen.extend(unpack(await viewer.connection.recv(decode=False)))


async def visible(viewer: Viewer, node: str, expected: bool) -> None:
    """Read until ``node`` is as it should be."""
    await until(viewer, "SetSceneNodeVisibilityMessage", node, "visible", lambda said: said is expected)


async def gone(viewer: Viewer, metres: float) -> None:
    """Read until the robot is shown so far from where it began."""
    await until(
        viewer, "SetPositionMessage", "/odom", "position", lambda p: abs(math.hypot(p[0], p[1]) - metres) < 0.01
    )


async def test_the_scene_follows_a_recording_forth_and_back(replay_url: str, play: Played) -> None:
    await play.playback.seek(BEGIN + 1.5)
    async with looking(replay_url) as viewer:
        # Time is paused: all of this is shown because of the viewer.
        await viewer.until(
            ("SetPositionMessage", "/odom"),
            ("SceneNodeUpdateMessage", "/odom/scan"),
            ("SceneNodeUpdateMessage", "/odom/cloud"),
            ("BoxMessage", "/odom/map/landmark_0"),
        )
        await gone(viewer, 0.15)
        await visible(viewer, "/odom/cloud", True)
        await play.playback.seek(BEGIN + 4.5)
        await gone(viewer, 0.45)
        await visible(viewer, "/odom/cloud", False)
        await visible(viewer, "/odom/scan", True)
        await play.playback.seek(BEGIN + 1.5)
        await gone(viewer, 0.15)
        await visible(viewer, "/odom/cloud", True)
