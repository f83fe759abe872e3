"""Link of the simulated body in the program: starts the link's process, passes messages, and detects its end at
once."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
import os
import socket
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from app.base.child_processes import python
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
from app.robots.receivers import Receivers
from app.robots.simulated import link_protocol
from app.robots.simulated.camera_models import lenses, picture_formats
from app.robots.simulated.gl import check_gl, gl_environment
from app.robots.simulated.image_ring import ImageRings, create_memory, memory_bytes
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.world_config import WorldConfig

START_TIMEOUT_S = 20.0
STOP_TIMEOUT_S = 0.6
LOAD_PERIOD_S = 1.0
_UNSENT_BYTES = 4096
_LAST_LINES = 12
#: The arrays of a body's messages, which no subscriber may change.
_ARRAYS = {
    LaserScan: ("ranges", "intensities"),
    Audio: ("samples", "p_BM"),
    Image: ("color", "depth"),
}

log = logging.getLogger(__name__)


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
        self._session: _Session | None = None
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
        session = await _Session.open(self._robot, self._take)
        self._session = session
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
            if self._session is not None and self._session.unsent_bytes <= _UNSENT_BYTES:
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
        if self._session is None or self._session.unsent_bytes > _UNSENT_BYTES:
            self.commands_dropped += 1
            return
        self._session.send(link_protocol.request(command))

    def play(self, audio: Audio) -> None:
        if self._session is not None and self._session.unsent_bytes <= _UNSENT_BYTES:
            self._session.send(link_protocol.Play(audio))

    def _send(self, frame: object) -> None:
        if self._session is not None:
            self._session.send(frame)

    async def _release(self) -> None:
        if self._metering is not None:
            self._metering.cancel()
            self._metering = None
        session, self._session = self._session, None
        if session is not None:
            await session.close()

    def _take(self, frame: Any) -> None:
        match frame:
            case link_protocol.Sample(stream, message):
                self._receive(stream, message)
            case link_protocol.ImageNotice():
                self._deliver_image(frame)

    def _deliver_image(self, notice: link_protocol.ImageNotice) -> None:
        if not self._receivers.listened(notice.stream) or self._session is None:
            return
        pictures = self._session.rings.read(notice.stream, notice.slot, notice.sequence)
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


class _Session(asyncio.Protocol):
    """One run of the link's process: its socket, shared memory and error output."""

    def __init__(self, rings: ImageRings, receive: Callable[[Any], None]) -> None:
        self.rings = rings
        self._receive = receive
        self._reader = link_protocol.FrameReader()
        self._running = asyncio.Event()
        self._transport: asyncio.Transport | None = None
        self._ended = asyncio.get_running_loop().create_future()
        self._expected = False
        self._last_lines: deque[str] = deque(maxlen=_LAST_LINES)
        #: Result of the start: an error before the process runs is raised in the waiting start().
        self._held_lines: list[str] = []
        self.process: asyncio.subprocess.Process
        self._watch: asyncio.Task[None]

    @staticmethod
    async def open(robot: RobotConfig, receive: Callable[[Any], None]) -> _Session:
        """Start the process, with a socket and a memory of its own."""
        formats = picture_formats(robot)
        memory = create_memory(memory_bytes(formats))
        ours, theirs = socket.socketpair()
        try:
            session = _Session(ImageRings(memory, formats), receive)
            session.process = await asyncio.create_subprocess_exec(
                *python("-m", "app.robots.simulated.process", str(theirs.fileno()), str(memory)),
                pass_fds=(theirs.fileno(), memory), stdin=asyncio.subprocess.DEVNULL, stdout=asyncio.subprocess.DEVNULL,
                stderr=asyncio.subprocess.PIPE, env=os.environ | gl_environment(), start_new_session=True,
            )  # fmt: skip
        except OSError as failure:
            ours.close()
            raise LinkFailed(f"The simulated robot's process cannot be started: {failure.strerror}.") from None
        finally:
            theirs.close()
            os.close(memory)
        session._watch = asyncio.create_task(session._watch_process(), name="simulated link")
        await asyncio.get_running_loop().create_connection(lambda: session, sock=ours)
        return session

    @property
    def ended(self) -> bool:
        return self._ended.done()

    @property
    def unsent_bytes(self) -> int:
        """Bytes the process has not read yet, beyond what the socket holds."""
        return self._transport.get_write_buffer_size() if self._transport is not None else 0

    def send(self, frame: Any) -> None:
        if self._transport is not None and not self._transport.is_closing():
            self._transport.write(link_protocol.encode(frame))

    def expect_end(self) -> None:
        self._expected = True

    async def wait_running(self) -> None:
        """Wait for the first sample; raises LinkFailed if the process ends before."""
        running = asyncio.ensure_future(self._running.wait())
        try:
            await asyncio.wait({running, self._ended}, return_when=asyncio.FIRST_COMPLETED)
            if self._ended.done():
                raise self._ended.result()
        finally:
            running.cancel()

    async def wait_failed(self) -> LinkFailed:
        failure: LinkFailed = await asyncio.shield(self._ended)
        return failure

    async def close(self) -> None:
        """Let the process end by itself for a moment, then kill it; release socket and memory."""
        self._expected = True
        try:
            async with asyncio.timeout(STOP_TIMEOUT_S):
                await asyncio.shield(self._watch)
        except TimeoutError:
            with contextlib.suppress(ProcessLookupError):
                self.process.kill()
            await self._watch
        finally:
            if self._transport is not None:
                self._transport.abort()
            self.rings.close()

    # asyncio.Protocol

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport

    def data_received(self, data: bytes) -> None:
        for frame in self._reader.feed(data):
            if isinstance(frame, link_protocol.Sample) and not self._running.is_set():
                self._running.set()
                self._notify_held()
            self._receive(frame)

    async def _watch_process(self) -> None:
        """Follow the process's standard error and wait for its end."""
        assert self.process.stderr is not None
        async for raw in self.process.stderr:
            line = raw.decode(errors="replace").rstrip()
            self._last_lines.append(line)
            self._held_lines.append(line)
            if self._running.is_set():
                self._notify_held()
        status = await self.process.wait()
        sentence = self._sentence(status)
        if sentence is None:
            self._notify_held()
        failure = LinkFailed(sentence or self._exit_reason(status))
        if not self._expected and self._running.is_set():
            log.error("%s", failure)
        self._ended.set_result(failure)

    def _notify_held(self) -> None:
        for line in self._held_lines:
            log.warning("simulated robot: %s", line)
        self._held_lines.clear()

    def _words(self) -> list[str]:
        return [line.strip() for line in self._last_lines if line.strip(" ^~")]

    def _sentence(self, status: int) -> str | None:
        """The process's error message for people, if it ended with one."""
        words = self._words()
        return words[0] if status == 1 and len(words) == 1 else None

    def _exit_reason(self, status: int) -> str:
        how = f"was killed by signal {-status}" if status < 0 else f"ended with status {status}"
        words = self._words()
        said = "; its last words: " + " | ".join(words[-3:]) if words else ""
        return f"The simulated robot's process {how}{said}."
