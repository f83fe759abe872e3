"""The simulated world with the robot: commands in; guard, physics and people; sensor data out. Its steps are
independent of the time source: the link's process in real time (``realtime_loop.py``), or the program's own clock
(``lockstep.py``). Nothing here waits, draws or reads a clock; images and sound, which need threads and processes of
their own, are made by the caller, in a callback at every step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping

import numpy as np

from app.base.kinematic_model import load_model
from app.messages import GroundTruth, JointCommand, JointState, LinkStatus, Odometry, SceneTruth, Twist
from app.robots import guard
from app.robots.config import RobotConfig
from app.robots.simulated import link_protocol
from app.robots.simulated.acoustics.ipc import MicrophoneFrame
from app.robots.simulated.acoustics.soundscape import Soundscape
from app.robots.simulated.battery import Battery
from app.robots.simulated.body import TIMESTEP_S, build_simulation
from app.robots.simulated.camera_models import lenses
from app.robots.simulated.dock import dock_poses, touches
from app.robots.simulated.joint_servos import JointServos
from app.robots.simulated.laser import Laser
from app.robots.simulated.odometry import EncoderOdometry, HolonomicOdometry, draw_true_base
from app.robots.simulated.renderer import WorldSnapshot, mocap_poses
from app.robots.simulated.scenery.people import PersonBodies
from app.robots.simulated.scenery.scenario_config import ScenarioConfig
from app.robots.simulated.scenery.scenario_state import ScenarioState
from app.robots.simulated.world_config import WorldConfig
from app.robots.thinning import Thinning

STEPS_PER_TURN = 2
"""Physics steps per decision of the guard, which runs at 250 Hz."""
_POWER_PERIOD_S = 0.02
"""Over which the power that the battery gives is taken for constant: a motor's changes more slowly."""


class Schedule:
    """Due times of a stream of ``rate_hz``, in simulated seconds."""

    def __init__(self, rate_hz: float) -> None:
        self.period_s = 1.0 / rate_hz
        self._next_s = 0.0

    def ready(self, time_s: float) -> bool:
        return time_s + 1e-9 >= self._next_s

    def expire(self) -> None:
        """Make it due now."""
        self._next_s = -math.inf

    def due(self, time_s: float) -> bool:
        """Whether it is due now; then the next time is a period later (a stream that fell behind skips periods)."""
        if not self.ready(time_s):
            return False
        self._next_s = max(self._next_s + self.period_s, time_s + 0.5 * self.period_s)
        return True


