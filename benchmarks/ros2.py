"""A robot over ROS 2, played in another process: how late its scans are, and what our process in the graph takes.

``late``: from the instant of a scan, by the robot's clock, until it is on our side of the link: the robot's publishing,
the middleware, the reading, and the way to the program. Both clocks are this computer's. ``CPU``: of the process with
rclpy, guard and node, per cent of one core, with scans 10 times, odometry 20 times and joints 10 times a second, and
commands 50 times. It needs rclpy; where it is not, the environment of the tests (``.venv/ros2``) is used.
"""

from __future__ import annotations

import asyncio
import importlib.util
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from app.robots.ros2.link import Ros2Link
from app.runtime.clock import RealClock
from benchmarks.report import Row, benchmark_main, row
from tests.robots.ros2.robot import Robot, mapping

BENCHMARK = "ros2"
ROOT = Path(__file__).resolve().parent.parent
_FIRST = 10
"""So many scans are left out: they are late, for the subscription has just been made."""
WITH_ROS = ROOT / ".venv" / "ros2" / "bin" / "python"


async def listen(seconds: float) -> tuple[list[float], float]:
    """How late scans were (ms), and the CPU (per cent of one core), over ``seconds``."""
    clock = RealClock()
    link = Ros2Link(mapping(), clock.offset)
    late_ms: list[float] = []
    comes = asyncio.Event()

    def take(scan: Any) -> None:
        late_ms.append(1e3 * (clock.now() - scan.stamp))
        if len(late_ms) == _FIRST:
            comes.set()

    link.attach("hokuyo", take)
    link.demand("hokuyo", 10.0)
    await link.start()
    try:
        process = psutil.Process(link.process_id)
        await comes.wait()
        late_ms.clear()
        began, before = clock.now(), process.cpu_times()
        await asyncio.sleep(seconds)
        after, lasted = process.cpu_times(), clock.now() - began
    finally:
        await link.stop()
    used = after.user + after.system - before.user - before.system
    return late_ms, 100.0 * used / lasted


def measure(quick: bool) -> list[Row]:
    """Listen for a minute, or ten seconds if ``quick``."""
    with tempfile.TemporaryDirectory() as folder:
        robot = Robot(Path(folder))
        try:
            late_ms, cpu = asyncio.run(listen(10.0 if quick else 60.0))
        finally:
            robot.close()
    case = "scan to channel"
    return [
        row(BENCHMARK, case, "late", "ms", late_ms),
        row(BENCHMARK, case, "late, 95 %", "ms", [float(np.percentile(late_ms, 95))]),
        row(BENCHMARK, case, "late, 99 %", "ms", [float(np.percentile(late_ms, 99))]),
        row(BENCHMARK, "process with rclpy and guard", "CPU", "% of a core", [cpu]),
    ]


def main() -> int:
    """Measure, here or in the environment that has ROS 2."""
    if importlib.util.find_spec("rclpy") is not None:
        return benchmark_main(__doc__, measure)
    if not WITH_ROS.is_file():
        print("ROS 2 is not here: make test makes .venv/ros2, or pip install 'hbba[ros2]'", file=sys.stderr)
        return 1
    return subprocess.run([str(WITH_ROS), "-m", "benchmarks.ros2", *sys.argv[1:]], cwd=ROOT, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
