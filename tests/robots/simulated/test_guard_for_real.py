"""The guard against real faults: a program that drives and swings head and arm is killed, frozen and stuck, and what
wheels, head and arm are given is watched.

The guard's own log, written by the link's process at each decision, is the witness.
"""

from __future__ import annotations

import functools
import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import psutil
import pytest

from app.robots.simulated.guard_log import GuardRow, read_guard_log
from tests.patience import PATIENCE_S

PROGRAM = Path(__file__).with_name("driving_program.py")
LIMIT_S = 0.250
#: How fast the guard lets the wheels become (m/s2, of IRL-1), and by what the rows may differ.
RAMP_MPS2 = 0.4
ALLOWANCE_MPS = 0.03
#: The joints that swing, by their place among the set-points: greatest speed (rad/s) and acceleration (rad/s2).
SWINGING = {0: (1.05, 5.8), 2: (1.5, 4.0)}
#: Longest time that they take to brake.
BRAKES_S = max(speed / acceleration for speed, acceleration in SWINGING.values())

pytestmark = pytest.mark.slow


class Driver:
    """A running driving program."""

    def __init__(self, guard_log: Path, *arguments: str) -> None:
        self.guard_log = guard_log
        self.process = subprocess.Popen(
            [sys.executable, str(PROGRAM), str(guard_log), *arguments], stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        self.link_id = int(self.process.stdout.readline())
        self.link = psutil.Process(self.link_id)

    def read_time(self) -> float:
        assert self.process.stdout is not None
        return float(self.process.stdout.readline())

    def rows(self) -> list[GuardRow]:
        return read_guard_log(self.guard_log)

    def wait_for(self, what: str, found: object) -> None:
        """Look into the guard's log until ``found(rows)``."""
        assert callable(found)
        deadline = time.monotonic() + PATIENCE_S
        while not found(self.rows()):
            assert time.monotonic() < deadline, f"never saw {what}"
            time.sleep(0.01)

    def wait_driving(self) -> None:
        self.wait_for("the wheels turning", lambda rows: rows and rows[-1].linear_mps > 0.15)
        for joint in SWINGING:
            self.wait_for(f"joint {joint} turning", functools.partial(_swings, joint))

    def assert_stops(self, fault_s: float) -> None:
        """Nothing but zeros is given to the wheels from ``LIMIT_S`` after the fault on, and head and arm brake from
        then on and are held; or the link has gone by then.

        A computer so busy that the guard decides late gives wheels and joints nothing in between.
        """
        limit_s = fault_s + LIMIT_S
        held_s = limit_s + BRAKES_S
        self.wait_for(
            "a decision after the limit",
            lambda rows: rows[-1].monotonic_s > held_s + 0.2 or not psutil.pid_exists(self.link_id),
        )
        rows = self.rows()
        assert _is_zero(rows[-1])
        assert all(_is_zero(row) for row in rows if row.monotonic_s > limit_s)
        after = [row.setpoints for row in rows if row.monotonic_s > limit_s]
        for joint, (speed, acceleration) in SWINGING.items():
            assert _swing(row.setpoints[joint] for row in rows if row.monotonic_s <= fault_s) > 0.02, "it was moving"
            if after:
                # A decision or two before the first one after the limit lie in the same stretch of time.
                assert abs(after[-1][joint] - after[0][joint]) <= speed**2 / (2 * acceleration) + 0.02
        held = {row.setpoints for row in rows if row.monotonic_s > held_s + 0.1}
        assert len(held) <= 1, "head and arm are held"

    def close(self) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()


def _swing(positions: Iterable[float]) -> float:
    known = list(positions)
    return max(known) - min(known)


def _swings(joint: int, rows: list[GuardRow]) -> bool:
    return bool(rows) and _swing(row.setpoints[joint] for row in rows) > 0.1


def _is_zero(row: GuardRow) -> bool:
    return row.linear_mps == 0.0 and row.angular_radps == 0.0


@pytest.fixture
def driver(tmp_path: Path) -> Iterator[Driver]:
    driver = Driver(tmp_path / "guard.log")
    yield driver
    driver.close()


def test_the_guard_decides_at_100_hz_or_more_and_stops_when_the_program_is_killed(driver: Driver) -> None:
    driver.wait_driving()
    began = time.monotonic()
    driver.wait_for("a second of decisions", lambda rows: rows[-1].monotonic_s > began + 1.0)
    times = [row.monotonic_s for row in driver.rows() if row.monotonic_s > began]
    gaps = [later - earlier for earlier, later in itertools.pairwise(times)]
    # A busy computer may keep it waiting between some decisions, not between all.
    assert np.percentile(gaps, 10) < 0.01
    fault = time.monotonic()
    os.kill(driver.process.pid, signal.SIGKILL)
    driver.process.wait()
    driver.assert_stops(fault)
    driver.link.wait(timeout=PATIENCE_S)  # and the link has gone by itself


def test_program_frozen_and_thawed(driver: Driver) -> None:
    driver.wait_driving()
    fault = time.monotonic()
    os.kill(driver.process.pid, signal.SIGSTOP)
    try:
        driver.assert_stops(fault)
        driver.wait_for("a second of standing", lambda rows: rows[-1].monotonic_s > fault + 1.0)
        assert driver.link.is_running()
        assert all(_is_zero(row) for row in driver.rows() if row.monotonic_s > fault + LIMIT_S)
    finally:
        os.kill(driver.process.pid, signal.SIGCONT)
    thawed = time.monotonic()
    driver.wait_for("driving again", lambda rows: rows[-1].linear_mps > 0.02)
    # what was commanded before the freeze must not move the wheels now: they ramp up from zero
    for row in driver.rows():
        if row.monotonic_s > thawed:
            assert row.linear_mps < RAMP_MPS2 * (row.monotonic_s - thawed) + ALLOWANCE_MPS


def test_program_stuck_in_a_c_call(tmp_path: Path) -> None:
    driver = Driver(tmp_path / "guard.log", "regex")
    try:
        fault = driver.read_time()
        driver.assert_stops(fault)
        assert driver.process.poll() is None
        assert max(row.linear_mps for row in driver.rows()) > 0.15
    finally:
        driver.close()
    driver.link.wait(timeout=PATIENCE_S)
