"""The control loop of the link's process: steps the world in real time, at 250 Hz.

Everything except drawing and sound runs in this thread, which waits only in the ``select`` that paces it. The guard's
decision comes first in every cycle, by the real clock, so it is independent of the program.
"""

from __future__ import annotations

import contextlib
import os
import select
import threading
import time
from collections.abc import Iterator

from app.robots.simulated import link_protocol
from app.robots.simulated.acoustics.client import AcousticsClient
from app.robots.simulated.acoustics.soundscape import SCENES_HZ
from app.robots.simulated.body import TIMESTEP_S
from app.robots.simulated.camera_models import picture_formats
from app.robots.simulated.camera_thread import CameraThread
from app.robots.simulated.guard_log import GuardLog, GuardRow
from app.robots.simulated.image_ring import ImageRings
from app.robots.simulated.pacer import Pacer
from app.robots.simulated.simulation import STEPS_PER_TURN, Schedule, WorldSimulation

_CAMERA_SETUP_S = 20.0
_NICENESS = -5


class RealtimeLoop:
    """Builds the world of a ``Start`` and runs it until the end."""

    def __init__(self, start: link_protocol.Start, sock: link_protocol.Socket, memory: int) -> None:
        robot, streams = start.robot, start.robot.streams
        self._socket = sock
        self._offset = start.clock_offset
        self._simulation = WorldSimulation(
            robot, start.world, start.scenario, self._send, demanded=start.demanded, e_stop=start.e_stop
        )
        self._log = (
            GuardLog(robot.guard_log, len(self._simulation.joints.setpoints())) if robot.guard_log is not None else None
        )
        self._camera: CameraThread | None = None
        self._wake_read, self._wake_write = os.pipe()
        os.set_blocking(self._wake_read, False)
        os.set_blocking(self._wake_write, False)
        if self._simulation.cameras:
            rings = ImageRings(memory, picture_formats(robot)).rings
            model = self._simulation.physics.model
            self._camera = CameraThread(model, streams, rings, self._simulation.camera_rngs, self._wake)
            self._camera.wait_ready(_CAMERA_SETUP_S)
        self._acoustics: AcousticsClient | None = None
        self._scenes = Schedule(SCENES_HZ)
        if self._simulation.soundscape is not None:
            self._acoustics = AcousticsClient(self._simulation.soundscape)
        self._ending = False
        self._pacer = Pacer(time.monotonic(), TIMESTEP_S)

    def end(self) -> None:
        """Have :meth:`run` stop the wheels and return; may be called from a signal handler."""
        self._ending = True
        self._wake()

    def run(self) -> None:
        """Run until the end. Raises errors of the camera's thread."""
        with contextlib.suppress(OSError):  # if permitted: on a busy computer the guard has priority
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICENESS)
        self._pacer = Pacer(time.monotonic(), TIMESTEP_S)
        simulation = self._simulation
        while not self._ending:
            self._receive()
            if self._socket.closed:
                break
            now = time.monotonic()
            self._turn(now)
            if self._camera is not None:
                if self._camera.failure is not None:
                    raise self._camera.failure
                while self._camera.finished:
                    notice = self._camera.finished.popleft()
                    if (
                        notice.stream in simulation.wanted
                    ):  # else its age would grow for ever, and the guard refuse to drive
                        simulation.note_sensor(notice.stream, now + self._offset)
                    self._socket.send(notice)
            if self._acoustics is not None:
                for heard in self._acoustics.receive(simulation.physics.time_s):
                    simulation.send_sound(heard, now + self._offset)
            self._socket.flush()
            self._sleep()
        self._shut_down()

    def _turn(self, now: float) -> None:
        simulation = self._simulation
        action = simulation.turn(now + self._offset, self._stamps(now), self._also)
        simulation.report(now + self._offset, action, lambda: self._pacer.rate(now))
        if self._log is not None:
            applied = simulation.state.applied
            setpoints = simulation.joints.setpoints()
            velocity = (applied.linear_mps, applied.angular_radps)
            self._log.write(GuardRow(time.monotonic(), *velocity, setpoints, lateral_mps=applied.lateral_mps))

    def _stamps(self, now: float) -> Iterator[float]:
        """Real instants of the due steps. Where an image is due while the one before is still being drawn, or sound is
        late, simulated time pauses: a computer too slow for the sensors slows everything alike."""
        for _ in range(self._pacer.due(now)):
            if self._pacer.waits(now, self._sensed_late()):
                return
            self._pacer.advance()
            yield self._pacer.stamp + self._offset

    def _sensed_late(self) -> bool:
        camera, simulation = self._camera, self._simulation
        if self._acoustics is not None and self._acoustics.late and "microphones" in simulation.wanted:
            return True
        return camera is not None and any(
            camera.busy(stream) and simulation.image_due(stream) for stream in simulation.cameras
        )

    def _also(self, stamp: float) -> None:
        """Request images and sound of the world after a step."""
        simulation, time_s = self._simulation, self._simulation.physics.time_s
        if self._camera is not None:
            for stream in simulation.cameras:
                if self._camera.busy(stream) and simulation.image_due(stream):
                    continue  # simulated time pauses
                if (snapshot := simulation.look(stream, stamp)) is not None:
                    self._camera.request(stream, snapshot)
        if self._acoustics is not None and "microphones" in simulation.wanted and self._scenes.due(time_s):
            pose = simulation.physics.true_pose()
            self._acoustics.update(time_s, stamp, pose, simulation.rims(), simulation.scenario_state)

    def _receive(self) -> None:
        for frame in self._socket.receive():
            match frame:
                case link_protocol.Play(audio):
                    if self._acoustics is not None:
                        self._acoustics.play(audio)
                case link_protocol.Stop():
                    self._ending = True
                case _:
                    before = self._simulation.commanded
                    self._simulation.accept(frame)
                    # Setting out and stopping wait for no picture: real wheels would not.
                    if self._simulation.commanded != before:
                        self._pacer.go_on()

    def _send(self, stream: str, message: object) -> None:
        self._socket.send(link_protocol.Sample(stream, message))

    def _wake(self) -> None:
        with contextlib.suppress(BlockingIOError):  # full: the loop is already being woken
            os.write(self._wake_write, b"\0")

    def _sleep(self) -> None:
        timeout = self._pacer.wait_s(time.monotonic(), STEPS_PER_TURN)
        link = self._socket.fileno()
        ears = self._acoustics.descriptors if self._acoustics is not None else []
        ready, _, _ = select.select(
            [link, self._wake_read, *ears], [link] if self._socket.has_unsent else [], [], timeout
        )
        if self._wake_read in ready:
            os.read(self._wake_read, 4096)

    def _shut_down(self) -> None:
        self._simulation.end()
        if self._log is not None:
            self._log.write(GuardRow(time.monotonic(), 0.0, 0.0, self._simulation.joints.setpoints()))
            self._log.close()
        self._socket.flush()
        if self._camera is not None:
            self._camera.close(timeout_s=0.3)
        if self._acoustics is not None:
            self._acoustics.close()
        self._socket.close()
