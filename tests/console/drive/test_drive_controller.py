"""What carries out the lease's decisions: commands on the channel, the emergency stop and its release, a lost body."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal

import pytest

from app.console.access.identity import Identity
from app.console.access.roles import Role
from app.console.drive import drive_lease
from app.console.drive.command_age import Judgement
from app.console.drive.drive_controller import LOST, NOT_YOURS, PRESSED_AGAIN, Driving
from app.messages import TeleopCommand
from app.program.system import System
from app.runtime.clock import VirtualClock, in_virtual_time
from tests.console.program import Body, build

LATE = Judgement("Commands arrive up to 3.0 s late", 3.0, lasting=True)
IN_TIME = Judgement(age_s=0.05)


class Wheel:
    """Ann's and Bob's pages at a body's wheel, and what became of what they said."""

    def __init__(self, system: System, body: Body) -> None:
        self.clock, self.link = system.clock, body
        self.notices: list[tuple[str, str]] = []
        self.commands: list[TeleopCommand] = []
        self.withdrawn = 0
        channel = system.graph.channel("teleop_command")
        channel.observe(self.commands.append)
        self.driving = Driving(system.clock, body, channel, self._notify, self._withdraw)
        for session, name in (("a", "Ann"), ("b", "Bob")):
            self.driving.handle(drive_lease.Connected(session, name))

    def _notify(self, session: str, level: Literal["info", "warning", "error"], text: str) -> None:
        self.notices.append((session, text))

    def _withdraw(self) -> None:
        self.withdrawn += 1

    def drive(self, sequence: int, *, held: bool = True) -> None:
        """Ann's drive commands."""
        self.driving.handle(drive_lease.Drive("a", sequence, held, 1.0 if held else 0.0, 0.0))

    @property
    def held(self) -> list[bool]:
        """Of each command that went out."""
        return [command.held for command in self.commands]


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """A program on a virtual clock, not running."""
    return build(tmp_path, clock=VirtualClock())


def test_a_stop_is_released_by_a_page_that_has_seen_it_and_in_time(built: tuple[System, Body]) -> None:
    @in_virtual_time
    async def story() -> None:
        wheel = Wheel(*built)
        driving, now = wheel.driving, wheel.clock.now
        before = now()
        await wheel.clock.sleep(1.0)
        driving.e_stop("Bob", "b")
        pressed = now()
        await wheel.clock.sleep(1.0)
        for judged, seen, words in (
            (LATE, now(), f"{LATE.cause}: the emergency stop stays latched."),
            (IN_TIME, before, PRESSED_AGAIN),
            (IN_TIME, pressed, PRESSED_AGAIN),
            (Judgement("No time"), None, "No time: the emergency stop stays latched."),
        ):
            driving.release_e_stop("a", judged, seen)
            assert wheel.notices.pop() == ("a", words)
            assert wheel.link.e_stopped
        driving.release_e_stop("a", IN_TIME, now())
        assert not wheel.link.e_stopped
        assert wheel.notices == []
        # Ann's release is under way while Bob presses again: his stop is newer than what she saw.
        driving.e_stop("Bob", "b")
        seen = now()
        await wheel.clock.sleep(0.1)
        driving.e_stop("Bob", "b")
        driving.release_e_stop("a", IN_TIME, seen)
        assert wheel.link.e_stopped
        driving.close()

    story()


def test_a_stop_at_the_body_itself_counts_as_pressed(built: tuple[System, Body]) -> None:
    @in_virtual_time
    async def story() -> None:
        wheel = Wheel(*built)
        seen = wheel.clock.now()
        await wheel.clock.sleep(0.1)
        wheel.link.receivers["status"].append(wheel.driving.on_guard_status)
        wheel.link.e_stopped = True
        wheel.link.emit_status(wheel.clock.now())
        wheel.driving.release_e_stop("a", IN_TIME, seen)
        assert wheel.link.e_stopped
        assert not wheel.driving.clear_e_stop(-math.inf)
        assert wheel.driving.clear_e_stop(wheel.clock.now() + 0.01)

    story()


