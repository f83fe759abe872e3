"""A gamepad at the robot: it drives by the lease, stops by its release, its silence and its plug, and stops all by its
button."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import cast

import pytest

from app.console.drive import drive_lease
from app.console.drive.drive_controller import Driving
from app.console.drive.gamepad import OPERATOR, GamepadDriver
from app.link import RobotLink, StreamDescription
from app.messages import GamepadState, TeleopCommand
from app.program.system import System
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.console.program import Body, build


class AtTheRobot:
    """A gamepad, and Ann's page beside it."""

    def __init__(self, system: System, body: Body) -> None:
        self.clock, self.body = system.clock, body
        self.commands: list[TeleopCommand] = []
        channel = system.graph.channel("teleop_command")
        channel.observe(self.commands.append)
        self.driving = Driving(system.clock, body, channel, lambda *_: None, lambda: None)
        self.driving.handle(drive_lease.Connected("a", "Ann"))
        self.gamepad = GamepadDriver(self.driving, system.clock.now)

    def say(self, *, held: bool, linear: float = 0.0, stop: bool = False, age_s: float = 0.0) -> None:
        """A report of the gamepad."""
        stamp = self.clock.now() - age_s
        self.gamepad.take(GamepadState(stamp, connected=True, held=held, stop=stop, linear=linear))

    def unplug(self) -> None:
        """Its last word."""
        self.gamepad.take(GamepadState(self.clock.now(), connected=False, held=False, stop=False))

    @property
    def newest(self) -> tuple[str, bool, float]:
        """Who commanded last, whether it was held, and how far forward."""
        last = self.commands[-1]
        return last.operator, last.held, last.linear


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """A program on a virtual clock, not running."""
    return build(tmp_path, clock=VirtualClock())


def test_it_drives_while_its_dead_man_is_held_and_stops_when_unplugged(built: tuple[System, Body]) -> None:
    @in_virtual_time
    async def story() -> None:
        at = AtTheRobot(*built)
        at.say(held=False, linear=1.0)
        assert not at.commands  # a stick without the dead-man moves nothing
        at.say(held=True, linear=0.5)
        assert at.newest == (OPERATOR, True, 0.5)
        assert at.driving.lease.driver_name == OPERATOR
        at.say(held=False, linear=0.5)
        assert at.newest == (OPERATOR, False, 0.0)
        at.say(held=True, linear=0.5)
        at.unplug()
        assert at.newest == (OPERATOR, False, 0.0)
        assert at.driving.lease.driver is None
        assert "gamepad" not in at.driving.lease.operators

    story()


def test_its_silence_and_what_is_late_end_a_hold(built: tuple[System, Body]) -> None:
    @in_virtual_time
    async def story() -> None:
        at = AtTheRobot(*built)
        at.say(held=True, linear=0.5)
        await at.clock.sleep(drive_lease.HOLD_GAP_S + 0.05)
        assert at.newest == (OPERATOR, False, 0.0)
        at.say(held=True, linear=0.5)
        assert at.newest == (OPERATOR, True, 0.5)
        at.say(held=True, linear=0.5, age_s=0.3)
        assert at.newest == (OPERATOR, False, 0.0)
        at.say(held=True, linear=0.5)
        assert at.newest == (OPERATOR, False, 0.0)  # it has to be released once
        at.say(held=False)
        at.say(held=True, linear=0.5)
        assert at.newest == (OPERATOR, True, 0.5)
        at.driving.close()

    story()


def test_a_page_that_drives_keeps_the_wheel_and_the_button_stops_both(built: tuple[System, Body]) -> None:
    @in_virtual_time
    async def story() -> None:
        at = AtTheRobot(*built)
        at.driving.handle(drive_lease.Drive("a", 1, True, 0.7, 0.0))
        at.say(held=True, linear=-1.0)
        assert at.newest == ("Ann", True, 0.7)
        at.say(held=False, stop=True)
        assert at.body.e_stopped
        at.say(held=False, stop=True)  # still pressed: it is pressed once
        assert at.driving.clear_e_stop(at.clock.now() + 1.0)
        at.say(held=False, stop=True)
        assert not at.body.e_stopped
        at.say(held=False)
        at.say(held=True, linear=1.0, stop=True)  # it wins over the dead-man beside it
        assert at.body.e_stopped
        at.driving.close()

    story()


class Listened:
    """A body with the streams ``names``, as far as a gamepad's driver sees one."""

    def __init__(self, body: Body, *names: str) -> None:
        streams = {name: StreamDescription(name, GamepadState, 20.0) for name in names}
        self.description = replace(body.description, streams=streams)
        self.receive: Callable[[GamepadState], None] | None = None
        self.demanded: list[float] = []

    def attach(self, stream: str, receive: Callable[[GamepadState], None]) -> Callable[[], None]:
        assert stream in self.description.streams
        self.receive = receive
        return lambda: setattr(self, "receive", None)

    def demand(self, stream: str, rate_hz: float) -> None:
        self.demanded.append(rate_hz)


def test_it_listens_to_a_body_that_has_one_and_leaves_others_alone(built: tuple[System, Body]) -> None:
    system, body = built
    at = AtTheRobot(system, body)
    link = Listened(body, "gamepad")
    end = at.gamepad.attach(cast("RobotLink", link))
    assert link.receive is not None
    link.receive(GamepadState(system.clock.now(), connected=True, held=False, stop=False))
    assert at.driving.lease.operators["gamepad"] == OPERATOR
    end()
    assert link.receive is None
    assert link.demanded == [20.0, 0.0]
    at.gamepad.attach(cast("RobotLink", Listened(body)))()
