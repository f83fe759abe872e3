"""A gamepad at the robot drives by the same lease as the pages: one driver at a time.

It takes the wheel from no other: while a page drives, its dead-man is refused. Its stop button stops the robot,
whichever of them drives. It asks for nothing and answers nothing, so that a page that asks for the wheel has it once
the gamepad holds nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

from app.console.drive.drive_controller import Driving
from app.console.drive.drive_lease import Connected, Disconnected, Drive
from app.link import RobotLink
from app.messages import GamepadState

STREAM = "gamepad"
#: The gamepad's session and name in the lease.
SESSION, OPERATOR = "gamepad", "Gamepad on the robot"
#: A state that is older (s) moves nothing.
VALIDITY_S = 0.2
LATE = "What the gamepad says comes late"
_RATE_HZ = 20.0


class GamepadDriver:
    """Gives what the gamepad of a body does to ``driving``; ``now()`` is the robot's clock (s)."""

    def __init__(self, driving: Driving, now: Callable[[], float]) -> None:
        self._driving = driving
        self._now = now
        self._connected = False
        self._stopping = False
        self._sequence = 0

    def attach(self, link: RobotLink) -> Callable[[], None]:
        """Listen to the body's gamepad, if it has one; returns a function that ends it."""
        if STREAM not in link.description.streams:
            return lambda: None
        ending = ExitStack()
        ending.callback(link.attach(STREAM, self.take))
        ending.callback(link.demand, STREAM, 0.0)
        link.demand(STREAM, _RATE_HZ)
        return ending.close

    def take(self, state: GamepadState) -> None:
        """Its newest state."""
        if state.connected != self._connected:
            self._connected = state.connected
            self._driving.handle(Connected(SESSION, OPERATOR) if state.connected else Disconnected(SESSION))
        if not state.connected:
            self._stopping = False
            return
        if state.stop and not self._stopping:
            self._driving.e_stop(OPERATOR)
        self._stopping = state.stop
        self._sequence += 1
        late = self._now() - state.stamp > VALIDITY_S
        self._driving.handle(
            Drive(
                SESSION,
                self._sequence,
                state.held and not state.stop,
                state.linear,
                state.angular,
                cause=LATE if late else "",
                lasting=late,
                lateral=state.lateral,
            )
        )
