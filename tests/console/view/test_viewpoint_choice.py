"""A viewer's choice of a viewpoint, from its pulse to its camera, and what the page learns of where the camera is."""

from __future__ import annotations

import asyncio
import dataclasses
import json
import math
from typing import Any

import numpy as np
import pytest
import websockets

from app.base.geometry import Pose2
from app.console.view.viewpoints import Anchors, Shot, between, shot, shot_of
from app.messages import Odometry
from app.program.system import System
from tests.console.program import Body
from tests.console.view.test_relay import CAMERA, Viewer, looking, pack
from tests.patience import PATIENCE_S

pytestmark = pytest.mark.filterwarnings("default::DeprecationWarning")


async def camera_said(pulse: websockets.ClientConnection, **wanted: Any) -> dict[str, Any]:
    """Read the pulse until it says this of the camera."""
    while True:
        frame = str(await pulse.recv())
        if frame.startswith("{"):
            said: dict[str, Any] = json.loads(frame)
            if all(said[key] == value for key, value in wanted.items()):
                return said


def last(viewer: Viewer, kind: str) -> tuple[float, ...]:
    said = [message for message in viewer.seen if message["type"] == kind]
    return tuple(said[-1]["position" if "Position" in kind else "look_at"])


async def glided_to(viewer: Viewer, end: Shot) -> None:
    """Read until the camera was sent to ``end``."""
    while True:
        await viewer.until(("SetCameraLookAtMessage", None))
        there = math.dist(last(viewer, "SetCameraPositionMessage"), end.eye) < 1e-6
        if there and math.dist(last(viewer, "SetCameraLookAtMessage"), end.target) < 1e-6:
            return


async def test_a_choice_glides_there_and_arrives_when_the_browser_says_so(url: str, system: System, body: Body) -> None:
    pulse_address = f"{url.replace('http', 'ws')}/viser/pulse?viewer=abc"
    async with (
        looking(url) as viewer,
        websockets.connect(pulse_address, proxy=None, close_timeout=1) as pulse,
        asyncio.timeout(PATIENCE_S),
    ):
        await viewer.until(("PointCloudMessage", "/odom/cloud"))
        now = system.clock.now()
        for late_s in (-0.1, 0.0, 0.1):
            body.emit("odometry", Odometry(now + late_s, Pose2(1.0, 2.0, 0.5), 0.0, 0.0))
        await pulse.send(json.dumps({"type": "viewpoint", "viewpoint": "top", "number": 1}))
        end = shot("top", Anchors())
        await glided_to(viewer, end)
        assert (await camera_said(pulse, viewpoint="top", number=1))["arrived"] is False
        there = dataclasses.replace(CAMERA, position=end.eye, look_at=end.target, fov=end.fov)
        await viewer.connection.send(pack(there))
        said = await camera_said(pulse, viewpoint="top", arrived=True)
        assert said["bearing"] == pytest.approx(0.0, abs=1e-3)

        # From the free view, turned with neither: the base turns in the stage, the world does not.
        await pulse.send(json.dumps({"type": "viewpoint", "viewpoint": "free", "number": 2}))
        await glided_to(viewer, shot("free", Anchors()))
        viewer.seen.clear()
        body.emit("odometry", Odometry(system.clock.now() + 0.2, Pose2(1.0, 2.0, 1.5), 0.0, 0.0))
        await viewer.until(("SetOrientationMessage", "/base_link"))
        assert not [m for m in viewer.seen if m["type"] == "SetOrientationMessage" and m["name"] == "/odom"]


async def test_the_pulse_says_of_when_the_robot_is_that_was_drawn(url: str, system: System, body: Body) -> None:
    pulse_address = f"{url.replace('http', 'ws')}/viser/pulse?viewer=abc"
    async with (
        looking(url) as viewer,
        websockets.connect(pulse_address, proxy=None, close_timeout=1) as pulse,
        asyncio.timeout(PATIENCE_S),
    ):
        await viewer.until(("PointCloudMessage", "/odom/cloud"))
        stamp = system.clock.now() + 0.5
        body.emit("odometry", Odometry(stamp, Pose2(1.0, 2.0, 0.5), 0.0, 0.0))
        said = 0.0
        # What waited for room on its way is taken off: it was drawn that much before.
        while not stamp - 0.2 < said <= stamp + 1e-3:
            number, _, of = str(await pulse.recv()).partition(" ")
            if number.isdecimal():
                await pulse.send(f"{number} 5.0")
                said = float(of or 0)


async def test_a_hand_on_the_camera_ends_a_glide(url: str) -> None:
    pulse_address = f"{url.replace('http', 'ws')}/viser/pulse?viewer=abc"
    async with (
        looking(url) as viewer,
        websockets.connect(pulse_address, proxy=None, close_timeout=1) as pulse,
        asyncio.timeout(PATIENCE_S),
    ):
        await viewer.until(("PointCloudMessage", "/odom/cloud"))
        # Both at once: the glide has no time to end before.
        await pulse.send(json.dumps({"type": "viewpoint", "viewpoint": "map", "number": 1}))
        await pulse.send(json.dumps({"type": "grab"}))
        await pulse.send(json.dumps({"type": "viewpoint", "viewpoint": "top", "number": 2}))
        await glided_to(viewer, shot("top", Anchors()))


async def test_the_soft_limit_of_a_viewer_is_drawn_for_it(url: str) -> None:
    pulse_address = f"{url.replace('http', 'ws')}/viser/pulse?viewer=abc"
    async with (
        looking(url) as viewer,
        websockets.connect(pulse_address, proxy=None, close_timeout=1) as pulse,
        asyncio.timeout(PATIENCE_S),
    ):
        await viewer.until(("PointCloudMessage", "/odom/cloud"))
        # Of these only the last is one.
        for angle in (-1.0, 4.0, "0.5", 0.5):
            await pulse.send(json.dumps({"type": "soft_limit", "angle": angle}))
        await viewer.until(("MeshMessage", "/base_link/soft_limit/surface"))
        await pulse.send(json.dumps({"type": "soft_limit", "angle": None}))
        await viewer.until(("SetSceneNodeVisibilityMessage", "/base_link/soft_limit/edge"))


async def test_a_glide_is_held_at_a_share_of_its_time_and_goes_on(url: str) -> None:
    pulse_address = f"{url.replace('http', 'ws')}/viser/pulse?viewer=abc"
    async with (
        looking(url) as viewer,
        websockets.connect(pulse_address, proxy=None, close_timeout=1) as pulse,
        asyncio.timeout(PATIENCE_S),
    ):
        await viewer.until(("PointCloudMessage", "/odom/cloud"))
        first = shot_of(np.array(CAMERA.position), np.array(CAMERA.look_at), CAMERA.fov)
        look = {"type": "viewpoint", "viewpoint": "top", "number": 1}
        await pulse.send(json.dumps(look | {"hold": 0.5}))
        await glided_to(viewer, between(first, shot("top", Anchors()), 0.5))
        assert (await camera_said(pulse, number=1))["arrived"] is False
        await pulse.send(json.dumps(look))
        await glided_to(viewer, shot("top", Anchors()))
