"""A differential base at a port, which speaks the protocol of docs/serial-base.md."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from app.base.geometry import Pose2
from app.messages import BatteryState, JointState, Odometry
from app.robots.drivers import base_protocol as protocol
from app.robots.drivers.base_protocol import Fault, Identity, State, Velocity
from app.robots.drivers.device import DeviceLost, Reading, WrongDevice, shown
from app.robots.drivers.device_clock import DeviceClock
from app.robots.drivers.wheel_counts import WheelGeometry, WheelPath, followed, restarted
from app.robots.guard import BaseVelocity

#: Time (s) that a base has to say who it is: a board that resets when its port is opened takes its time.
ANSWER_S = 4.0
HELLO_S = 0.25
#: Without a STATE for so long (s) its port is opened again.
SILENT_S = 1.0
#: Commands must have been taken within so long (s).
UNHEARD_S = 0.3
_MOST_HEARD = 256
_SHORT = 32767


@dataclass(frozen=True, slots=True)
class BaseSetting:
    """``timeout_s``: how long the base follows a command; ``ticks_per_m`` and ``track_m`` in place of those that it
    says, None for those; ``wheels``: the model's joints (left, right) and ``wheel_radius_m``, which turns counts into
    their angles."""

    timeout_s: float
    ticks_per_m: float | None = None
    track_m: float | None = None
    wheels: tuple[str, str] | None = None
    wheel_radius_m: float = 0.1


class SerialBase:
    """The base at a port; ``velocity`` and ``brake`` are what it is commanded when that is ``due``."""

    def __init__(self, name: str, setting: BaseSetting) -> None:
        self.name = name
        self.cautions: list[str] = []
        self.velocity = BaseVelocity()
        self.brake = True
        self.due = False
        self.identity: Identity | None = None
        self._setting = setting
        self._path = WheelPath(Pose2())
        self._boot: int | None = None
        self._again = True
        self._faults = Fault(0)
        self._begin(0.0)

    def _begin(self, now: float) -> None:
        self._reader = protocol.FrameReader()
        self._clock = DeviceClock(1e6, 2**32)
        self.identity = None
        self._since = now
        self._hello = float("-inf")
        self._heard = b""
        self._heard_frame = False
        self._last_state: float | None = None
        self._sequence = 0
        self._taken: int | None = None
        #: When a command was sent that is not known to be taken, None where none is.
        self._unheard: float | None = None
        self._said_garbled = False

    @property
    def ready(self) -> bool:
        return self.identity is not None

    def opened(self, now: float) -> None:
        self._begin(now)

    def closed(self, now: float) -> Iterable[Reading]:
        self.identity = None
        return ()

    def received(self, data: bytes, now: float) -> Iterable[Reading]:
        """Odometry, joints and battery in ``data``."""
        if not self._heard_frame:
            self._heard = (self._heard + data)[:_MOST_HEARD]
        readings: list[Reading] = []
        for frame, _ in self._reader.feed(data):
            self._heard_frame = True
            match frame:
                case Identity():
                    self._identify(frame)
                case State() if self.identity is not None:
                    readings += self._follow(frame, now)
                case protocol.Battery() if frame.percent is not None:
                    readings.append(("battery", _battery(frame, now)))
                case protocol.Text(text):
                    self.cautions.append(f"it says: {text}")
        if self._reader.garbled and self._heard_frame and not self._said_garbled:
            self._said_garbled = True
            self.cautions.append("frames with a wrong CRC are dropped: look at its cable")
        return readings

    def step(self, now: float) -> tuple[bytes, Iterable[Reading]]:
        """The command of this moment, or the question who it is."""
        if self.identity is not None:
            silent_s = now - (self._since if self._last_state is None else self._last_state)
            if silent_s > SILENT_S:
                raise DeviceLost(f"it has said nothing for {SILENT_S:g} s")
            if not self.due:
                return b"", ()
            self.due = False
            return self._command(now), ()
        if now - self._since > ANSWER_S:
            if self._heard_frame:
                raise DeviceLost("it does not say who it is")
            raise WrongDevice(f"no base answers (docs/serial-base.md): {shown(self._heard)}")
        if now - self._hello < HELLO_S:
            return b"", ()
        self._hello = now
        # The end of a frame first: what an earlier program sent half of is then over.
        return protocol.END + self._encoded(protocol.Hello()), ()

    def problem(self, now: float) -> str:
        """Why it does not drive, by its own word, or because it hears nothing."""
        if self.identity is None:
            return "it has not said who it is yet"
        for fault, words in protocol.WORDS.items():
            if fault & self._faults & protocol.STOPPING:
                return words
        if self._unheard is not None and now - self._unheard > UNHEARD_S:
            return "it does not take the commands that it is sent"
        return ""

    def _identify(self, identity: Identity) -> None:
        if identity.version != protocol.VERSION:
            raise WrongDevice(
                f"{identity.name!r} speaks version {identity.version} of the protocol; this program {protocol.VERSION}"
            )
        if min(identity.ticks_per_m, identity.track_um) <= 0 and not (
            self._setting.ticks_per_m and self._setting.track_m
        ):
            raise WrongDevice(f"{identity.name!r} does not say its counts of a metre or its track; set them")
        if self._boot is not None and self._boot != identity.boot:
            self.cautions.append("it began again: what its wheels did meanwhile is not known")
            self._clock = DeviceClock(1e6, 2**32)
        # Counts of the same run go on over a gap: no way is lost.
        self._again = self._again or self._boot != identity.boot
        self._boot, self.identity = identity.boot, identity

    @property
    def _geometry(self) -> WheelGeometry:
        assert self.identity is not None
        return WheelGeometry(
            self._setting.ticks_per_m or float(self.identity.ticks_per_m),
            self._setting.track_m or self.identity.track_um / 1e6,
            max(self.identity.linear_mmps / 1000.0, 0.1),
        )

    def _follow(self, state: State, now: float) -> list[Reading]:
        self._last_state = now
        stamp = self._clock.placed(state.time_us, now)
        path = None
        if not self._again:
            path = followed(self._path, self._geometry, left=state.left, right=state.right, stamp=stamp)
            if path is None:
                self.cautions.append("its counts jumped: what its wheels did meanwhile is not known")
        self._path = path or restarted(self._path, state.left, state.right, stamp)
        self._again = False
        self._say(state)
        if state.taken != self._taken:
            self._taken, self._unheard = state.taken, None
        at = self._path
        odometry = Odometry(stamp, at.pose, at.linear_mps, at.angular_radps)
        readings: list[Reading] = [("odometry", odometry)]
        if self._setting.wheels is not None:
            angles = (at.left_m / self._setting.wheel_radius_m, at.right_m / self._setting.wheel_radius_m)
            readings.append(("joints", JointState(stamp, self._setting.wheels, angles)))
        return readings

    def _say(self, state: State) -> None:
        """Say once what is new among its faults."""
        if (new := state.faults & ~self._faults) & Fault.LOW_BATTERY:
            self.cautions.append(protocol.WORDS[Fault.LOW_BATTERY])
        for fault, words in protocol.WORDS.items():
            if fault & new & protocol.STOPPING:
                self.cautions.append(f"{words}: it has stopped")
        self._faults = state.faults

    def _command(self, now: float) -> bytes:
        velocity = self.velocity
        if self._unheard is None:
            self._unheard = now
        return self._encoded(
            Velocity(
                _whole(1000.0 * velocity.linear_mps),
                _whole(1000.0 * velocity.angular_radps),
                timeout_ms=round(1000.0 * self._setting.timeout_s),
                brake=self.brake,
            )
        )

    def _encoded(self, frame: protocol.Frame) -> bytes:
        self._sequence = (self._sequence + 1) % 256
        return protocol.encode(frame, self._sequence)


def _whole(value: float) -> int:
    return max(-_SHORT, min(round(value), _SHORT))


def _battery(frame: protocol.Battery, now: float) -> BatteryState:
    assert frame.percent is not None
    return BatteryState(
        now,
        charge=frame.percent / 100.0,
        voltage_v=frame.millivolts / 1000.0,
        current_a=frame.milliamperes / 1000.0,
        charging=frame.charging,
        remaining_s=None,
    )
