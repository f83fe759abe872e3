"""The driver of a Hokuyo laser against the laser's own bytes, step by step, without a port."""

from __future__ import annotations

import numpy as np
import pytest

from app.base.geometry import Pose3
from app.messages import LaserScan
from app.robots.drivers.device import DeviceLost, WrongDevice
from app.robots.drivers.hokuyo import Hokuyo, LaserSetting
from app.robots.simulated.parts.hokuyo_laser import HokuyoLaser

HERE = Pose3(np.eye(3), np.zeros(3))
#: The laser's clock began when the robot's was here (s).
BEGAN = 1000.0


class Bench:
    """A driver and a laser on one line; time passes as the test says."""

    def __init__(self, setting: LaserSetting | None = None, *, wanted: bool = True) -> None:
        self.now = BEGAN
        self.laser = HokuyoLaser()
        self.driver = Hokuyo("hokuyo", setting or LaserSetting("hokuyo_link"), HERE)
        self.driver.wanted = wanted
        self.driver.opened(self.now)
        self.scans: list[LaserScan] = []
        self.sent: list[bytes] = []

    def run(self, seconds: float, *, sweep: bool = True, delay_s: float = 0.0, answers: bool = True) -> None:
        """Let time pass in steps of 25 ms, the time of a sweep; bytes arrive ``delay_s`` late."""
        for _ in range(round(seconds / 0.025)):
            self.now += 0.025
            outgoing, _ = self.driver.step(self.now)
            self.sent += [outgoing] if outgoing else []
            data = self.laser.receive(outgoing, self.now - BEGAN) if outgoing else b""
            data += self.laser.scan(self.now - BEGAN) if sweep else b""
            if answers and data:
                self.give(data, self.now + delay_s)

    def give(self, data: bytes, at: float | None = None) -> None:
        """Bytes come to the driver."""
        for stream, message in self.driver.received(data, self.now if at is None else at):
            assert stream == "hokuyo"
            assert isinstance(message, LaserScan)
            self.scans.append(message)


@pytest.mark.parametrize("characters", [2, 3])
def test_it_asks_and_lights_and_reads(characters: int) -> None:
    bench = Bench(LaserSetting("hokuyo_link", characters=characters))
    bench.laser.distances[:4] = (5, 20, 1234, 4000)
    bench.run(1.0)
    scan = bench.scans[-1]
    assert np.isnan(scan.ranges[0])  # below its least distance there are codes of errors
    assert scan.ranges[1:4].tolist() == pytest.approx([0.02, 1.234, 4.0])
    # Nothing within reach; two characters cannot say so.
    assert np.isinf(scan.ranges[4]) if characters == 3 else scan.ranges[4] == pytest.approx(4.095)
    assert scan.angle_min == pytest.approx(-np.radians(135))
    assert scan.angle_increment == pytest.approx(np.radians(0.25))
    assert scan.ranges.size == 1081
    assert (scan.range_min, scan.range_max, scan.frame) == (0.02, 30.0, "hokuyo_link")
    assert not scan.ranges.flags.writeable


def test_a_field_of_view_and_intensities() -> None:
    bench = Bench(LaserSetting("hokuyo_link", fov_rad=np.pi, intensities=True))
    bench.run(1.0)
    assert bench.scans[-1].ranges.size == 721
    assert bench.scans[-1].angle_min == pytest.approx(-np.pi / 2)
    assert set(bench.scans[-1].intensities) == {1000.0}


def test_stamps_are_of_the_first_ray_and_no_delay_is_taken_for_time() -> None:
    bench = Bench()
    bench.run(2.0)
    for _ in range(20):
        bench.run(0.025, delay_s=0.08)
    first, last = bench.scans[-21], bench.scans[-1]
    assert last.duration_s == pytest.approx(0.025 * 0.75)
    assert last.stamp == pytest.approx(bench.now - last.duration_s, abs=0.002)
    assert last.stamp - first.stamp == pytest.approx(20 * 0.025, abs=0.002)


def test_its_clock_runs_over() -> None:
    bench = Bench()
    bench.run(1.0)
    before = bench.scans[-1].stamp
    # 24 bits of milliseconds are 4.66 hours; the laser's own clock is moved to just before their end.
    hours = 2**24 / 1000 - (bench.now - BEGAN) - 0.1
    bench.now += hours
    bench.driver._last_scan = bench.now
    bench.run(0.5)
    assert bench.scans[-1].stamp - before == pytest.approx(hours + 0.5, abs=0.01)


def test_it_measures_only_while_it_is_wanted() -> None:
    bench = Bench(wanted=False)
    bench.run(1.0)
    assert not bench.laser.lit
    bench.driver.wanted = True
    bench.run(0.5)
    assert bench.scans
    bench.driver.wanted = False
    bench.run(0.2)
    assert not bench.laser.lit
    assert bench.sent[-1] == b"QT\n"
    bench.driver.wanted = True
    count = len(bench.scans)
    bench.run(0.5)
    assert len(bench.scans) > count


def test_a_laser_that_still_measures_for_an_earlier_program_is_silenced_first() -> None:
    bench = Bench()
    bench.laser.receive(b"MD0000010001000\n", 0.0)
    bench.run(1.0)
    assert bench.scans[-1].ranges.size == 1081
    assert {scan.ranges.size for scan in bench.scans} == {1081}


def test_damaged_scans_are_dropped_and_said_once() -> None:
    bench = Bench()
    bench.run(1.0)
    count = len(bench.scans)
    for _ in range(5):
        bench.now += 0.025
        data = bytearray(bench.laser.scan(bench.now - BEGAN))
        data[40] ^= 1
        bench.give(bytes(data))
    assert len(bench.scans) == count
    assert bench.driver.cautions == ["replies with a wrong sum are dropped: look at its cable"]
    bench.run(0.1)
    assert len(bench.scans) > count


def test_its_silence_has_the_port_opened_again() -> None:
    bench = Bench()
    bench.run(1.0)
    with pytest.raises(DeviceLost, match="no scan for 1 s"):
        bench.run(1.5, sweep=False)
    bench.driver.opened(bench.now)
    bench.scans.clear()
    bench.run(1.0)
    assert bench.scans


def test_a_laser_that_cannot_be_lit_says_why() -> None:
    bench = Bench()
    bench.laser.broken = "01"
    with pytest.raises(DeviceLost, match=r"refuses BM with status 01; it says of itself: no error\."):
        bench.run(1.0)


@pytest.mark.parametrize(
    ("said", "shown"), [(b"$GPGGA,12,34*00\r\n", r"it said b'\$GPGGA,12,34\*00"), (b"", "it said nothing")]
)
def test_another_device_is_named_by_what_it_says(said: bytes, shown: str) -> None:
    bench = Bench()
    bench.give(said) if said else None
    with pytest.raises(WrongDevice, match=rf"no Hokuyo laser \(SCIP 2\) answers: {shown}"):
        bench.run(3.0, answers=False)
