"""Points of the camera's picture over REST."""

from __future__ import annotations

import math
from functools import partial

import httpx
import numpy as np
import pytest

from app.base.geometry import CameraModel, Pose2, Pose3
from app.console.live.hub import Hub
from app.console.records.camera import CameraPoint
from app.messages import Image, Odometry, read_only
from app.program.system import System
from tests.console.answers import answered, is_problem
from tests.console.places import localization

CAMERA = CameraModel.from_vertical_fov(640, 480, math.radians(43))
#: Looks ahead, 1.2 m above the floor.
AHEAD = Pose3(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]), np.array([0.0, 0.0, 1.2]))


async def test_a_click_on_what_was_measured_is_a_point_on_the_map(
    client: httpx.AsyncClient, system: System, hub: Hub
) -> None:
    close = hub.look_here.open()
    stamp = system.clock.now()
    click = {"stamp": stamp, "u": 0.5, "v": 0.5}
    is_problem(await client.post("/camera/point", json=click), 409, "picture-too-old")
    system.graph.channel("odometry").publish(Odometry(stamp, Pose2(2.0, 0.0, 0.0), 0.0, 0.0))
    color, depth = np.zeros((480, 640, 3), np.uint8), np.full((480, 640), 1500, np.uint16)
    image = Image(stamp, "kinect", read_only(color), read_only(depth), CAMERA, AHEAD)
    system.graph.channel("kinect").publish(image)
    is_problem(await client.post("/camera/point", json=click), 409, "pose-unknown")
    system.graph.channel("localization").publish(localization(stamp, Pose2(1.0, 0.5, math.pi / 2)))
    point = answered(await client.post("/camera/point", json=click), CameraPoint)
    near = partial(pytest.approx, abs=0.01)
    # 3.5 m ahead of odometry's origin, which looks along y of the map.
    assert (point.x, point.y, point.z, point.measured) == (near(1.0), near(4.0), near(1.2), True)
    is_problem(await client.post("/camera/point", json=click | {"u": 1.5}), 422, "invalid-request")
    close()