class WorldSimulation:
    """Builds the world with ``robot`` and the people of ``scenario`` in it. Stamps are the robot's clock (s).

    ``send(stream, message)`` gets the sensor data of the streams that are ``demanded``, with a rate (Hz), and of those
    that always run.
    ``soundscape``: sounds around a body with microphones, rendered by the caller. Raises ConfigError for a body that
    cannot be simulated, and for an unknown sound.
    """

    def __init__(
        self,
        robot: RobotConfig,
        world: WorldConfig,
        scenario: ScenarioConfig | None,
        send: Callable[[str, object], None],
        *,
        demanded: Mapping[str, float] | None = None,
        e_stop: str | None = None,
    ) -> None:
        streams = robot.streams
        seeds = np.random.SeedSequence(robot.seed).spawn(8)
        rngs = [np.random.default_rng(s) for s in seeds]  # one each, in a fixed order: append new ones at the end
        base_rng, odometry_rng, laser_rng, kinect_rng, self._joint_rng, panorama_rng, self._effort_rng = rngs[:7]
        self.robot = robot
        self.camera_rngs = {"kinect": kinect_rng, "panorama": panorama_rng}
        self.scenario_state = ScenarioState(scenario or ScenarioConfig(name="empty"))
        self._inhabited = scenario is not None
        self.wanted: set[str] = set()
        self._send_out = send
        base = draw_true_base(robot.base, base_rng)
        self.physics = build_simulation(robot, world, base, self.scenario_state.actors)
        self._people = PersonBodies(self.physics.model, self.scenario_state.actors)
        self.kinematics = load_model(robot.model)
        self.soundscape: Soundscape | None = None
        if streams.microphones is not None:
            wheels = (robot.base.left_wheel_joint, robot.base.right_wheel_joint)
            self.soundscape = Soundscape(
                streams.microphones,
                robot.loudspeaker,
                world=world,
                model=self.kinematics,
                scenario=scenario,
                wheels=wheels,
                seed=robot.seed,
            )
        self._limits = robot.limits.guard()
        self.state = guard.GuardState(e_stop=e_stop)
        self.joints = JointServos(self.physics, robot.groups.values())
        self._odometry: EncoderOdometry | HolonomicOdometry
        if robot.base.drive == "holonomic":
            self._odometry = HolonomicOdometry(robot.base, odometry_rng)
        else:
            self._odometry = EncoderOdometry(robot.base, odometry_rng)
        names = self.physics.joints
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
            X_BL = self.kinematics.pose(streams.hokuyo.link)
            self._laser = Laser(self.physics, streams.hokuyo, X_BL, laser_rng)
            rates["hokuyo"] = streams.hokuyo.rate_hz
        for stream, camera in (("kinect", streams.kinect), ("panorama", streams.panorama)):
            if camera is not None:
                rates[stream] = camera.rate_hz
        self._camera_frames = {stream: frame for stream, (frame, _) in lenses(robot).items()}
        self.battery: Battery | None = None
        if robot.battery is not None:
            self.battery = Battery(robot.battery)
            rates["battery"] = robot.battery.rate_hz
        self._docks = dock_poses(world)
        self._busy_cores = self._undrawn_s = 0.0
        self._schedules = {name: Schedule(rate) for name, rate in rates.items()}
        self._thinning = {name: Thinning(rates[name]) for name in self._camera_frames}
        self._last_odometry_s = 0.0
        self._last_seen: dict[str, float] = {}
        for stream, rate_hz in (demanded or {}).items():
            self.demand(stream, rate_hz)

    @property
    def cameras(self) -> tuple[str, ...]:
        return tuple(self._camera_frames)

    def accept(self, frame: object) -> None:
        """Take one of ``link_protocol``'s commands to the guard or demands of streams; others are ignored."""
        match frame:
            case link_protocol.DriveRequest(stamp, linear, angular, lateral):
                velocity = guard.BaseVelocity(linear, angular, lateral)
                self.state = guard.accept(self.state, guard.VelocityCommand(stamp, velocity))
            case JointCommand():
                self.joints.accept(frame)
            case link_protocol.EStopRequest(reason):
                self.state = guard.e_stop(self.state, reason)
            case link_protocol.ClearEStop():
                self.state = guard.clear_e_stop(self.state)
                self.joints.clear_e_stop()
            case link_protocol.ComputerLoad(cores):
                self._busy_cores = cores
            case link_protocol.Demand(stream, rate_hz):
                self.demand(stream, rate_hz)

    @property
    def commanded(self) -> bool:
        """Whether the last command moves the base."""
        command = self.state.command
        return command is not None and not command.velocity.is_zero

    def demand(self, stream: str, rate_hz: float) -> None:
        """Give ``stream`` from now on, a camera's at most at ``rate_hz``; 0: not at all."""
        (self.wanted.add if rate_hz > 0 else self.wanted.discard)(stream)
        if stream in self._thinning:
            self._thinning[stream].demand(rate_hz)
        self._last_seen.pop(stream, None)

    def turn(self, now: float, stamps: Iterable[float], also: Callable[[float], None]) -> guard.GuardAction:
        """Run the guards of base and joints at ``now``, then step once for each of ``stamps``, with sensors after each.
        ``also(stamp)`` is called after each step, for the caller's sensors. Without a step a stop is applied at once.
        """
        action = guard.decide(now, self.state, self._sensor_ages(now), self._limits)
        self.joints.decide(now, self.state.e_stop)
        simulation, steps = self.physics, 0
        for stamp in stamps:
            steps += 1
            self.state = guard.step(self.state, action, self._limits, TIMESTEP_S)
            simulation.drive(self.state.applied)
            if steps % STEPS_PER_TURN == 1:
                self.joints.step()
            simulation.step()
            if self._inhabited and self.scenario_state.due(simulation.time_s):
                self.scenario_state.advance(simulation.time_s, simulation.true_pose())
                self._people.pose(simulation.data)
            self._sense(stamp)
            also(stamp)
        self._undrawn_s += steps * TIMESTEP_S
        if self._undrawn_s + 1e-9 >= _POWER_PERIOD_S:
            self._draw_power(self._undrawn_s)
            self._undrawn_s = 0.0
        if steps == 0 and action.immediate:  # a stop must not wait for the next step
            self.state = guard.step(self.state, action, self._limits, 0.0)
            simulation.drive(self.state.applied)
        return action

    def report(self, now: float, action: guard.GuardAction, world_rate: Callable[[], float]) -> None:
        if not self._schedules["status"].due(self.physics.time_s):
            return
        applied = self.state.applied
        status = LinkStatus(
            stamp=now,
            guard=action.mode.value,
            reason=action.reason,
            e_stopped=self.state.e_stop is not None,
            command_age_s=guard.command_age(self.state, now),
            applied=Twist(now, applied.linear_mps, applied.angular_radps, applied.lateral_mps),
            world_rate=world_rate(),
            groups=self.joints.status(now),
        )
        self.send("status", status, now)

    def end(self) -> None:
        self.physics.drive(guard.ZERO)
        self.physics.step()

    def send(self, stream: str, message: object, seen: float) -> None:
        """Send ``message``, with ``seen`` as the last time of its stream."""
        self.note_sensor(stream, seen)
        self._send_out(stream, message)

    def send_sound(self, heard: MicrophoneFrame, seen: float) -> None:
        """Send a frame of the microphones and what the loudspeaker played meanwhile, as far as they are wanted."""
        if heard.played is not None and "loudspeaker" in self.wanted:
            self.send("loudspeaker", heard.played, seen)
        if "microphones" in self.wanted:
            self.send("microphones", heard.audio, seen)

    def note_sensor(self, stream: str, seen: float) -> None:
        """Note ``seen`` as the last time of ``stream``: the guard checks the age of sensors."""
        self._last_seen[stream] = seen

    def image_due(self, stream: str) -> bool:
        """Whether an image of ``stream`` is wanted and due, and not one to be left out."""
        ready = stream in self.wanted and self._schedules[stream].ready(self.physics.time_s)
        return ready and self._thinning[stream].gives

    def look(self, stream: str, stamp: float) -> WorldSnapshot | None:
        """Snapshot to render for the camera ``stream`` now; None where no image is wanted or due, or it is left out."""
        if stream not in self.wanted or not self._schedules[stream].due(self.physics.time_s):
            return None
        if (periods := self._thinning[stream].period()) == 0:
            return None
        measured = dict(zip(self.physics.joints, self._measured_joints(), strict=True))
        X_BC = self.kinematics.pose(self._camera_frames[stream], measured)
        data = self.physics.data
        return WorldSnapshot(stamp, data.qpos.copy(), mocap_poses(data), X_BC, periods)

    def rims(self) -> tuple[float, float]:
        """Speeds (m/s) of the left and the right wheel's rim."""
        base, velocity = self.robot.base, self.physics.true_velocity()
        turn = velocity.angular_radps * base.track_m / 2
        return velocity.linear_mps - turn, velocity.linear_mps + turn

    def _sensor_ages(self, now: float) -> dict[str, float]:
        """Ages (s) of the sensors required for driving, of those that are wanted and have sent data once."""
        return {
            name: now - self._last_seen[name] for name in self.robot.limits.required_sensors if name in self._last_seen
        }

    def _draw_power(self, seconds: float) -> None:
        """Charge or discharge the battery by what runs, over the last ``seconds``."""
        config = self.robot.battery
        if self.battery is None or config is None:
            return
        load = config.load
        rolling_w = load.friction_n * abs(self.physics.true_velocity().linear_mps)
        load_w = load.idle_w + load.computer_w + load.core_w * self._busy_cores
        load_w += (self.physics.motor_power_w() + rolling_w) / load.efficiency
        load_w += sum(watts for stream, watts in load.sensors_w.items() if stream in self.wanted)
        charging = touches(self.physics.true_pose(), self._docks, config.plate_m)
        if charging != self.battery.charging:
            self._schedules["battery"].expire()  # a charger that comes on is noticed at once
        self.battery.advance(seconds, load_w, charging=charging)

    def _sense(self, stamp: float) -> None:
        time_s, schedules, wanted = self.physics.time_s, self._schedules, self.wanted
        if schedules["odometry"].due(time_s):
            self._send_odometry(stamp, time_s)
        if schedules["joints"].due(time_s):
            kinematic = self.joints.kinematic_positions()
            positions = (*self._measured_joints().tolist(), *kinematic.values())
            efforts = (*self._measured_efforts().tolist(), *(0.0 for _ in kinematic))
            self.send("joints", JointState(stamp, (*self.physics.joints, *kinematic), positions, efforts), stamp)
        if self.battery is not None and "battery" in wanted and schedules["battery"].due(time_s):
            self.send("battery", self.battery.state(stamp), stamp)
        if "ground_truth" in wanted and schedules["ground_truth"].due(time_s):
            speed = self.physics.true_velocity()
            truth = GroundTruth(
                stamp, self.physics.true_pose(), speed.linear_mps, speed.angular_radps, lateral_mps=speed.lateral_mps
            )
            self.send("ground_truth", truth, stamp)
        if "scene_truth" in wanted and schedules["scene_truth"].due(time_s):
            sounds = () if self.soundscape is None else self.soundscape.truth(time_s, stamp, self.scenario_state)
            self.send("scene_truth", SceneTruth(stamp, self.scenario_state.people, sounds), stamp)
        if self._laser is not None and "hokuyo" in wanted:
            if not self._laser.sweeping and schedules["hokuyo"].due(time_s):
                self._laser.begin(stamp)
            if self._laser.sweeping and (scan := self._laser.advance(stamp)) is not None:
                self.send("hokuyo", scan, stamp)

    def _measured_joints(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        true = self.physics.joint_positions()
        return true + self.robot.streams.joints.noise_rad * self._joint_rng.standard_normal(true.size)

    def _measured_efforts(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        true = self.physics.motor_efforts()
        return true + self.robot.streams.joints.noise_nm * self._effort_rng.standard_normal(true.size)

    def _send_odometry(self, stamp: float, time_s: float) -> None:
        measured, dt_s = self._odometry, time_s - self._last_odometry_s
        if isinstance(measured, HolonomicOdometry):
            measured.update(self.physics.true_pose(), dt_s)
        else:
            positions = self.physics.joint_positions()
            left, right = (float(positions[index]) for index in self._wheel_joints)
            if not (math.isfinite(left) and math.isfinite(right)):
                return  # failed encoders: the guard sees the stream age
            measured.update(left, right, dt_s)
        self._last_odometry_s = time_s
        linear, angular, lateral = measured.linear_mps, measured.angular_radps, measured.lateral_mps
        self.send("odometry", Odometry(stamp, measured.X_OB, linear, angular, lateral_mps=lateral), stamp)
