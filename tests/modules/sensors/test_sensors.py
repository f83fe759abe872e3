from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from app.base.geometry import CameraModel, Pose2, Pose3
from app.messages import Image, Imu, JointState, LaserScan, Odometry
from app.runtime.clock import run_virtual
from tests.modules.fakes import Bench, FakeLink, drain

KINECT = "app.modules.sensors.kinect:Kinect"
HOKUYO = "app.modules.sensors.hokuyo:Hokuyo"
INERTIAL = "app.modules.sensors.imu:InertialSensor"
ODOMETRY = "app.modules.sensors.wheel_odometry:WheelOdometry"

IMAGE = Image(
    1.0, "kinect_optical_frame", np.zeros((2, 2, 3), np.uint8), None, CameraModel(2, 2, 1, 1, 0, 0), Pose3.identity()
)
SCAN = LaserScan(
    1.0, "hokuyo_link", np.ones(3, np.float32), np.ones(3, np.float32), 0, 1, 0.1, 30, 0.01, Pose3.identity()
)

LAZY = [
    pytest.param(KINECT, "kinect", "images", Image, IMAGE, id="kinect"),
    pytest.param(HOKUYO, "hokuyo", "scans", LaserScan, SCAN, id="hokuyo"),
    pytest.param(INERTIAL, "imu", "imu", Imu, Imu(1.0, "imu_link", (0.0, 0.0, 0.1), (0.0, 0.0, 9.8)), id="imu"),
]


@pytest.mark.parametrize(("module", "stream", "port", "kind", "message"), LAZY)
def test_a_lazy_sensor_relays_and_asks_for_its_stream_only_while_it_is_wanted(
    module: str, stream: str, port: str, kind: type[Any], message: Any
) -> None:
    async def main() -> None:
        async with Bench(module, outputs={port: kind}) as b:
            assert b.link.demands[stream][-1] == 0
            received = b.listen(port)
            assert b.link.demands[stream][-1] == b.link.description.streams[stream].rate_hz
            b.link.emit(stream, message)
            assert drain(received) == [message]
            received.filter.divisor = math.inf
            assert b.link.demands[stream][-1] == 0
            received.filter.divisor = 4
            assert b.link.demands[stream][-1] == b.link.description.streams[stream].rate_hz / 4
        assert b.link.demands[stream][-1] == 0
        assert b.link.receivers[stream] == []
        asked = len(b.link.demands[stream])
        received.filter.divisor = math.inf
        assert len(b.link.demands[stream]) == asked, "a stopped sensor left its callback behind"

    run_virtual(main())


def test_of_a_stream_thinned_at_the_source_every_filter_gets_its_share() -> None:
    async def main() -> None:
        async with Bench(KINECT, outputs={"images": Image}) as b:
            each, every_other = b.listen("images"), b.listen("images")
            each.filter.divisor, every_other.filter.divisor = 4, 8
            assert b.link.demands["kinect"][-1] == b.link.description.streams["kinect"].rate_hz / 4
            for number in range(5):
                b.link.ended["kinect"] = 4 if number else 1
                b.link.emit("kinect", replace(IMAGE, stamp=float(number)))
            assert [image.stamp for image in drain(each)] == [0, 1, 2, 3, 4]
            assert [image.stamp for image in drain(every_other)] == [0, 2, 4]

    run_virtual(main())


def test_odometry_and_joints_are_relayed() -> None:
    odometry = Odometry(1.0, Pose2(1, 2, 3), 0.1, 0.2)
    joints = JointState(1.0, ("head_pan",), (0.5,))

    async def main() -> None:
        async with Bench(ODOMETRY, outputs={"odometry": Odometry, "joints": JointState}) as b:
            poses, angles = b.listen("odometry"), b.listen("joints")
            b.link.emit("odometry", odometry)
            b.link.emit("joints", joints)
            assert drain(poses) == [odometry]
            assert drain(angles) == [joints]

    run_virtual(main())


def test_a_body_without_the_stream_is_a_clear_failure() -> None:
    async def main() -> None:
        async with Bench(KINECT, outputs={"images": Image}, link=FakeLink(without=("kinect",))) as b:
            await b.settle()
            assert (
                "needs the stream 'kinect', which a test body does not have (it has: hokuyo, imu, joints" in b.problem
            )
            assert b.supervisor.states["Tested"].stale

    run_virtual(main())


def test_a_sensor_that_fails_half_way_into_its_start_lets_go_of_the_body() -> None:
    async def main() -> None:
        link = FakeLink(without=("joints",))
        async with Bench(ODOMETRY, outputs={"odometry": Odometry, "joints": JointState}, link=link) as b:
            await b.settle()
            assert "needs the stream 'joints'" in b.problem
            assert link.receivers["odometry"] == []
            # Several restarts later too.
            await b.clock.sleep(10.0)
            assert b.supervisor.states["Tested"].restarts >= 3
            assert link.receivers["odometry"] == []

    run_virtual(main())
