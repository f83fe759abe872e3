"""The link of a body whose driver and guard are in a process of their own: starts it, passes messages, detects its end
at once."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from typing import Any

from numpy.typing import NDArray

from app.link import LinkFailed, RobotDescription
from app.messages import Audio, Image, JointCommand, LaserScan, Twist, read_only
from app.robots.link_process import UNSENT_BYTES, LinkProcess
from app.robots.link_protocol import ClearEStop, Demand, EStopRequest, Sample, Stop, request
from app.robots.receivers import Receivers


class ProcessLink:
    """Implements ``app.link.RobotLink`` but for the loudspeaker: the body ``description`` in the process ``module``.

    ``begin(demanded, e_stop)`` makes its first message, of the rates (Hz) by stream that are demanded and of the reason
    of a latched emergency stop; ``within_s`` is the time that it has for the start.
    """

    def __init__(
        self,
        description: RobotDescription,
        module: str,
        begin: Callable[[Mapping[str, float], str | None], object],
        within_s: float,
        *,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self._module = module
        self._begin = begin
        self._within_s = within_s
        self._environment = environment
        self.description = description
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
        """Start the process and wait until the robot is there. Raises LinkFailed, having released everything."""
        if self._session is not None:
            if not self._session.ended:
                raise LinkFailed(f"{self.description.name} runs already.")
            await self._release()
        session = await LinkProcess.open(self.description.name, self._module, self._take, environment=self._environment)
        self._session = session
        session.send(self._begin(dict(self._receivers.rates), self._e_stop))
        try:
            async with asyncio.timeout(self._within_s):
                await session.wait_running()
        except TimeoutError:
            await self._release()
            raise LinkFailed(
                f"The process of {self.description.name} did not start in {self._within_s:.0f} s."
            ) from None
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
            return LinkFailed(f"{self.description.name} was not started.")
        return await self._session.wait_failed()

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        """As ``RobotLink.attach``."""
        return self._receivers.attach(stream, receive)

    def demand(self, stream: str, rate_hz: float) -> None:
        """As ``RobotLink.demand``."""
        if self._receivers.demand(stream, rate_hz):
            self._send(Demand(stream, rate_hz))

    def periods(self, stream: str) -> int:
        """As ``RobotLink.periods``."""
        return self._receivers.periods(stream)

    def command(self, command: Twist | JointCommand) -> None:
        """Give a command; dropped while a frozen process does not read: it would arrive too late."""
        if isinstance(command, JointCommand) and command.group not in self.description.groups:
            return
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
