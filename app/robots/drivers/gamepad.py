"""A gamepad at the robot: its events become the state of sticks, dead-man and stop."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from app.messages import GamepadState
from app.robots.drivers import input_events
from app.robots.drivers.device import Reading
from app.robots.drivers.input_events import AXES, BUTTONS, EventReader, InputEvent

#: How often (s) its state is said while the dead-man is held, and while it is not.
HELD_S, RESTING_S = 0.05, 0.5


@dataclass(frozen=True, slots=True)
class GamepadSetting:
    """Names of buttons and axes (linux/input-event-codes.h); "" for an axis that there is not. ``invert``: axes that
    count the other way; else forward is up, left is left, as sticks count down and right. ``rest``: the share of a
    stick's way that counts as none."""

    dead_man: str = "BTN_TL"
    stop: str = "BTN_EAST"
    linear: str = "ABS_Y"
    angular: str = "ABS_RX"
    lateral: str = ""
    invert: tuple[str, ...] = ()
    rest: float = 0.1


class Gamepad:
    """The gamepad at a port. ``ranges``: least and greatest value of each axis, by name."""

    def __init__(self, name: str, setting: GamepadSetting) -> None:
        self.name = name
        self.cautions: list[str] = []
        self.ranges: Mapping[str, tuple[int, int]] = {}
        self._setting = setting
        self._begin()

    def _begin(self) -> None:
        self._reader = EventReader()
        self._held: set[int] = set()
        self._axes: dict[int, int] = {}
        #: Events were lost: what is held is not known until the next report, and the dead-man must be pressed again.
        self._lost = False
        self._said = float("-inf")

    @property
    def ready(self) -> bool:
        return True

    def opened(self, now: float) -> None:
        self._begin()

    def closed(self, now: float) -> Iterable[Reading]:
        """It holds nothing any more."""
        self._begin()
        return (("gamepad", GamepadState(now, connected=False, held=False, stop=False)),)

    def received(self, data: bytes, now: float) -> Iterable[Reading]:
        """Its state after each report in ``data``."""
        readings: list[Reading] = []
        for event in self._reader.feed(data):
            match event:
                case InputEvent(type=input_events.SYN, code=input_events.DROPPED):
                    self._lost = True
                    self._held.clear()
                    self._axes.clear()
                case InputEvent(type=input_events.SYN, code=input_events.REPORT):
                    self._lost = False
                    readings.append(("gamepad", self._state(now)))
                case _ if self._lost:
                    pass
                case InputEvent(type=input_events.KEY, code=code, value=value):
                    (self._held.add if value else self._held.discard)(code)
                case InputEvent(type=input_events.ABS, code=code, value=value):
                    self._axes[code] = value
        return readings

    def step(self, now: float) -> tuple[bytes, Iterable[Reading]]:
        """A stick that is held still gives no events: its state is said again."""
        dead_man = BUTTONS[self._setting.dead_man] in self._held
        if now - self._said < (HELD_S if dead_man else RESTING_S):
            return b"", ()
        return b"", (("gamepad", self._state(now)),)

    def problem(self, now: float) -> str:
        """None: a robot drives without a gamepad."""
        return ""

    def _state(self, now: float) -> GamepadState:
        self._said = now
        setting = self._setting
        return GamepadState(
            now,
            connected=True,
            held=BUTTONS[setting.dead_man] in self._held,
            stop=bool(setting.stop) and BUTTONS[setting.stop] in self._held,
            linear=self._stick(setting.linear),
            angular=self._stick(setting.angular),
            lateral=self._stick(setting.lateral),
        )

    def _stick(self, axis: str) -> float:
        """Where a stick is, -1 to 1: forward and left positive."""
        value = self._axes.get(AXES[axis]) if axis else None
        if value is None:
            return 0.0
        least, most = self.ranges.get(axis, input_events.USUAL_RANGE)
        share = min(max(2.0 * (value - least) / (most - least) - 1.0, -1.0), 1.0)
        away = max(abs(share) - self._setting.rest, 0.0) / (1.0 - self._setting.rest)
        left_or_up = -away if share > 0 else away
        return -left_or_up if axis in self._setting.invert else left_or_up
