"""A robot in a real ROS 2 process for tests, and a link to it, in a graph that nothing else is in."""

from __future__ import annotations

import asyncio
import importlib.util
import os
import subprocess
import sys
import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from app.base import paths
from app.base.child_processes import python
from app.messages import LinkStatus, Odometry, Twist
from app.robots.ros2.config import Ros2Config, load_ros2_config
from app.robots.ros2.link import Ros2Link
from app.runtime.clock import RealClock
from tests.patience import PATIENCE_S
from tests.robots.simulated.kinematic.rooms import kept

MAPPING = paths.config_dir() / "robots" / "turtlebot4.yaml"
needs_ros2 = pytest.mark.skipif(
    importlib.util.find_spec("rclpy") is None, reason="ROS 2 is not installed: pip install 'hbba[ros2]'"
)


def domain() -> int:
    """A domain of this worker's own, of those whose ports no other program is given."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
    return 1 + (zlib.crc32(str(paths.config_dir()).encode()) + 7 * int(worker)) % 100


def mapping(file: Path = MAPPING, **graph: Any) -> Ros2Config:
    """The mapping of ``file``, by default as shipped, in the domain of this worker and on this computer alone."""
    config = load_ros2_config(file)
    wanted = {"domain": domain(), "discovery": "localhost", "found_within_s": PATIENCE_S} | graph
    return config.model_copy(update={"graph": config.graph.model_copy(update=wanted)})


@dataclass(frozen=True, slots=True)
class Row:
    """What a robot did in one step: its true velocity."""

    monotonic_s: float
    linear_mps: float
    angular_radps: float

    @property
    def still(self) -> bool:
        return self.linear_mps == 0.0 and self.angular_radps == 0.0


class Robot:
    """A robot in a process of its own, which keeps a log of its true velocity."""

    def __init__(self, folder: Path, *options: str, file: Path = MAPPING, body: Path | None = None) -> None:
        """The robot of the mapping ``file``, in a room, or as the simulated ``body`` in its world."""
        log = folder / "robot.log"
        where = ("--map", str(kept(folder))) if body is None else ("--body", str(body))
        command = python(
            *("-m", "app.robots.simulated.ros2_player", "--robot", str(file), *where),
            *("--log", str(log), "--domain", str(domain()), *options),
        )
        around = os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=around, cwd=paths.config_dir().parent
        )
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"
        self._log = log.open(encoding="utf-8")
        self._rows: list[Row] = []
        self._begun = ""

    def fault(self, line: str) -> None:
        """Have it go wrong."""
        assert self.process.stdin is not None
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def rows(self) -> list[Row]:
        """All that it did."""
        *lines, self._begun = (self._begun + self._log.read()).split("\n")
        self._rows += [Row(*map(float, line.split())) for line in lines]
        return self._rows

    def wait_for(self, what: str, found: Callable[[list[Row]], bool]) -> None:
        """Look into its log until ``found(rows)``."""
        deadline = time.monotonic() + PATIENCE_S
        while not found(self.rows()):
            assert time.monotonic() < deadline, f"never saw {what}"
            time.sleep(0.05)

    def close(self) -> None:
        """End it, whatever state it is in."""
        self.process.kill()
        self.process.wait()
        for file in (self.process.stdin, self.process.stdout, self._log):
            assert file is not None
            file.close()


class Driver:
    """A link whose messages are kept, and that is commanded as behaviors would, twenty times a second."""

    def __init__(self, config: Ros2Config) -> None:
        self.clock = RealClock()
        self.link = Ros2Link(config, self.clock.offset)
        self.newest: dict[str, Any] = {}
        self.velocity = (0.0, 0.0)
        self.commands = True
        self._changed = asyncio.Event()
        self._driving: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Driver:
        for stream in self.link.description.streams:
            self.link.attach(stream, self._keep(stream))
            self.link.demand(stream, 100.0)
        await self.link.start()
        self._driving = asyncio.create_task(self._drive())
        return self

    async def __aexit__(self, *_: object) -> None:
        if self._driving is not None:
            self._driving.cancel()
        await self.link.stop()

    async def wait_for(self, what: str, found: Callable[[dict[str, Any]], bool]) -> None:
        """Wait until ``found(newest messages by stream)``."""
        try:
            async with asyncio.timeout(PATIENCE_S):
                while not found(self.newest):
                    self._changed.clear()
                    await self._changed.wait()
        except TimeoutError:
            raise AssertionError(f"never saw {what}; the link: {self.newest.get('status')}") from None

    async def set_out(self) -> None:
        """Drive until odometry says so."""
        self.velocity, self.commands = (0.2, 0.3), True
        self.newest.pop("odometry", None)
        await self.wait_for("driving", lambda seen: "odometry" in seen and seen["odometry"].linear_mps > 0.1)

    async def stopped_for(self, *reasons: str) -> LinkStatus:
        """The first status that stops the base and has all of ``reasons`` in its reason."""
        found: list[LinkStatus] = []

        def stopped(seen: dict[str, Any]) -> bool:
            status: LinkStatus | None = seen.get("status")
            if status is None or not all(part in status.reason for part in reasons):
                return False
            found.append(status)
            return True

        await self.wait_for(f"a stop for {reasons}", stopped)
        status = found[0]
        assert status.applied == replace(Twist(status.stamp, 0.0, 0.0), stamp=status.applied.stamp)
        return status

    def _keep(self, stream: str) -> Callable[[Any], None]:
        def keep(message: Any) -> None:
            self.newest[stream] = message
            self._changed.set()

        return keep

    async def _drive(self) -> None:
        while True:
            if self.commands:
                self.link.command(Twist(self.clock.now(), *self.velocity))
            await asyncio.sleep(0.05)


def odometry(seen: dict[str, Any]) -> Odometry:
    """The newest odometry."""
    found: Odometry = seen["odometry"]
    return found


if __name__ == "__main__":  # a program that drives, to be frozen and killed

    async def main(number: int) -> None:
        """Drive for as long as it is let."""
        async with Driver(mapping(domain=number)) as driver:
            await driver.set_out()
            print("driving", driver.link.process_id, flush=True)
            await asyncio.Event().wait()

    asyncio.run(main(int(sys.argv[1])))
