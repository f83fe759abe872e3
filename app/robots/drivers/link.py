"""Link of a robot of parts in the program: base, laser and gamepad in a process of their own with the guard, camera and
sound in threads of the program's."""

from __future__ import annotations

import time
from collections.abc import Mapping

from app.base.kinematic_model import KinematicModel
from app.link import RobotDescription, StreamDescription
from app.messages import Audio, BatteryState, GamepadState, JointState, LaserScan, LinkStatus, Odometry
from app.robots.devices.senses import Senses
from app.robots.drivers.config import DriversConfig
from app.robots.drivers.protocol import Start
from app.robots.process_link import ProcessLink

START_TIMEOUT_S = 30.0
"""Beyond the time in which the parts may answer: for a process that loads its libraries."""
GAMEPAD_HZ, BATTERY_HZ = 20.0, 1.0


class DriversLink(ProcessLink):
    """Implements ``app.link.RobotLink``; ``clock_offset`` (s) makes the robot's clock of ``time.monotonic()``."""

    def __init__(self, config: DriversConfig, model: KinematicModel, clock_offset: float) -> None:
        def begin(demanded: Mapping[str, float], e_stop: str | None) -> Start:
            return Start(config, clock_offset, demanded, e_stop)

        self._sensing = False
        self._senses = Senses(config, model, lambda: time.monotonic() + clock_offset, self._deliver)
        within_s = START_TIMEOUT_S + config.found_within_s
        super().__init__(describe(config, self._senses), "app.robots.drivers.process", begin, within_s)

    async def start(self) -> None:
        """As ``ProcessLink.start``; a camera or a sound card that cannot be opened is logged and tried again."""
        await super().start()
        if not self._sensing:  # they outlast a restart of the process
            self._sensing = True
            await self._senses.start()
        for name in self._senses.streams:
            self._senses.want(name, name in self._receivers.wanted)

    async def stop(self) -> None:
        """As ``ProcessLink.stop``."""
        await super().stop()
        if self._sensing:
            self._sensing = False
            await self._senses.stop()

    def demand(self, stream: str, rate_hz: float) -> None:
        """As ``RobotLink.demand``."""
        super().demand(stream, rate_hz)
        self._senses.want(stream, rate_hz > 0)

    def play(self, audio: Audio) -> None:
        """As ``RobotLink.play``."""
        self._senses.play(audio)

    def _deliver(self, stream: str, message: object) -> None:
        self._receivers.deliver(stream, message)


def describe(config: DriversConfig, senses: Senses) -> RobotDescription:
    """The description of the body of ``config``, with what ``senses`` give."""
    odometry_hz, joints_hz, status_hz = config.standing_rates_hz
    streams = {
        "odometry": StreamDescription("odometry", Odometry, odometry_hz),
        "joints": StreamDescription("joints", JointState, joints_hz),
        "status": StreamDescription("status", LinkStatus, status_hz),
        "battery": StreamDescription("battery", BatteryState, BATTERY_HZ),
    }
    if config.hokuyo is not None:
        streams["hokuyo"] = StreamDescription("hokuyo", LaserScan, config.hokuyo.rate_hz)
    if config.gamepad is not None:
        streams["gamepad"] = StreamDescription("gamepad", GamepadState, GAMEPAD_HZ)
    return RobotDescription(
        config.name,
        config.model,
        config.limits.base(),
        streams | senses.streams,
        simulated=False,
        loudspeaker=senses.has_loudspeaker,
        footprint=config.footprint,
        height_m=config.height_m,
        restartable=True,
    )