def test_who_comes_late_is_not_given_the_wheel(built: tuple[System, Body]) -> None:
    @in_virtual_time
    async def story() -> None:
        wheel = Wheel(*built)
        wheel.drive(1)
        wheel.driving.take_control("b", LATE)
        assert wheel.driving.lease.driver == "a"
        assert wheel.notices == [("b", f"{LATE.cause}: the wheel stays where it is.")]
        wheel.driving.take_control("b", IN_TIME)
        assert wheel.driving.lease.driver == "b"
        wheel.driving.close()

    story()


def test_between_two_drivers_the_channel_has_a_zero_and_an_answer_that_does_not_come_is_awaited_5_s(
    built: tuple[System, Body],
) -> None:
    @in_virtual_time
    async def story() -> None:
        wheel = Wheel(*built)
        driving = wheel.driving
        wheel.drive(1)
        driving.ask_control("b", LATE)
        assert driving.lease.asker is None
        driving.ask_control("b", IN_TIME)
        driving.handle(drive_lease.AnswerControl("a", True))
        driving.handle(drive_lease.Drive("b", 1, True, -1.0, 0.0))
        assert [(each.operator, each.held) for each in wheel.commands] == [("Ann", True), ("Ann", False), ("Bob", True)]
        driving.handle(drive_lease.Drive("b", 2, False, 0.0, 0.0))
        driving.ask_control("a", IN_TIME)
        for _ in range(9):
            await wheel.clock.sleep(0.5)
            driving.handle(drive_lease.KeepAlive("b"))
        assert driving.lease.driver == "b"
        await wheel.clock.sleep(0.6)
        assert driving.lease.driver == "a", "the timer came, and nothing was held"
        driving.close()

    story()


def test_a_stop_is_released_by_the_only_login_that_pressed_it_or_a_supervisor(built: tuple[System, Body]) -> None:
    @in_virtual_time
    async def story() -> None:
        wheel = Wheel(*built)
        driving, clock = wheel.driving, wheel.clock
        ann, bob, boss, onlooker = (
            Identity(role, key)
            for role, key in (
                (Role.OPERATOR, "ann"),
                (Role.OPERATOR, "bob"),
                (Role.SUPERVISOR, "boss"),
                (Role.SPECTATOR, "onlooker"),
            )
        )
        driving.e_stop("Ann", "a", ann)
        await clock.sleep(0.1)
        driving.release_e_stop("b", IN_TIME, clock.now(), bob)
        assert wheel.notices.pop() == ("b", NOT_YOURS)
        assert wheel.link.e_stopped
        driving.release_e_stop("a", IN_TIME, clock.now(), ann)
        assert not wheel.link.e_stopped
        driving.e_stop("a page", by=onlooker)
        assert not driving.may_release(onlooker), "who only watches sets nothing in motion"
        assert driving.may_release(boss)
        driving.clear_e_stop(clock.now() + 0.1)
        wheel.link.receivers["status"].append(driving.on_guard_status)
        wheel.link.e_stopped = True
        wheel.link.emit_status(clock.now())
        assert not driving.may_release(ann), "it was pressed at the robot"
        driving.close()

    story()


def test_a_lost_body_ends_the_hold_and_withdraws_what_was_wanted(built: tuple[System, Body]) -> None:
    @in_virtual_time
    async def story() -> None:
        wheel = Wheel(*built)
        wheel.drive(1)
        wheel.driving.body(lost=True)
        assert wheel.held == [True, False]
        assert wheel.notices == [("a", f"{LOST}: driving waits.")]
        assert wheel.withdrawn == 1
        wheel.drive(2)
        wheel.driving.body(lost=False)
        assert wheel.withdrawn == 2, "nor what was wanted meanwhile"
        wheel.drive(3)
        assert wheel.held == [True, False], "the key was down all the while"
        wheel.drive(4, held=False)
        wheel.drive(5)
        assert wheel.held == [True, False, True]
        # A driver that held nothing when the body was lost need not let go of anything.
        wheel.drive(6, held=False)
        wheel.driving.body(lost=True)
        wheel.driving.body(lost=False)
        wheel.drive(7)
        assert wheel.held[-1] is True
        wheel.driving.close()

    story()
