"""A body of this computer's devices: their data as streams, without motion and so without a guard."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any

from app.base.geometry import Pose2
from app.base.kinematic_model import KinematicModel
from app.link import LinkFailed, RobotDescription, StreamDescription
from app.messages import Audio, JointCommand, JointState, LinkStatus, Odometry, Twist
from app.robots.devices.config import JOINTS_HZ, ODOMETRY_HZ, STATUS_HZ, DevicesConfig
from app.robots.devices.senses import Senses
from app.robots.receivers import Receivers

NO_WHEELS = "This body has no wheels."


class DevicesLink:
    """Implements ``app.link.RobotLink``; ``clock_offset`` (s) makes the robot's clock of ``time.monotonic()``."""

    def __init__(self, config: DevicesConfig, model: KinematicModel, clock_offset: float) -> None:
        self._config = config
        self._offset = clock_offset
        self._tasks: list[asyncio.Task[None]] = []
        self._failure: asyncio.Future[LinkFailed] | None = None
        self._e_stop: str | None = None
        streams = {
            "odometry": StreamDescription("odometry", Odometry, ODOMETRY_HZ),
            "joints": StreamDescription("joints", JointState, JOINTS_HZ),
            "status": StreamDescription("status", LinkStatus, STATUS_HZ),
        }
        self._senses = Senses(config, model, self._now, self._deliver)
        streams |= self._senses.streams
        self.description = RobotDescription(
            config.name,
            config.model,
            config.limits.base(),
            streams,
            simulated=False,
            loudspeaker=self._senses.has_loudspeaker,
        )
        self._receivers = Receivers(self.description)

    async def start(self) -> None:
        """Open the devices. A device that cannot be opened is logged and tried again; LinkFailed if none can."""
        self._failure = asyncio.get_running_loop().create_future()
        problems = await self._senses.start()
        if problems and len(problems) == len(self._senses.streams):
            await self._release()
            raise LinkFailed(f"{self._config.name} can neither see nor hear: {'; '.join(problems)}.")
        for name in self._senses.streams:
            self._senses.want(name, name in self._receivers.wanted)
        for period_s, publish in (
            (1 / ODOMETRY_HZ, self._stand),
            (1 / JOINTS_HZ, self._pose),
            (1 / STATUS_HZ, self._report),
        ):
            self._tasks.append(asyncio.create_task(_repeat(period_s, publish), name=f"devices {publish.__name__}"))

    async def stop(self) -> None:
        await self._release()

    async def wait_failed(self) -> LinkFailed:
        """Never returns: lost devices are opened again."""
        if self._failure is None:
            return LinkFailed("The devices were not started.")
        return await asyncio.shield(self._failure)

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        return self._receivers.attach(stream, receive)

    def demand(self, stream: str, rate_hz: float) -> None:
        """Set the rate at which ``stream`` is wanted: at 0, the device is not read, and is released after a time."""
        if self._receivers.demand(stream, rate_hz):
            self._senses.want(stream, rate_hz > 0)

    def periods(self, stream: str) -> int:
        """How many periods of ``stream`` the message being delivered ends."""
        return self._receivers.periods(stream)

    def command(self, command: Twist | JointCommand) -> None:
        """No effect: there are no wheels."""

    def play(self, audio: Audio) -> None:
        self._senses.play(audio)

    def e_stop(self, reason: str) -> None:
        self._e_stop = self._e_stop or reason

    def clear_e_stop(self) -> None:
        self._e_stop = None

    async def _release(self) -> None:
        tasks, self._tasks = self._tasks, []
        for task in tasks:
            task.cancel()
        if tasks:
            await asyncio.wait(tasks)
        await self._senses.stop()

    def _deliver(self, stream: str, message: Any) -> None:
        self._receivers.deliver(stream, message)

    def _now(self) -> float:
        return time.monotonic() + self._offset

    def _stand(self) -> None:
        self._receivers.deliver("odometry", Odometry(self._now(), Pose2(), 0.0, 0.0))

    def _pose(self) -> None:
        self._receivers.deliver("joints", JointState(self._now(), (), ()))

    def _report(self) -> None:
        now = self._now()
        guard = "idle" if self._e_stop is None else "e_stopped"
        status = LinkStatus(
            stamp=now,
            guard=guard,
            reason=self._e_stop or NO_WHEELS,
            e_stopped=self._e_stop is not None,
            command_age_s=None,
            applied=Twist(now, 0.0, 0.0),
            world_rate=1.0,
        )
        self._receivers.deliver("status", status)


async def _repeat(period_s: float, publish: Callable[[], None]) -> None:
    while True:
        publish()
        await asyncio.sleep(period_s)
