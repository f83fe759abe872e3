"""The floor as viewers are shown it: really served, really relayed."""

from __future__ import annotations

import asyncio
import json
import math
from typing import Any

import numpy as np
import pytest
import websockets

from app.base.geometry import Pose2
from app.console.view.relay import wish_of
from app.console.view.view import View
from app.messages import NavigationStatus
from app.program.system import System
from tests.console.live_client import page
from tests.console.places import grid, localization, path, status, zones
from tests.console.view.test_relay import Viewer, looking, shown, view  # noqa: F401
from tests.patience import PATIENCE_S

pytestmark = pytest.mark.filterwarnings("default::DeprecationWarning")

X_MO = Pose2(1.0, 0.5, math.pi / 2)


def sent_to(viewer: Viewer, kind: str, node: str) -> list[dict[str, Any]]:
    """The messages to ``node``."""
    return [message for message in viewer.seen if message["type"] == kind and message.get("name") == node]


async def test_map_way_and_goal_lie_on_the_floor_where_the_robot_is_on_them(url: str, system: System) -> None:
    graph, now = system.graph, system.clock.now
    graph.channel("map").publish(grid(now()))
    graph.channel("zones").publish(zones(now()))
    graph.channel("path").publish(path(now()))
    graph.channel("navigation").publish(status(now()))
    graph.channel("localization").publish(localization(now(), X_MO))
    async with looking(url) as viewer:
        await viewer.until(
            ("ImageMessage", "/odom/map/floor"),
            ("MeshMessage", "/odom/map/keep_out"),
            ("MeshMessage", "/odom/map/path"),
            ("MeshMessage", "/odom/map/goal"),
            ("SetPositionMessage", "/odom/map"),
        )
        X_OM = X_MO.inverse()
        position = sent_to(viewer, "SetPositionMessage", "/odom/map")[-1]["position"]
        np.testing.assert_allclose(position, (X_OM.x, X_OM.y, 0.0), atol=1e-6)
        await shown(viewer, "/odom/map", True)
        # No heading was asked for: there is a flag, but no arrow.
        await shown(viewer, "/odom/map/heading", False)
        # Of the map only what is known, and the zone beside it.
        (image,) = sent_to(viewer, "ImageMessage", "/odom/map/floor")
        assert image["props"]["render_width"] == pytest.approx(2.0 + 0.75)
        assert image["props"]["render_height"] == pytest.approx(1.0 + 1.5)

        # Found elsewhere, the robot stays in the middle, and the map moves below it.
        viewer.seen.clear()
        graph.channel("localization").publish(localization(now(), Pose2(), state="tracking"))
        graph.channel("navigation").publish(NavigationStatus(now(), "PlanAndFollowPath", "idle", ""))
        await viewer.until(("SetPositionMessage", "/odom/map"))
        np.testing.assert_allclose(
            sent_to(viewer, "SetPositionMessage", "/odom/map")[-1]["position"], (0, 0, 0), atol=1e-6
        )
        await shown(viewer, "/odom/map/path", False)
        await shown(viewer, "/odom/map/goal", False)
        assert not sent_to(viewer, "SetPositionMessage", "/odom")
        assert not [message for message in viewer.seen if "Remove" in message["type"]]


async def test_a_costmap_is_taken_while_a_viewer_wants_to_see_it(
    url: str,
    system: System,
    view: View,  # noqa: F811
) -> None:
    channel, now = system.graph.channel("local_costmap"), system.clock.now
    taken, rests = asyncio.Event(), asyncio.Event()
    channel.on_wanted(lambda wanted: taken.set() if wanted else rests.set())
    pulse_address = f"{url.replace('http', 'ws')}/viser/pulse?viewer=abc"
    async with looking(url) as viewer, page(url) as ann, asyncio.timeout(PATIENCE_S):
        await viewer.until(("PointCloudMessage", "/odom/cloud"))
        assert not channel.wanted
        # A page that shows it has it shown in the scene ...
        await ann.send("view", costmap=True)
        await taken.wait()
        channel.publish(grid(now(), frame="odom"))
        await viewer.until(("PointCloudMessage", "/odom/costmap"))
        # ... unless the scene's own page says otherwise.
        async with websockets.connect(pulse_address, proxy=None, close_timeout=1) as pulse:
            await pulse.send(json.dumps({"type": "layers", "costmap": False}))
            await shown(viewer, "/odom/costmap", False)
            assert [session.costmap for session in view.sessions] == [False]
            await ann.send("view", costmap=False)
            await rests.wait()
            await pulse.send(json.dumps({"type": "layers", "costmap": True}))
            channel.publish(grid(now(), frame="odom", corner=50))
            await shown(viewer, "/odom/costmap", True)


@pytest.mark.parametrize("frame", ["", "{", "3 33.4", '{"type": "other"}', '{"type": "layers", "costmap": 1}', b"\xff"])
def test_what_is_no_wish_for_layers_is_none(frame: str | bytes) -> None:
    assert wish_of(frame) is None
