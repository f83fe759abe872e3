"""The control loop of the link's process: commands in, guard, physics, sensors, messages out, at 250 Hz.

Everything but drawing happens in this one thread, and nothing in it waits but the ``select`` that paces it. The
guard's decision comes first in every turn, from the real clock, so it holds whatever the program does.
"""

from __future__ import annotations

import contextlib
import math
import os
import select
import threading
import time

import numpy as np

from app.messages import GroundTruth, JointState, LinkStatus, Odometry, SceneTruth, Twist
from app.robots import guard
from app.robots.model import load_model
from app.robots.simulated import wire
from app.robots.simulated.acoustics.client import Acoustics
from app.robots.simulated.body import TIMESTEP_S, build_simulation
from app.robots.simulated.camera import CameraThread
from app.robots.simulated.guard_log import GuardLog
from app.robots.simulated.image_ring import ImageRings
from app.robots.simulated.laser import Laser
from app.robots.simulated.lenses import lenses, picture_formats
from app.robots.simulated.odometry import WheelOdometry, draw_true_base
from app.robots.simulated.pacer import Pacer
from app.robots.simulated.painter import Snapshot, mocap_poses
from app.robots.simulated.people import People
from app.robots.simulated.scenario_config import ScenarioConfig
from app.robots.simulated.stage import Stage

STEPS_PER_TURN = 2
_CAMERA_SETUP_S = 20.0
_SCENES_HZ = 100.0
_NICENESS = -5


class Schedule:
    """When a stream of ``rate_hz`` is next due, in simulated seconds."""

    def __init__(self, rate_hz: float) -> None:
        self.period_s = 1.0 / rate_hz
        self._next_s = 0.0

    def due(self, time_s: float) -> bool:
        """Whether it is due now; then the next time is a period on (a stream that fell behind skips, not hurries)."""
        if time_s + 1e-9 < self._next_s:
            return False
        self._next_s = max(self._next_s + self.period_s, time_s + 0.5 * self.period_s)
        return True


