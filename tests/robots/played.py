"""Robots that are played in processes of their own, and links to them that are driven and watched."""

from __future__ import annotations

import asyncio
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from app.base import paths
from app.link import RobotLink
from app.messages import LinkStatus, Odometry, Twist
from app.runtime.clock import RealClock
from tests.patience import PATIENCE_S


@dataclass(frozen=True, slots=True)
class Row:
    """What a robot did in one step: its true velocity, and its pose where its log has it."""

    monotonic_s: float
    linear_mps: float
    angular_radps: float
    x: float = 0.0
    y: float = 0.0
    heading_deg: float = 0.0

    @property
    def still(self) -> bool:
        return self.linear_mps == 0.0 and self.angular_radps == 0.0


class PlayedRobot:
    """A robot in the process of ``command``, which keeps a log of its true velocity in ``log``."""

    def __init__(self, command: Sequence[str], log: Path, environment: Mapping[str, str]) -> None:
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment,
            cwd=paths.config_dir().parent,
        )  # fmt: skip
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

    def __init__(self, link: RobotLink, clock: RealClock) -> None:
        self.clock = clock
        self.link = link
        self.newest: dict[str, Any] = {}
        self.velocity = (0.0, 0.0)
        self.commands = True
        self._changed = asyncio.Event()
        self._driving: asyncio.Task[None] | None = None

    async def __aenter__(self) -> Self:
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
