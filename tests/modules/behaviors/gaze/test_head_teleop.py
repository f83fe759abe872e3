"""HeadTeleop by itself: speeds by sticks, limits, and that whatever ends a hold ends the motion."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.messages import JointCommand, JointState, TeleopCommand
from app.modules.behaviors.gaze.head_teleop import driven_position
from app.runtime.clock import in_virtual_time
from tests.modules.behaviors.gaze.head_bench import HEAD, NAMES, bench_of
from tests.modules.fakes import Bench, drain

PAN, TILT = HEAD.joints


def bench() -> Bench:
    return bench_of("head_teleop:HeadTeleop", {"operator": TeleopCommand})


async def turned(
    b: Bench, seconds: float, pan: float, tilt: float = 0.0, *, held: bool = True, stuck: bool = False
) -> list[JointCommand]:
    """What it commands while the sticks are so; the joints are always where they were commanded, or ``stuck``."""
    given, commands = b.listen("command"), []
    for number in range(round(seconds / 0.05)):
        now = b.clock.now()
        b.feed("operator", TeleopCommand(now, "ada", number, False, 0.0, 0.0, head_held=held, pan=pan, tilt=tilt))
        await b.clock.sleep(0.05)
        for command in drain(given):
            commands.append(command)
            at = (0.0, 0.0) if stuck else command.positions
            b.feed("joints", JointState(b.clock.now(), NAMES, at))
    b.graph.channel("command").unsubscribe(given)
    return commands


async def ready(b: Bench, speed: float = 1.0) -> None:
    b.graph.configure("Tested", {"speed": speed})
    b.graph.filters.apply({"Tested.command": 1})
    b.feed("joints", JointState(b.clock.now(), NAMES, (0.0, 0.0)))
    await b.settle()


@in_virtual_time
async def test_full_stick_is_the_joints_speed_and_the_desire_takes_a_share_of_it() -> None:
    async with bench() as b:
        await ready(b)
        pan, tilt = (await turned(b, 1.0, 1.0, -0.1))[-1].positions
        assert pan == pytest.approx(PAN.velocity, rel=0.1)
        assert tilt == pytest.approx(-0.1 * TILT.velocity, rel=0.1)
        b.graph.configure("Tested", {"speed": 0.5})
        slower = (await turned(b, 1.0, -1.0))[-1].positions[0]
        assert pan - slower == pytest.approx(0.5 * PAN.velocity, rel=0.15)


@in_virtual_time
async def test_it_goes_to_the_limits_and_no_further() -> None:
    async with bench() as b:
        await ready(b)
        assert (await turned(b, 4.0, 1.0, 1.0))[-1].positions == pytest.approx((PAN.upper, TILT.upper))


@in_virtual_time
async def test_a_release_ends_it_at_once() -> None:
    async with bench() as b:
        await ready(b)
        moved = (await turned(b, 0.5, 1.0))[-1].positions[0]
        last = await turned(b, 0.5, 1.0, held=False)
        assert len(last) == 1
        assert last[0].positions[0] == pytest.approx(moved, abs=0.05)


@in_virtual_time
async def test_silence_ends_it_too(caplog: pytest.LogCaptureFixture) -> None:
    async with bench() as b:
        await ready(b)
        await turned(b, 0.5, 1.0)
        silent = b.listen("command")
        begin = b.clock.now()
        await b.clock.sleep(2.0)
        assert max(command.stamp for command in drain(silent)) - begin < 0.35
        assert [r.getMessage() for r in caplog.records if "nothing came from the operator" in r.getMessage()]


@in_virtual_time
async def test_commanded_positions_do_not_run_away_from_a_head_that_is_held() -> None:
    async with bench() as b:
        await ready(b)
        assert (await turned(b, 3.0, 1.0, stuck=True))[-1].positions[0] == pytest.approx(0.25)


@in_virtual_time
async def test_numbers_that_are_none_turn_nothing() -> None:
    async with bench() as b:
        await ready(b)
        assert await turned(b, 0.5, math.nan) == []


@in_virtual_time
async def test_while_attention_keeps_it_closed_the_head_stays() -> None:
    async with bench() as b:
        b.feed("joints", JointState(b.clock.now(), NAMES, (0.0, 0.0)))
        assert await turned(b, 0.5, 1.0) == []


@in_virtual_time
async def test_a_body_without_the_joint_is_refused() -> None:
    async with bench_of("head_teleop:HeadTeleop", {"operator": TeleopCommand}, pan="neck") as b:
        assert "turns the joint 'neck'" in b.problem
        assert "pan_joint, tilt_joint" in b.problem


@given(st.floats(-3, 3), st.floats(-2.2, 2.2), st.floats(-0.1, 0.1))
def test_a_commanded_position_is_within_limits_and_near_the_joint(
    position: float, measured: float, rate: float
) -> None:
    found = driven_position(position, measured, rate, PAN, 0.25)
    assert PAN.lower <= found <= PAN.upper
    assert abs(found - measured) <= 0.25 + 1e-9
