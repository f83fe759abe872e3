"""A click on the camera's picture: which point it is, and who may look there."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import CameraModel, Pose2, Pose3
from app.base.kinematic_model import load_model
from app.console.drive import drive_lease
from app.console.drive.command_age import Judgement
from app.console.drive.drive_controller import Driving
from app.console.drive.look_here import FAR_M, TOO_OLD, LookHere, Taken, clicked_point
from app.messages import Image, Odometry, read_only
from app.program.system import System
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.console.program import MODEL, Body, build

CAMERA = CameraModel.from_vertical_fov(640, 480, math.radians(43))


KINEMATICS = load_model(MODEL)


def looking(pan: float, tilt: float) -> Pose3:
    return KINEMATICS.pose("kinect_optical_frame", {"pan_joint": pan, "tilt_joint": tilt})


@given(st.floats(0, 1), st.floats(0, 1), st.floats(-2, 2), st.floats(-0.29, 0.4), st.floats(-3, 3))
def test_the_point_is_on_the_ray_of_the_click_above_the_floor_and_not_too_far(
    u: float, v: float, pan: float, tilt: float, theta: float
) -> None:
    X_OB, X_BC = Pose2(1.0, -2.0, theta).to_pose3(), looking(pan, tilt)
    found = clicked_point(Taken(0.0, CAMERA, X_BC, 640, 480), X_OB, u, v)
    point = np.array([found.x, found.y, found.z])
    assert not found.measured
    X_OC = X_OB @ X_BC
    assert CAMERA.project(X_OC.inverse().transform(point[None, :]))[0] == pytest.approx([640 * u, 480 * v], abs=1e-6)
    assert point[2] >= -1e-9
    assert np.linalg.norm(point - X_OC.translation) <= FAR_M + 1e-9


def test_where_the_camera_measured_something_that_is_the_point() -> None:
    depth = np.zeros((120, 160), np.uint16)
    depth[55:70, 100:110] = 2500
    depth[60, 105] = 9000  # a single cell that is wrong
    taken = Taken(0.0, CAMERA, looking(0.0, 0.0), 640, 480, depth)
    X_OB = Pose2(1.0, 2.0, 0.5).to_pose3()
    found = clicked_point(taken, X_OB, 105.5 / 160, 60.5 / 120)
    assert found.measured
    in_camera = (X_OB @ taken.X_BC).inverse().transform(np.array([[found.x, found.y, found.z]]))
    assert in_camera[0, 2] == pytest.approx(2.5)
    assert CAMERA.project(in_camera)[0] == pytest.approx([422, 242])
    assert not clicked_point(taken, X_OB, 0.1, 0.5).measured
    corner = clicked_point(taken, X_OB, 1.0, 1.0)
    assert not corner.measured


def test_a_click_is_of_its_own_picture_however_far_the_robot_has_turned_since(tmp_path: Path) -> None:
    system, _ = build(tmp_path)
    look_here = LookHere(system.graph, system.workspace, "camera_jpeg")
    close = look_here.open()
    first, second = 100.0, 100.5
    for stamp, theta in ((99.9, 0.0), (first, 0.0), (second, 1.0), (second + 0.1, 1.0)):
        system.graph.channel("odometry").publish(Odometry(stamp, Pose2(0.0, 0.0, theta), 0.0, 0.0))
    for stamp in (first, second):
        color = read_only(np.zeros((480, 640, 3), np.uint8))
        system.graph.channel("kinect").publish(Image(stamp, "kinect", color, None, CAMERA, looking(0.0, 0.0)))
    assert look_here.look("Ann", first, 0.5, 0.5) == ""
    (desire,) = system.workspace.desires()
    assert (desire.cls, desire.source.name, desire.params["frame"]) == ("LookAt", "Ann", "odom")
    assert desire.params["x"] == pytest.approx(FAR_M, abs=0.2)
    assert look_here.look("Ann", second, 0.5, 0.5) == ""
    (desire,) = system.workspace.desires()
    assert math.atan2(desire.params["y"], desire.params["x"]) == pytest.approx(1.0, abs=0.02)
    assert look_here.look("Ann", 7.0, 0.5, 0.5) == TOO_OLD
    look_here.withdraw()
    assert system.workspace.desires() == ()
    close()


class Pages:
    """Ann's and Bob's pages before a picture that may be clicked."""

    def __init__(self, system: System, body: Body) -> None:
        self.notices: list[tuple[str, str]] = []
        self.system = system
        self.stamp = system.clock.now()
        look_here = LookHere(system.graph, system.workspace, "camera_jpeg")
        look_here.open()
        channel = system.graph.channel("teleop_command")
        self.driving = Driving(system.clock, body, channel, self._notify, lambda: None, look_here=look_here)
        for session, name in (("a", "Ann"), ("b", "Bob")):
            self.driving.handle(drive_lease.Connected(session, name))
        system.graph.channel("odometry").publish(Odometry(self.stamp, Pose2(), 0.0, 0.0))
        color = read_only(np.zeros((480, 640, 3), np.uint8))
        image = Image(self.stamp, "kinect", color, None, CAMERA, looking(0.0, 0.0))
        system.graph.channel("kinect").publish(image)

    def _notify(self, session: str, level: Literal["info", "warning", "error"], text: str) -> None:
        self.notices.append((session, text))

    def click(self, session: str, judged: Judgement, u: float = 0.5) -> str:
        """The notice that answers it, "" without one."""
        before = len(self.notices)
        self.driving.look(session, judged, stamp=self.stamp, u=u, v=0.5)
        return self.notices[-1][1] if len(self.notices) > before else ""

    @property
    def looks(self) -> int:
        return len(self.system.workspace.desires())


def test_the_head_goes_with_the_wheel(tmp_path: Path) -> None:
    built = build(tmp_path, clock=VirtualClock())

    @in_virtual_time
    async def story() -> None:
        pages = Pages(*built)
        in_time = Judgement(age_s=0.05)
        assert pages.click("a", in_time) == ""
        assert pages.looks == 1
        hold = drive_lease.Drive("b", 1, False, 0.0, 0.0, head_held=True, pan=1.0)
        pages.driving.handle(hold)
        assert pages.looks == 0, "by hand it is turned elsewhere"
        assert pages.click("a", in_time).startswith("Bob drives; ask for the wheel first")
        assert pages.click("b", Judgement("Commands arrive up to 3.0 s late")) == (
            "Commands arrive up to 3.0 s late: the head stays."
        )
        assert "from 0 to 1" in pages.click("b", in_time, math.nan)
        pages.driving.handle(drive_lease.EmergencyStop(True))
        assert pages.click("b", in_time).startswith("The emergency stop is latched")
        assert pages.looks == 0

    story()
