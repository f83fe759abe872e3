"""Link of the simulated body in the program: starts the link's process, passes messages, and detects its end at
once."""

from __future__ import annotations

import asyncio
import math
import os
import time
from collections.abc import Callable
from typing import Any

from app.base.geometry import Pose2
from app.link import LinkFailed, RobotDescription, StreamDescription
from app.messages import (
    Audio,
    BatteryState,
    GroundTruth,
    Image,
    JointCommand,
    JointState,
    LaserScan,
    LinkStatus,
    Odometry,
    SceneTruth,
    Twist,
    read_only,
)
from app.robots.config import RobotConfig
from app.robots.link_process import UNSENT_BYTES, LinkProcess
from app.robots.receivers import Receivers
from app.robots.simulated import link_protocol
from app.robots.simulated.camera_models import lenses, picture_formats
from app.robots.simulated.gl import check_gl, gl_environment
from app.robots.simulated.image_ring import ImageRings, create_memory, memory_bytes
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.world_config import WorldConfig

START_TIMEOUT_S = 20.0
LOAD_PERIOD_S = 1.0
#: The arrays of a body's messages, which no subscriber may change.
_ARRAYS = {
    LaserScan: ("ranges", "intensities"),
    Audio: ("samples", "p_BM"),
    Image: ("color", "depth"),
}


class SimulatedBody:
    """What both links of a simulated robot share; :meth:`_send` takes one of ``wire``'s messages to its world."""

    def __init__(self, robot: RobotConfig, world: WorldConfig, scenario: ScenarioConfig | None) -> None:
        self._robot = robot
        self._world = world
        self._scenario = scenario
        self.description = describe(robot)
        #: ``X_WO``: pose of odometry's origin in the world, as configured.
        self.start_pose = Pose2(robot.start.x, robot.start.y, math.radians(robot.start.heading_deg))
        self._receivers = Receivers(self.description)
        #: Why the emergency stop is latched, also beyond a restart of the link.
        self._e_stop: str | None = None

    def _send(self, frame: object) -> None:
        raise NotImplementedError

    def attach(self, stream: str, receive: Callable[[Any], None]) -> Callable[[], None]:
        return self._receivers.attach(stream, receive)

    def demand(self, stream: str, rate_hz: float) -> None:
        if self._receivers.demand(stream, rate_hz):
            self._send(link_protocol.Demand(stream, rate_hz))

    def periods(self, stream: str) -> int:
        return self._receivers.periods(stream)

    def e_stop(self, reason: str) -> None:
        if self._e_stop is None:
            self._e_stop = reason
        self._send(link_protocol.EStopRequest(reason))

    def clear_e_stop(self) -> None:
        self._e_stop = None
        self._send(link_protocol.ClearEStop())

    def _receive(self, stream: str, message: object, periods: int = 1) -> None:
        for name in _ARRAYS.get(type(message), ()):
            if (array := getattr(message, name)) is not None:
                read_only(array)
        self._receivers.deliver(stream, message, periods)


