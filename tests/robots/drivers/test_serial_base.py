"""The driver of a base against the reference firmware's bytes, step by step, without a port."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.messages import BatteryState, JointState, Odometry
from app.robots.drivers import base_protocol as protocol
from app.robots.drivers.base_firmware import BaseFirmware, FirmwareSetting
from app.robots.drivers.base_protocol import Fault, Identity
from app.robots.drivers.device import DeviceLost, WrongDevice
from app.robots.drivers.serial_base import BaseSetting, SerialBase
from app.robots.drivers.wheel_counts import WheelGeometry, WheelPath, followed, restarted
from app.robots.guard import BaseVelocity
from app.robots.simulated.kinematic.base import moved

STEP_S = 0.01


class Bench:
    """A driver and a board on one line, with wheels that turn as they are asked to."""

    def __init__(self, **setting: Any) -> None:
        self.now = 500.0
        self.board = BaseFirmware(FirmwareSetting(), boot=1)
        self.driver = SerialBase("base", BaseSetting(0.2, wheels=("l", "r"), wheel_radius_m=0.05, **setting))
        self.driver.opened(self.now)
        self.pose = Pose2()
        self.newest: dict[str, Any] = {}
        self.hears = self.speaks = self.commanded = True

    def run(self, seconds: float) -> None:
        """Let time pass; the driver is due every other step."""
        for number in range(round(seconds / STEP_S)):
            self.now += STEP_S
            self.driver.due = self.commanded and number % 2 == 0
            outgoing, _ = self.driver.step(self.now)
            if self.hears:
                self.board.receive(outgoing)
            self.board.step(STEP_S)
            left, right = self.board.wheels_mps
            track_m = self.board.setting.track_m
            self.pose = moved(self.pose, BaseVelocity((left + right) / 2, (right - left) / track_m), STEP_S)
            self.board.rolled(left * STEP_S, right * STEP_S)
            data = self.board.outgoing()
            if self.speaks:
                self.newest |= dict(self.driver.received(data, self.now))

    def drive(self, linear: float, angular: float = 0.0) -> None:
        self.driver.velocity, self.driver.brake = BaseVelocity(linear, angular), False

    @property
    def odometry(self) -> Odometry:
        found: Odometry = self.newest["odometry"]
        return found

    @property
    def off_m(self) -> float:
        """How far odometry is from the truth."""
        return math.hypot(self.odometry.X_OB.x - self.pose.x, self.odometry.X_OB.y - self.pose.y)


def test_it_drives_and_its_odometry_is_where_it_is() -> None:
    bench = Bench()
    bench.run(0.5)
    bench.drive(0.4, 0.5)
    bench.run(4.0)
    assert bench.pose.y > 0.5
    assert bench.off_m < 0.01
    assert bench.odometry.linear_mps == pytest.approx(0.4, abs=0.01)
    assert bench.odometry.angular_radps == pytest.approx(0.5, abs=0.02)
    assert bench.odometry.stamp == pytest.approx(bench.now, abs=0.03)
    assert bench.driver.problem(bench.now) == ""
    joints: JointState = bench.newest["joints"]
    assert joints.names == ("l", "r")
    assert joints.positions[1] > joints.positions[0] > 20.0
    battery: BatteryState = bench.newest["battery"]
    assert (battery.charge, battery.voltage_v, battery.charging) == (0.9, 12.44, False)


def test_without_a_command_it_stops_by_itself_within_its_time_out() -> None:
    bench = Bench()
    bench.drive(0.5)
    bench.run(2.0)
    bench.hears = False
    bench.run(0.2 + 0.5 / bench.board.setting.brake_mps2 + 2 * STEP_S)
    assert bench.board.wheels_mps == (0.0, 0.0)
    assert Fault.SILENT in bench.board.faults
    bench.run(0.2)
    assert bench.driver.problem(bench.now) == "it does not take the commands that it is sent"
    bench.hears = True
    bench.run(0.3)
    assert bench.driver.problem(bench.now) == ""
    assert bench.board.wheels_mps[0] > 0.1


def test_a_brake_is_harder_than_the_ramp() -> None:
    stops = []
    for brake in (False, True):
        bench = Bench()
        bench.board.setting = FirmwareSetting(ramp_mps2=0.5)
        bench.drive(0.5)
        bench.run(2.0)
        bench.driver.velocity, bench.driver.brake = BaseVelocity(), brake
        at = bench.pose.x
        bench.run(2.0)
        assert bench.board.wheels_mps == (0.0, 0.0)
        stops.append(bench.pose.x - at)
    assert stops[1] < stops[0] / 3


@pytest.mark.parametrize("fault", [*protocol.WORDS])
def test_its_faults_are_said_and_stop_it(fault: Fault) -> None:
    bench = Bench()
    bench.drive(0.3)
    bench.run(1.0)
    bench.board.faults |= fault
    bench.run(0.5)
    words = protocol.WORDS[fault]
    stops = bool(fault & protocol.STOPPING)
    assert bench.driver.problem(bench.now) == (words if stops else "")
    assert (bench.board.wheels_mps == (0.0, 0.0)) == stops
    assert bench.driver.cautions == [f"{words}: it has stopped" if stops else words]


def test_a_gap_loses_no_way_and_a_reset_jumps_nowhere() -> None:
    bench = Bench()
    bench.drive(0.4)
    bench.run(2.0)
    # The cable is out while it rolls to a stand.
    bench.speaks = bench.hears = False
    bench.run(0.9)
    list(bench.driver.closed(bench.now))
    bench.driver.opened(bench.now)
    bench.speaks = bench.hears = True
    bench.run(1.0)
    assert bench.off_m < 0.01
    assert bench.driver.cautions == []
    # Its power is out: another run of it, whose counts begin at 0.
    before = bench.odometry.X_OB
    bench.board = BaseFirmware(FirmwareSetting(), boot=2)
    bench.board.rolled(3.0, 3.0)
    bench.driver.velocity = BaseVelocity()
    bench.run(0.5)
    assert before == bench.odometry.X_OB
    assert bench.driver.cautions == ["it began again: what its wheels did meanwhile is not known"]


def test_counts_that_jump_leave_the_base_where_it_is() -> None:
    bench = Bench()
    bench.run(0.5)
    bench.board.rolled(5.0, 5.0)
    bench.run(0.5)
    assert Pose2() == bench.odometry.X_OB
    assert bench.driver.cautions == ["its counts jumped: what its wheels did meanwhile is not known"]


def test_measured_sizes_replace_its_own() -> None:
    bench = Bench(ticks_per_m=10000.0, track_m=0.6)
    bench.drive(0.2)
    bench.run(2.0)
    assert bench.odometry.X_OB.x == pytest.approx(2 * bench.pose.x, rel=0.05)


def test_a_silent_base_is_lost_and_what_another_device_says_is_named() -> None:
    bench = Bench()
    bench.run(0.5)
    bench.speaks = False
    with pytest.raises(DeviceLost, match="said nothing for 1 s"):
        bench.run(1.5)
    bench.driver.opened(bench.now)
    bench.driver.received(b"$GPGGA,12", bench.now)
    with pytest.raises(WrongDevice, match=r"no base answers \(docs/serial-base.md\): it said b'\$GPGGA,12'"):
        bench.run(5.0)


def test_another_version_is_refused_by_name() -> None:
    bench = Bench()
    identity = protocol.encode(Identity(9, 1, 1, 1, ticks_per_m=1, track_um=1, name="new"), 1)
    with pytest.raises(WrongDevice, match="'new' speaks version 9 of the protocol; this program 1"):
        bench.driver.received(identity, bench.now)


def test_damaged_frames_are_said_once() -> None:
    bench = Bench()
    bench.run(0.5)
    for _ in range(3):
        bench.driver.received(b"\x02\x02\x00", bench.now)
    assert bench.driver.cautions == ["frames with a wrong CRC are dropped: look at its cable"]


GEOMETRY = WheelGeometry(ticks_per_m=10000.0, track_m=0.3, most_mps=1.0)


@given(
    st.lists(st.tuples(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1)), min_size=1, max_size=30),
    st.integers(-(2**31), 2**31 - 1),
)
def test_counters_that_run_over_go_on(ways: list[tuple[float, float]], begin: int) -> None:
    """The path is the same wherever the counters began."""

    def path(at: int) -> WheelPath:
        found, left, right = restarted(WheelPath(Pose2()), at, at, 0.0), at, at
        for number, (left_m, right_m) in enumerate(ways, 1):
            left, right = (
                (count + round(way * 10000) + 2**31) % 2**32 - 2**31
                for count, way in ((left, left_m), (right, right_m))
            )
            step = followed(found, GEOMETRY, left=left, right=right, stamp=0.2 * number)
            assert step is not None
            found = step
        return found

    assert path(begin).pose == path(0).pose
