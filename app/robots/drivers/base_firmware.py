"""Reference firmware of a differential base (docs/serial-base.md): what a board between line and motors does.

Bytes and time go in, wheel speeds and bytes come out; whatever turns the wheels says how far they came. It runs behind
motors that a program in Python drives (docs/your-robot.md), and in the simulated robot of parts. Nothing here waits,
and all of it can be written in a few hundred lines of C.
"""

from __future__ import annotations

from dataclasses import dataclass

from app.robots.drivers import base_protocol as protocol
from app.robots.drivers.base_protocol import Fault, Frame, FrameReader, Hello, Velocity


@dataclass(frozen=True, slots=True)
class FirmwareSetting:
    """What the board knows of its base: greatest speeds (m/s, rad/s), accelerations of its own ramp and of braking
    (m/s^2, at a wheel), counts of a metre, track (m), name; how often (Hz) it says STATE."""

    linear_mps: float = 0.6
    angular_radps: float = 2.0
    ramp_mps2: float = 2.0
    brake_mps2: float = 2.5
    ticks_per_m: int = 20000
    track_m: float = 0.30
    name: str = "reference base"
    state_hz: float = 50.0


class BaseFirmware:
    """The board, since it began; ``boot`` differs from that of its last beginning. Times are its own, in s from 0.

    ``faults``: what its switches and drives report, to be set from outside. ``charge``: of its battery, 0 to 1.
    """

    def __init__(self, setting: FirmwareSetting, boot: int) -> None:
        self.setting = setting
        self.boot = boot
        self.faults = Fault(0)
        self.charge = 0.9
        #: Speeds of the wheels (m/s) that it asks of its drives: left, right.
        self.wheels_mps = (0.0, 0.0)
        self._reader = FrameReader()
        self._time_s = 0.0
        self._goal_mps = (0.0, 0.0)
        self._brake = True
        self._valid_until = 0.0
        self._taken = 0
        self._counts = [0.0, 0.0]
        self._said_state = self._said_battery = -1.0
        self._outgoing = bytearray()
        self._sequence = 0
        self._say(self._identity())

    @property
    def garbled(self) -> int:
        """Frames that came damaged."""
        return self._reader.garbled

    def receive(self, data: bytes) -> None:
        """Bytes have come over the line."""
        for frame, sequence in self._reader.feed(data):
            match frame:
                case Hello():
                    self._say(self._identity())
                case Velocity(linear, angular, timeout_ms, brake):
                    self._taken = sequence
                    self._valid_until = self._time_s + timeout_ms / 1000.0
                    self._brake = brake
                    self._goal_mps = self._wheels_of(linear / 1000.0, angular / 1000.0)
                case _:
                    pass  # a base is sent no others

    def step(self, seconds: float) -> None:
        """Let ``seconds`` pass: approach what was commanded; without a valid command, or with a fault, brake."""
        self._time_s += seconds
        silent = self._time_s > self._valid_until
        self.faults = self.faults | Fault.SILENT if silent else self.faults & ~Fault.SILENT
        stopping = silent or bool(self.faults & protocol.STOPPING)
        goal = (0.0, 0.0) if stopping else self._goal_mps
        brake = stopping or self._brake
        most = (self.setting.brake_mps2 if brake else self.setting.ramp_mps2) * seconds
        left, right = (_approach(now, to, most) for now, to in zip(self.wheels_mps, goal, strict=True))
        self.wheels_mps = (left, right)
        if self._time_s - self._said_state >= 1.0 / self.setting.state_hz - 1e-9:
            self._said_state = self._time_s
            self._say(self._state())
        if self._time_s - self._said_battery >= 1.0:
            self._said_battery = self._time_s
            self._say(self._battery())

    def rolled(self, left_m: float, right_m: float) -> None:
        """The wheels have turned by so much."""
        self._counts[0] += left_m * self.setting.ticks_per_m
        self._counts[1] += right_m * self.setting.ticks_per_m

    def outgoing(self) -> bytes:
        """What is to be sent, and forget it."""
        data = bytes(self._outgoing)
        self._outgoing.clear()
        return data

    def _wheels_of(self, linear: float, angular: float) -> tuple[float, float]:
        linear = min(max(linear, -self.setting.linear_mps), self.setting.linear_mps)
        angular = min(max(angular, -self.setting.angular_radps), self.setting.angular_radps)
        half = angular * self.setting.track_m / 2
        return linear - half, linear + half

    def _say(self, frame: Frame) -> None:
        self._sequence += 1
        self._outgoing += protocol.encode(frame, self._sequence)

    def _identity(self) -> protocol.Identity:
        setting = self.setting
        return protocol.Identity(
            protocol.VERSION,
            self.boot,
            linear_mmps=round(1000 * setting.linear_mps),
            angular_mradps=round(1000 * setting.angular_radps),
            ticks_per_m=setting.ticks_per_m,
            track_um=round(1e6 * setting.track_m),
            name=setting.name,
        )

    def _state(self) -> protocol.State:
        left, right = (_signed(int(count)) for count in self._counts)
        return protocol.State(round(1e6 * self._time_s) % 2**32, left, right, taken=self._taken, faults=self.faults)

    def _battery(self) -> protocol.Battery:
        return protocol.Battery(
            millivolts=round(11000 + 1600 * self.charge), milliamperes=-800, percent=round(100 * self.charge),
            charging=False,
        )  # fmt: skip


def _approach(value: float, target: float, most: float) -> float:
    return min(max(target, value - most), value + most)


def _signed(count: int) -> int:
    return (count + 2**31) % 2**32 - 2**31
