"""A click in a 3D view, from REST to the painter's thread and back."""

from __future__ import annotations

import asyncio
import dataclasses
import math

import httpx
import pytest
import websockets

from app.base.geometry import Pose2
from app.console.records.program import ScenePoint
from app.messages import Landmark, Landmarks, Odometry
from app.program.system import System
from tests.console.answers import answered, is_problem
from tests.console.places import localization
from tests.console.program import Body
from tests.console.view.test_relay import CAMERA, looking, pack
from tests.patience import PATIENCE_S

pytestmark = pytest.mark.filterwarnings("default::DeprecationWarning")

#: Beside the robot, 1.2 m high, looking ahead along its x.
BESIDE = dataclasses.replace(CAMERA, position=(0.0, 1.0, 1.2), look_at=(3.0, 1.0, 1.2))
MIDDLE = {"viewer": "abc", "u": 0.5, "v": 0.5}


async def drawn(client: httpx.AsyncClient, kind: str, frame: str = "odom") -> ScenePoint:
    """What the middle of the view shows, once that is of this kind, in this frame."""
    async with asyncio.timeout(PATIENCE_S):
        while True:
            point = answered(await client.post("/scene/point", json=MIDDLE), ScenePoint)
            if (point.kind, point.frame) == (kind, frame):
                return point


async def test_a_click_in_a_view_is_what_it_shows_there(
    url: str, client: httpx.AsyncClient, system: System, body: Body
) -> None:
    is_problem(await client.post("/scene/point", json=MIDDLE), 409, "no-such-view")
    landmarks = system.graph.channel("landmarks")
    async with looking(url) as viewer:
        await viewer.connection.send(pack(BESIDE))
        await viewer.until(("GridMessage", "/odom/floor"))
        now = system.clock.now()
        poster = Landmark("tour:arm", (3.0, 2.0, 1.2), 0.02, 3, now, now, id=7)
        landmarks.publish(Landmarks(now, (poster,)))
        for late_s in (-0.1, 0.0, 0.1):
            body.emit("odometry", Odometry(now + late_s, Pose2(1.0, 1.0, 0.0), 0.0, 0.0))
        # 2 m ahead of a camera that stands at (1, 2) of odometry: the stage lies on the robot.
        assert await drawn(client, "poster") == ScenePoint("poster", "odom", 3.0, 2.0, 1.2, "tour:arm", 7)

        system.graph.channel("localization").publish(localization(now, Pose2(5.0, 0.0, math.pi / 2)))
        on_map = dataclasses.replace(poster, p_FQ=(3.0, 3.0, 1.2))
        landmarks.publish(Landmarks(now, (on_map,), "map"))
        assert await drawn(client, "poster", "map") == ScenePoint("poster", "map", 3.0, 3.0, 1.2, "tour:arm", 7)

        landmarks.publish(Landmarks(now, (), "map"))
        assert await drawn(client, "nothing") == ScenePoint("nothing", "odom", None, None, None, None, None)
        low = answered(await client.post("/scene/point", json=MIDDLE | {"v": 1.0}), ScenePoint)
        # Half of the camera's 1 rad down: 1.2 m / tan(0.5) ahead of it, on the map along its y.
        ahead = 1.2 / math.tan(0.5)
        assert (low.kind, low.frame, low.z) == ("floor", "map", 0.0)
        assert (low.x, low.y) == (pytest.approx(5.0 - 2.0, abs=2e-3), pytest.approx(1.0 + ahead, abs=2e-3))
        is_problem(await client.post("/scene/point", json=MIDDLE | {"u": 1.1}), 422, "invalid-request")


async def test_a_view_that_has_no_scene_yet_shows_nothing(url: str, client: httpx.AsyncClient) -> None:
    pulse = f"{url.replace('http', 'ws')}/viser/pulse?viewer=abc"
    async with websockets.connect(pulse, proxy=None, close_timeout=1):
        async with asyncio.timeout(PATIENCE_S):
            is_problem(await client.post("/scene/point", json=MIDDLE), 409, "no-such-view")
