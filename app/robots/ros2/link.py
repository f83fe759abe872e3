"""Link of a robot over ROS 2 in the program: starts its process, passes messages, detects its end at once."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from numpy.typing import NDArray

from app.link import LinkFailed, RobotDescription, StreamDescription
from app.logs.ros.live.graph import environment
from app.messages import (
    Audio,
    BatteryState,
    Image,
    JointCommand,
    JointState,
    LaserScan,
    LinkStatus,
    Odometry,
    Twist,
    read_only,
)
from app.robots.link_process import UNSENT_BYTES, LinkProcess
from app.robots.link_protocol import ClearEStop, Demand, EStopRequest, Sample, Stop, request
from app.robots.receivers import Receivers
from app.robots.ros2.config import STATUS_HZ, Ros2Config
from app.robots.ros2.protocol import Start

START_TIMEOUT_S = 30.0
"""Beyond the time in which the robot may appear: for a process that loads its libraries."""
_TYPES: dict[str, type[Any]] = {
    "odometry": Odometry,
    "joints": JointState,
    "hokuyo": LaserScan,
    "battery": BatteryState,
    "camera": Image,
    "kinect": Image,
}


class Ros2Link:
    """Implements ``app.link.RobotLink``; ``clock_offset`` (s) makes the robot's clock of ``time.monotonic()``."""

    def __init__(self, config: Ros2Config, clock_offset: float) -> None:
        self._config = config
        self._clock_offset = clock_offset
        self.description = describe(config)
        self._receivers = Receivers(self.description)
        self._session: LinkProcess | None = None
        #: Why the emergency stop is latched, also beyond a restart of the link.
        self._e_stop: str | None = None
        self.commands_dropped = 0

    @property
    def process_id(self) -> int | None:
        """The link process's id, None while there is none."""
        return self._session.process.pid if self._session is not None else None

    async def start(self) -> None:
        """Start the process and wait until the robot is found. Raises LinkFailed, having released everything."""
        if self._session is not None:
            if not self._session.ended:
                raise LinkFailed(f"{self._config.name} runs already.")
            await self._release()
        session = await LinkProcess.open(
            self._config.name,
            "app.robots.ros2.process",
            self._take,
            environment=environment(self._config.graph.discovery),
        )
        self._session = session
        session.send(Start(self._config, self._clock_offset, dict(self._receivers.rates), self._e_stop))
        within_s = START_TIMEOUT_S + self._config.graph.found_within_s
        try:
            async with asyncio.timeout(within_s):
                await session.wait_running()
        except TimeoutError:
            await self._release()
            raise LinkFailed(f"The process of {self._config.name} did not start in {within_s:.0f} s.") from None
        except (LinkFailed, asyncio.CancelledError):
            await self._release()
            raise

    async def stop(self) -> None:
        """Stop the base, end the process, release everything; idempotent, under 1 s."""
        if self._session is not None:
            self._session.expect_end()
            self._session.send(Stop())
            await self._release()

    async def wait_failed(self) -> LinkFailed:
        """As ``RobotLink.wait_failed``."""
        if self._session is None:
            return LinkFailed(f"{self._config.name} was not started.")
        return await self._session.wait_failed()

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        """As ``RobotLink.attach``."""
        return self._receivers.attach(stream, receive)

    def demand(self, stream: str, rate_hz: float) -> None:
        """As ``RobotLink.demand``: a topic that is not wanted has no subscription."""
        if self._receivers.demand(stream, rate_hz):
            self._send(Demand(stream, rate_hz))

    def periods(self, stream: str) -> int:
        """As ``RobotLink.periods``."""
        return self._receivers.periods(stream)

    def command(self, command: Twist | JointCommand) -> None:
        """Give a command; dropped while a frozen process does not read: it would arrive too late."""
        if isinstance(command, JointCommand):
            return  # there are no groups: ``describe``
        if self._session is None or self._session.unsent_bytes > UNSENT_BYTES:
            self.commands_dropped += 1
            return
        self._session.send(request(command))

    def play(self, audio: Audio) -> None:
        """There is no loudspeaker."""

    def e_stop(self, reason: str) -> None:
        """As ``RobotLink.e_stop``."""
        if self._e_stop is None:
            self._e_stop = reason
        self._send(EStopRequest(reason))

    def clear_e_stop(self) -> None:
        """As ``RobotLink.clear_e_stop``."""
        self._e_stop = None
        self._send(ClearEStop())

    def _send(self, frame: object) -> None:
        if self._session is not None:
            self._session.send(frame)

    async def _release(self) -> None:
        session, self._session = self._session, None
        if session is not None:
            await session.close()

    def _take(self, frame: Any) -> None:
        if not isinstance(frame, Sample):
            return
        for array in _arrays(frame.message):
            read_only(array)
        self._receivers.deliver(frame.stream, frame.message)


def _arrays(message: object) -> list[NDArray[Any]]:
    """The arrays of a message that came in a pickle, which does not keep that they are read only."""
    if isinstance(message, LaserScan):
        return [message.ranges, message.intensities]
    if isinstance(message, Image):
        return [message.color] if message.depth is None else [message.color, message.depth]
    return []


def describe(config: Ros2Config) -> RobotDescription:
    """The description of the body that ``config`` maps."""
    rates = {name: topic.rate_hz for name, topic in config.mapped.items()}
    rates["joints"] = config.standing_rates_hz[1]
    streams = {name: StreamDescription(name, _TYPES[name], rate_hz) for name, rate_hz in rates.items()}
    streams["status"] = StreamDescription("status", LinkStatus, STATUS_HZ)
    return RobotDescription(
        config.name,
        config.model,
        config.limits.base(),
        streams,
        simulated=False,
        footprint=config.footprint,
        height_m=config.height_m,
        restartable=True,
    )
