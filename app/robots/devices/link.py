"""A body of this computer's devices: their data as streams, without motion and so without a guard."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable
from typing import Any

from app.base.geometry import Pose2
from app.base.kinematic_model import KinematicModel
from app.link import LinkFailed, RobotDescription, StreamDescription
from app.messages import Audio, Image, JointCommand, JointState, LinkStatus, Odometry, Twist
from app.robots.devices.config import JOINTS_HZ, ODOMETRY_HZ, STATUS_HZ, DevicesConfig
from app.robots.devices.player import Player
from app.robots.devices.reader_thread import InputReader
from app.robots.devices.sound import no_sound_card
from app.robots.devices.streams import AudioFrames, ImageFrames
from app.robots.receivers import Receivers

log = logging.getLogger("hbba.devices")

NO_WHEELS = "This body has no wheels."
_MOST_PICTURES, _MOST_FRAMES = 2, 94


class DevicesLink:
    """Implements ``app.link.RobotLink``; ``clock_offset`` (s) makes the robot's clock of ``time.monotonic()``."""

    def __init__(self, config: DevicesConfig, model: KinematicModel, clock_offset: float) -> None:
        self._config = config
        self._offset = clock_offset
        self._readers: dict[str, InputReader[Any]] = {}
        self._tasks: list[asyncio.Task[None]] = []
        self._failure: asyncio.Future[LinkFailed] | None = None
        self._player = None
        self._mute = no_sound_card() if config.loudspeaker is not None else ""
        if config.loudspeaker is not None and not self._mute:
            self._player = Player(config.loudspeaker)
        self._e_stop: str | None = None
        streams = {
            "odometry": StreamDescription("odometry", Odometry, ODOMETRY_HZ),
            "joints": StreamDescription("joints", JointState, JOINTS_HZ),
            "status": StreamDescription("status", LinkStatus, STATUS_HZ),
        }
        if config.camera is not None:
            # Once for all: a body without motors has no joints that move
            eye = ImageFrames(config.camera, model.pose(config.camera.link), self._now)
            self._readers["camera"] = InputReader(
                "camera", eye.open, lambda image: self._receivers.deliver("camera", image),
                pause_s=eye.pause_s, most_waiting=_MOST_PICTURES,
            )  # fmt: skip
            streams["camera"] = StreamDescription("camera", Image, config.camera.rate_hz or 15.0)
        if config.microphones is not None:
            ear = AudioFrames(config.microphones, model.pose(config.microphones.link), self._now)
            self._readers["microphones"] = InputReader(
                "microphones", ear.open, lambda audio: self._receivers.deliver("microphones", audio),
                pause_s=ear.pause_s, most_waiting=_MOST_FRAMES,
            )  # fmt: skip
            rate_hz = config.microphones.rate / config.microphones.frame_samples
            streams["microphones"] = StreamDescription("microphones", Audio, rate_hz)
        self.description = RobotDescription(
            config.name,
            config.model,
            config.limits.base(),
            streams,
            simulated=False,
            loudspeaker=self._player is not None,
        )
        self._receivers = Receivers(self.description)

    async def start(self) -> None:
        """Open the devices. A device that cannot be opened is logged and tried again; LinkFailed if none can."""
        if self._mute:
            log.warning("%s is mute: %s", self._config.name, self._mute)
        self._failure = asyncio.get_running_loop().create_future()
        problems = await asyncio.gather(*(reader.start() for reader in self._readers.values()))
        if problems and all(problems):
            await self._release()
            raise LinkFailed(f"{self._config.name} can neither see nor hear: {'; '.join(problems)}.")
        for name, reader in self._readers.items():
            reader.want(name in self._receivers.wanted)
        for period_s, publish in (
            (1 / ODOMETRY_HZ, self._stand),
            (1 / JOINTS_HZ, self._pose),
            (1 / STATUS_HZ, self._report),
        ):
            self._tasks.append(asyncio.create_task(_repeat(period_s, publish), name=f"devices {publish.__name__}"))
        if self._player is not None:
            self._player.start()

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
        if self._receivers.demand(stream, rate_hz) and stream in self._readers:
            self._readers[stream].want(rate_hz > 0)

    def periods(self, stream: str) -> int:
        """How many periods of ``stream`` the message being delivered ends."""
        return self._receivers.periods(stream)

    def command(self, command: Twist | JointCommand) -> None:
        """No effect: there are no wheels."""

    def play(self, audio: Audio) -> None:
        if self._player is not None:
            self._player.play(audio)

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
        await asyncio.gather(*(reader.stop() for reader in self._readers.values()))
        if self._player is not None:
            self._player.stop()

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