class SimulatedLink(SimulatedBody):
    """Implements ``app.link.RobotLink`` for a robot in a simulated world.

    ``clock_offset`` (s) makes the robot's clock of ``time.monotonic()``, in the program and in the link alike.
    """

    def __init__(
        self, robot: RobotConfig, world: WorldConfig, clock_offset: float, scenario: ScenarioConfig | None = None
    ) -> None:
        super().__init__(robot, world, scenario)
        self._clock_offset = clock_offset
        self._lenses = lenses(robot)
        self._session: LinkProcess | None = None
        self._rings: ImageRings | None = None
        self._metering: asyncio.Task[None] | None = None
        self.images_overwritten = 0
        self.commands_dropped = 0

    @property
    def process_id(self) -> int | None:
        """The link process's id, None while there is none."""
        return self._session.process.pid if self._session is not None else None

    async def start(self) -> None:
        """Start the process and wait until its streams run. Raises LinkFailed, having released everything."""
        if self._session is not None:
            if not self._session.ended:
                raise LinkFailed("The simulated robot runs already.")
            await self._release()
        if picture_formats(self._robot) and (problem := check_gl()):
            raise LinkFailed(problem)
        session = await self._open()
        session.send(
            link_protocol.Start(
                self._robot,
                self._world,
                clock_offset=self._clock_offset,
                demanded=dict(self._receivers.rates),
                e_stop=self._e_stop,
                scenario=self._scenario,
            )
        )
        try:
            async with asyncio.timeout(START_TIMEOUT_S):
                await session.wait_running()
        except TimeoutError:
            await self._release()
            raise LinkFailed(f"The simulated robot did not start within {START_TIMEOUT_S:.0f} s.") from None
        except (LinkFailed, asyncio.CancelledError):
            await self._release()
            raise
        if self._robot.battery is not None:
            self._metering = asyncio.create_task(self._meter_computer(), name="load of the simulated computer")

    async def _meter_computer(self) -> None:
        """Report this process's CPU time, of all threads, once a second: the computer draws on the battery."""
        while True:
            began, used = time.monotonic(), time.process_time()
            await asyncio.sleep(LOAD_PERIOD_S)
            cores = (time.process_time() - used) / (time.monotonic() - began)
            if self._session is not None and self._session.unsent_bytes <= UNSENT_BYTES:
                self._session.send(link_protocol.ComputerLoad(cores))

    async def stop(self) -> None:
        """Stop the wheels, end the process, release everything; idempotent, under 1 s."""
        if self._session is not None:
            self._session.expect_end()
            self._session.send(link_protocol.Stop())
            await self._release()

    async def wait_failed(self) -> LinkFailed:
        if self._session is None:
            return LinkFailed("The simulated robot was not started.")
        return await self._session.wait_failed()

    def command(self, command: Twist | JointCommand) -> None:
        """Give a command; dropped while a frozen link does not read: it would arrive too late."""
        if self._session is None or self._session.unsent_bytes > UNSENT_BYTES:
            self.commands_dropped += 1
            return
        self._session.send(link_protocol.request(command))

    def play(self, audio: Audio) -> None:
        if self._session is not None and self._session.unsent_bytes <= UNSENT_BYTES:
            self._session.send(link_protocol.Play(audio))

    def _send(self, frame: object) -> None:
        if self._session is not None:
            self._session.send(frame)

    async def _release(self) -> None:
        if self._metering is not None:
            self._metering.cancel()
            self._metering = None
        session, self._session = self._session, None
        rings, self._rings = self._rings, None
        try:
            if session is not None:
                await session.close()
        finally:
            if rings is not None:
                rings.close()

    async def _open(self) -> LinkProcess:
        """Start the process, with a memory of its own."""
        formats = picture_formats(self._robot)
        memory = create_memory(memory_bytes(formats))
        try:
            self._rings = ImageRings(memory, formats)
            self._session = await LinkProcess.open(
                "simulated robot",
                "app.robots.simulated.process",
                self._take,
                descriptors=(memory,),
                environment=gl_environment(),
            )
        except LinkFailed:
            await self._release()
            raise
        finally:
            os.close(memory)
        return self._session

    def _take(self, frame: Any) -> None:
        match frame:
            case link_protocol.Sample(stream, message):
                self._receive(stream, message)
            case link_protocol.ImageNotice():
                self._deliver_image(frame)

    def _deliver_image(self, notice: link_protocol.ImageNotice) -> None:
        if not self._receivers.listened(notice.stream) or self._rings is None:
            return
        pictures = self._rings.read(notice.stream, notice.slot, notice.sequence)
        if pictures is None:
            self.images_overwritten += 1
            return
        frame, lens = self._lenses[notice.stream]
        color, depth = pictures
        read_only(notice.X_BC.rotation)
        read_only(notice.X_BC.translation)
        image = Image(notice.stamp, frame, color=color, depth=depth, camera=lens, X_BC=notice.X_BC)
        self._receivers.deliver(notice.stream, image, notice.periods)


def describe(robot: RobotConfig) -> RobotDescription:
    """The description of the body that ``robot`` configures."""
    streams = robot.streams
    table: list[tuple[str, type[Any], float]] = [
        ("odometry", Odometry, streams.odometry.rate_hz),
        ("joints", JointState, streams.joints.rate_hz),
        ("status", LinkStatus, streams.status.rate_hz),
    ]
    sensors = (
        ("kinect", Image, streams.kinect),
        ("panorama", Image, streams.panorama),
        ("hokuyo", LaserScan, streams.hokuyo),
    )
    table += [(name, kind, sensor.rate_hz) for name, kind, sensor in sensors if sensor is not None]
    if streams.microphones is not None:
        rate_hz = streams.microphones.rate / streams.microphones.frame_samples
        table.append(("microphones", Audio, rate_hz))
        if robot.loudspeaker is not None:
            table.append(("loudspeaker", Audio, rate_hz))
    if robot.battery is not None:
        table.append(("battery", BatteryState, robot.battery.rate_hz))
    if robot.ground_truth:
        table.append(("ground_truth", GroundTruth, streams.odometry.rate_hz))
        table.append(("scene_truth", SceneTruth, streams.status.rate_hz))
    descriptions = {name: StreamDescription(name, kind, rate, thins=kind is Image) for name, kind, rate in table}
    return RobotDescription(
        robot.name,
        robot.model,
        robot.limits.base(),
        descriptions,
        simulated=True,
        loudspeaker=robot.loudspeaker is not None and streams.microphones is not None,
        footprint=robot.footprint,
        height_m=robot.height_m,
        restartable=True,
        groups=dict(robot.groups),
        arms=dict(robot.arm_descriptions),
    )