class WorldLoop:
    """Builds the world of a ``Start`` and runs it until told to end."""

    def __init__(self, start: wire.Start, sock: wire.Socket, memory: int) -> None:
        robot, streams = start.robot, start.robot.streams
        seeds = np.random.SeedSequence(robot.seed).spawn(8)
        rngs = [np.random.default_rng(s) for s in seeds]  # one each, in an order that stays: new ones at the end
        base_rng, odometry_rng, laser_rng, kinect_rng, self._joint_rng, imv_rng = rngs[:6]
        self._robot = robot
        self._socket = sock
        self._offset = start.clock_offset
        self._wanted = set(start.demanded)
        self._stage = Stage(start.scenario or ScenarioConfig(name="nobody"))
        base = draw_true_base(robot.base, base_rng)
        self._simulation = build_simulation(robot, start.world, base, self._stage.actors)
        self._people = People(self._simulation.model, self._stage.actors)
        self._kinematics = load_model(robot.model)
        self._limits = robot.limits.guard()
        self._state = guard.GuardState(e_stop=start.e_stop)
        self._log = GuardLog(robot.guard_log) if robot.guard_log is not None else None
        self._odometry = WheelOdometry(robot.base, odometry_rng)
        names = self._simulation.joints
        self._wheel_joints = (names.index(robot.base.left_wheel_joint), names.index(robot.base.right_wheel_joint))
        rates = {
            "odometry": streams.odometry.rate_hz,
            "joints": streams.joints.rate_hz,
            "status": streams.status.rate_hz,
            "ground_truth": streams.odometry.rate_hz,
            "scene_truth": streams.status.rate_hz,
        }
        self._laser: Laser | None = None
        if streams.hokuyo is not None:
            X_BL = self._kinematics.pose(streams.hokuyo.link)
            self._laser = Laser(self._simulation, streams.hokuyo, X_BL, laser_rng)
            rates["hokuyo"] = streams.hokuyo.rate_hz
        if streams.kinect is not None:
            rates["kinect"] = streams.kinect.rate_hz
        if streams.imv is not None:
            rates["imv"] = streams.imv.rate_hz
        self._camera: CameraThread | None = None
        self._wake_read, self._wake_write = os.pipe()
        os.set_blocking(self._wake_read, False)
        os.set_blocking(self._wake_write, False)
        self._eyes = {stream: frame for stream, (frame, _) in lenses(robot).items()}
        if self._eyes:
            rings = ImageRings(memory, picture_formats(robot)).rings
            noise = {"kinect": kinect_rng, "imv": imv_rng}
            self._camera = CameraThread(self._simulation.model, streams, rings, noise, self._wake)
            self._camera.wait_ready(_CAMERA_SETUP_S)
        self._acoustics: Acoustics | None = None
        if streams.microphones is not None:
            wheels = (robot.base.left_wheel_joint, robot.base.right_wheel_joint)
            self._acoustics = Acoustics(
                streams.microphones,
                robot.loudspeaker,
                start.world,
                self._kinematics,
                start.scenario,
                wheels,
                robot.seed,
            )
            rates["microphones"] = _SCENES_HZ
        self._schedules = {name: Schedule(rate) for name, rate in rates.items()}
        self._ending = False
        self._pacer = Pacer(time.monotonic(), TIMESTEP_S)
        self._last_odometry_s = 0.0
        self._last_seen: dict[str, float] = {}

    def end(self) -> None:
        """Have :meth:`run` stop the wheels and return; may be called from a signal handler."""
        self._ending = True
        self._wake()

    def run(self) -> None:
        """Turn until the end. Raises what the camera's thread raised."""
        with contextlib.suppress(OSError):  # where we may: on a busy computer the guard goes first
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICENESS)
        self._pacer = Pacer(time.monotonic(), TIMESTEP_S)
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
                    if notice.stream in self._wanted:  # else its age would grow for ever, and the guard refuse to drive
                        self._last_seen[notice.stream] = now
                    self._socket.send(notice)
            if self._acoustics is not None:
                for audio in self._acoustics.receive(self._simulation.time_s):
                    if "microphones" in self._wanted:
                        self._send("microphones", audio, now)
            self._socket.flush()
            self._sleep()
        self._shut_down()

    def _turn(self, now: float) -> None:
        action = guard.decide(now + self._offset, self._state, self._sensor_ages(now), self._limits)
        steps = self._pacer.due(now)
        if steps == 0 and action.immediate:  # do not let a stop wait for the next step
            self._state = guard.step(self._state, action, self._limits, 0.0)
            self._simulation.drive(self._state.applied)
        for _ in range(steps):
            self._state = guard.step(self._state, action, self._limits, TIMESTEP_S)
            self._simulation.drive(self._state.applied)
            self._simulation.step()
            if self._stage.advance(self._simulation.time_s, self._simulation.true_pose()):
                self._people.pose(self._simulation.data)
            self._pacer.advance()
            self._sense()
        if self._schedules["status"].due(self._simulation.time_s):
            self._send_status(now, action)
        if self._log is not None:
            applied = self._state.applied
            self._log.write(time.monotonic(), applied.linear_mps, applied.angular_radps)

    def _receive(self) -> None:
        for frame in self._socket.receive():
            match frame:
                case wire.Drive(stamp, linear, angular):
                    self._state = guard.accept(self._state, guard.Command(stamp, guard.Velocity(linear, angular)))
                case wire.EStop(reason):
                    self._state = guard.e_stop(self._state, reason)
                case wire.ClearEStop():
                    self._state = guard.clear_e_stop(self._state)
                case wire.Demand(stream, wanted):
                    (self._wanted.add if wanted else self._wanted.discard)(stream)
                    self._last_seen.pop(stream, None)
                case wire.Play(audio):
                    if self._acoustics is not None:
                        self._acoustics.play(audio)
                case wire.Stop():
                    self._ending = True

    def _sensor_ages(self, now: float) -> dict[str, float]:
        """Ages (s) of the sensors the base must not drive without, of those that are wanted and have spoken once."""
        return {
            name: now - self._last_seen[name] for name in self._robot.limits.required_sensors if name in self._last_seen
        }

    def _sense(self) -> None:
        time_s = self._simulation.time_s
        mono = self._pacer.stamp
        stamp = mono + self._offset
        if self._schedules["odometry"].due(time_s):
            self._send_odometry(stamp, time_s, mono)
        if self._schedules["joints"].due(time_s):
            positions = tuple(float(p) for p in self._measured_joints())
            self._send("joints", JointState(stamp, self._simulation.joints, positions), mono)
        if "ground_truth" in self._wanted and self._schedules["ground_truth"].due(time_s):
            speed = self._simulation.true_velocity()
            truth = GroundTruth(stamp, self._simulation.true_pose(), speed.linear_mps, speed.angular_radps)
            self._send("ground_truth", truth, mono)
        if "scene_truth" in self._wanted and self._schedules["scene_truth"].due(time_s):
            sounds = self._acoustics.truth(time_s, stamp, self._stage) if self._acoustics is not None else ()
            self._send("scene_truth", SceneTruth(stamp, self._stage.people, sounds), mono)
        if self._laser is not None and "hokuyo" in self._wanted:
            if not self._laser.sweeping and self._schedules["hokuyo"].due(time_s):
                self._laser.begin(stamp)
            if self._laser.sweeping and (scan := self._laser.advance(stamp)) is not None:
                self._send("hokuyo", scan, mono)
        if self._camera is not None:
            self._look(self._camera, stamp, time_s)
        if self._acoustics is not None and "microphones" in self._wanted and self._schedules["microphones"].due(time_s):
            self._acoustics.tell(time_s, stamp, self._simulation.true_pose(), self._rims(), self._stage)

    def _look(self, camera: CameraThread, stamp: float, time_s: float) -> None:
        for stream, link in self._eyes.items():
            if stream in self._wanted and not camera.busy(stream) and self._schedules[stream].due(time_s):
                measured = dict(zip(self._simulation.joints, self._measured_joints(), strict=True))
                X_BC = self._kinematics.pose(link, measured)
                data = self._simulation.data
                camera.request(stream, Snapshot(stamp, data.qpos.copy(), mocap_poses(data), X_BC))

    def _rims(self) -> tuple[float, float]:
        """Speeds (m/s) of the left and the right wheel's rim."""
        base, velocity = self._robot.base, self._simulation.true_velocity()
        turn = velocity.angular_radps * base.track_m / 2
        return velocity.linear_mps - turn, velocity.linear_mps + turn

    def _measured_joints(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        true = self._simulation.joint_positions()
        return true + self._robot.streams.joints.noise_rad * self._joint_rng.standard_normal(true.size)

    def _send_odometry(self, stamp: float, time_s: float, mono: float) -> None:
        positions = self._simulation.joint_positions()
        left, right = (float(positions[index]) for index in self._wheel_joints)
        if not (math.isfinite(left) and math.isfinite(right)):
            return  # broken encoders: the guard sees the stream age
        self._odometry.update(left, right, time_s - self._last_odometry_s)
        self._last_odometry_s = time_s
        odometry = Odometry(stamp, self._odometry.X_OB, self._odometry.linear_mps, self._odometry.angular_radps)
        self._send("odometry", odometry, mono)

    def _send_status(self, now: float, action: guard.GuardAction) -> None:
        stamp = now + self._offset
        applied = self._state.applied
        self._send(
            "status",
            LinkStatus(
                stamp=stamp,
                guard=action.mode.value,
                reason=action.reason,
                e_stopped=self._state.e_stop is not None,
                command_age_s=guard.command_age(self._state, stamp),
                applied=Twist(stamp, applied.linear_mps, applied.angular_radps),
                world_rate=self._pacer.rate(now),
            ),
            now,
        )

    def _send(self, stream: str, message: object, mono: float) -> None:
        self._last_seen[stream] = mono
        self._socket.send(wire.Sample(stream, message))

    def _wake(self) -> None:
        with contextlib.suppress(BlockingIOError):  # full: the loop is being woken already
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
        self._simulation.drive(guard.ZERO)
        self._simulation.step()
        if self._log is not None:
            self._log.write(time.monotonic(), 0.0, 0.0)
            self._log.close()
        self._socket.flush()
        if self._camera is not None:
            self._camera.close(timeout_s=0.3)
        if self._acoustics is not None:
            self._acoustics.close()
        self._socket.close()
