"""The control loop of the process of a robot of parts: the guard decides and the base is given its velocity, many times
a second, whatever comes or does not come from program and devices."""

from __future__ import annotations

import select
import sys
import time

from app.base.kinematic_model import load_model
from app.messages import JointState
from app.robots import guard
from app.robots.body_process import Unavailable
from app.robots.drivers.attached import Attached, cautions
from app.robots.drivers.config import STATUS_HZ, DriversConfig
from app.robots.drivers.gamepad import Gamepad
from app.robots.drivers.hokuyo import Hokuyo
from app.robots.drivers.input_events import AXES, axis_range
from app.robots.drivers.port import InputAddress, Port
from app.robots.drivers.protocol import Start
from app.robots.drivers.serial_base import SerialBase
from app.robots.guarded_base import GuardedBase
from app.robots.link_protocol import Demand, Ready, Sample, Socket, Stop


class BodyLoop:
    """The robot of ``start`` for the program at the other end of ``sock``."""

    def __init__(self, start: Start, sock: Socket) -> None:
        config: DriversConfig = start.config
        self._config = config
        self._socket = sock
        self._offset = start.clock_offset
        self._limits = config.limits.guard()
        self._period_s = 1.0 / config.base.rate_hz
        self._guard = GuardedBase(self._limits, start.e_stop)
        model = load_model(config.model)
        self._unmoved = dict.fromkeys(model.joint_names, 0.0)
        self._base = SerialBase("base", config.base.setting)
        self._parts = [Attached(self._base, Port(config.base.address))]
        #: Which part gives a stream.
        self._givers = dict.fromkeys(("odometry", "joints", "battery"), self._parts[0])
        self._laser: Hokuyo | None = None
        if config.hokuyo is not None:
            self._laser = Hokuyo("hokuyo", config.hokuyo.setting, model.pose(config.hokuyo.link))
            self._laser.wanted = "hokuyo" in config.limits.required_sensors or "hokuyo" in start.demanded
            self._parts.append(Attached(self._laser, Port(config.hokuyo.address)))
            self._givers["hokuyo"] = self._parts[-1]
        self._gamepad: Gamepad | None = None
        if config.gamepad is not None:
            self._gamepad = Gamepad("gamepad", config.gamepad.setting)
            self._parts.append(Attached(self._gamepad, Port(InputAddress(config.gamepad.port))))
        self._reported = self._moved = 0.0
        self._ending = False

    def end(self) -> None:
        """Have :meth:`run` stop the base and return; may be called from a signal handler."""
        self._ending = True

    def run(self) -> None:
        """Run until the end. Raises Unavailable, having stopped the base."""
        began = time.monotonic()
        try:
            if self._found(began):
                self._socket.send(Ready(setup_s=time.monotonic() - began))
                self._drive()
        finally:
            # The last word, whatever ended it; what it does not reach, the base's own watchdog does.
            self._base.velocity, self._base.brake, self._base.due = guard.ZERO, True, True
            self._parts[0].step(self._now())
            for part in self._parts:
                part.close()
            self._socket.flush()
            self._socket.close()

    def _found(self, began: float) -> bool:
        """Wait until all is there that driving requires; False where the program ended before. Raises Unavailable."""
        required = {id(self._givers[name]): self._givers[name] for name in self._config.limits.required_sensors}
        while not self._ended():
            now = self._now()
            self._base.due = True
            self._step_parts(now, deliver=False)
            reasons = self._reasons(now)
            if not reasons:
                return True
            for part in required.values():
                if part.wrong:
                    raise Unavailable(f"{part.where}: {part.wrong}.")
            if time.monotonic() - began > self._config.found_within_s:
                within = f"within {self._config.found_within_s:g} s"
                raise Unavailable(f"{self._config.name} was not found {within}: {'; '.join(reasons)}.")
            self._wait(self._period_s)
        return False

    def _drive(self) -> None:
        due = before = time.monotonic()
        while not self._ended():
            monotonic = time.monotonic()
            now = monotonic + self._offset
            if monotonic >= due:
                self._guard.step(now, min(monotonic - before, 2 * self._period_s), self._reasons(now))
                self._base.velocity, self._base.brake = self._guard.velocity, self._guard.immediate
                self._base.due = True
                before, due = monotonic, max(due + self._period_s, monotonic)
                self._report(monotonic)
            self._step_parts(now)
            self._socket.flush()
            self._wait(max(due - time.monotonic(), 0.0))

    def _step_parts(self, now: float, *, deliver: bool = True) -> None:
        for part in self._parts:
            opened = part.port.is_open
            for stream, message in part.step(now):
                if deliver:
                    self._socket.send(Sample(stream, message))
            if part.device is self._gamepad and part.port.is_open and not opened:
                self._learn_ranges(part)
        for sentence in cautions(self._parts):
            print(sentence, file=sys.stderr, flush=True)

    def _learn_ranges(self, part: Attached) -> None:
        setting, descriptor = self._config.gamepad, part.port.descriptor
        assert self._gamepad is not None
        assert setting is not None
        assert descriptor is not None
        axes = filter(None, (setting.linear, setting.angular, setting.lateral))
        self._gamepad.ranges = {axis: axis_range(descriptor, AXES[axis]) for axis in axes}

    def _reasons(self, now: float) -> tuple[str, ...]:
        """All that forbids driving, the gravest first."""
        timeout_s, required = self._limits.sensor_timeout_s, self._config.limits.required_sensors
        silences = [self._givers[name].silence(name, now, timeout_s) for name in required]
        return tuple(dict.fromkeys(filter(None, (self._parts[0].problem(now), *silences))))

    def _report(self, monotonic: float) -> None:
        now = monotonic + self._offset
        if monotonic - self._reported >= 1.0 / STATUS_HZ:
            self._reported = monotonic
            self._socket.send(Sample("status", self._guard.status(now)))
        if self._config.base.wheel_joints is None and monotonic - self._moved >= 1.0:
            self._moved = monotonic
            unmoved = JointState(now, tuple(self._unmoved), tuple(self._unmoved.values()))
            self._socket.send(Sample("joints", unmoved))

    def _ended(self) -> bool:
        """Read what the program sent; whether it is over."""
        for frame in self._socket.receive():
            match frame:
                case Demand("hokuyo", rate_hz) if self._laser is not None:
                    self._laser.wanted = rate_hz > 0 or "hokuyo" in self._config.limits.required_sensors
                case Stop():
                    self._ending = True
                case _:
                    self._guard.take(frame)
        return self._ending or self._socket.closed

    def _wait(self, timeout_s: float) -> None:
        link = self._socket.fileno()
        open_ports = [part.port for part in self._parts if part.port.descriptor is not None]
        readable: list[int] = [link, *(port.descriptor for port in open_ports if port.descriptor is not None)]
        writable = [port.descriptor for port in open_ports if port.waits_to_write and port.descriptor is not None]
        select.select(readable, [link, *writable] if self._socket.has_unsent else writable, [], timeout_s)

    def _now(self) -> float:
        return time.monotonic() + self._offset
