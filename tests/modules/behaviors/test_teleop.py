from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.link import BaseLimits
from app.messages import TeleopCommand, Twist
from app.modules.behaviors.drive_gate import DriveGate
from app.runtime.clock import run_virtual
from tests.modules.fakes import LIMITS, Bench, drain

STICK = st.floats(-1, 1)


def drive(
    stamp: float, sequence: int, linear: float = 0.0, angular: float = 0.0, held: bool = True, operator: str = "anne"
) -> TeleopCommand:
    return TeleopCommand(stamp, operator, sequence, held, linear, angular)


@given(STICK, STICK, st.floats(0.01, 1))
def test_a_held_stick_gives_its_share_of_the_limits(linear: float, angular: float, speed: float) -> None:
    twist = DriveGate(LIMITS).take(drive(10.0, 0, linear, angular), speed).twist
    assert twist == Twist(10.0, speed * linear * 0.4, speed * angular * 1.0)


def test_full_stick_to_a_corner_is_a_direction_and_no_greater_speed() -> None:
    gate = DriveGate(BaseLimits(0.4, 1.0, 0.4, 4.0, lateral_mps=0.2))
    twist = gate.take(replace(drive(10.0, 0, 1.0), lateral=-1.0), 0.5).twist
    assert twist is not None
    half = 0.5 / math.sqrt(2)
    assert (twist.linear_mps, twist.lateral_mps) == pytest.approx((half * 0.4, -half * 0.2))
    differential = DriveGate(LIMITS).take(replace(drive(10.0, 0, 1.0), lateral=-1.0)).twist
    assert differential == Twist(10.0, 0.4, 0.0), "a base that cannot move sideways goes ahead"


def test_release_stops_at_once() -> None:
    gate = DriveGate(LIMITS)
    gate.take(drive(10.0, 0, 1.0))
    assert gate.take(drive(10.05, 1, 1.0, held=False)).twist == Twist(10.05, 0.0, 0.0)
    assert gate.beat(20.0).twist is None, "once stopped, silence is nothing new"


def test_silence_while_held_stops_once() -> None:
    gate = DriveGate(LIMITS, timeout_s=0.25)
    gate.take(drive(10.0, 0, 1.0))
    stops = {}
    for step in range(1, 100):
        now = 10.0 + step * 0.01
        decision = gate.beat(now)
        if decision.twist is not None:
            stops[now] = decision
    (stamp,) = stops
    assert stamp == pytest.approx(10.25, abs=0.011)
    assert stops[stamp].twist == Twist(stamp, 0.0, 0.0)
    assert "nothing came from the operator" in stops[stamp].problem


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1.01, -2.0])
@pytest.mark.parametrize("axis", ["linear", "angular", "lateral"])
def test_what_no_stick_can_say_is_refused_and_stops(bad: float, axis: str) -> None:
    gate = DriveGate(LIMITS)
    gate.take(drive(10.0, 0, 1.0))
    stick: dict[str, Any] = {axis: bad}
    decision = gate.take(replace(drive(10.05, 1), **stick))
    assert decision.twist == Twist(10.05, 0.0, 0.0)
    assert "from -1 to 1" in decision.problem


def test_sequence_numbers_that_go_back_are_ignored_but_for_a_stop() -> None:
    gate = DriveGate(LIMITS)
    gate.take(drive(10.0, 5, 1.0))
    assert gate.take(drive(10.01, 5, 0.5)).twist is None
    assert gate.take(drive(10.02, 4, 0.5)).twist is None
    assert gate.take(drive(10.03, 3, held=False)).twist == Twist(10.03, 0.0, 0.0)
    assert gate.take(drive(10.04, 5, 1.0)).twist is None
    assert gate.take(drive(10.05, 0, 1.0, operator="bob")).twist is not None, "another operator counts afresh"


@given(st.lists(st.tuples(STICK, STICK, st.booleans(), st.floats(0, 0.5)), max_size=30))
def test_never_beyond_the_limits_and_never_moving_unheld(commands: list[tuple[float, float, bool, float]]) -> None:
    gate = DriveGate(BaseLimits(0.3, 0.8, 1, 1))
    now = 10.0
    current = Twist(now, 0.0, 0.0)
    held_at = -math.inf
    for sequence, (linear, angular, held, gap) in enumerate(commands):
        now += gap
        current = gate.beat(now).twist or current
        if now - held_at >= gate.timeout_s:
            assert (current.linear_mps, current.angular_radps) == (0.0, 0.0)
        held_at = now if held else -math.inf
        current = gate.take(drive(now, sequence, linear, angular, held)).twist or current
        assert abs(current.linear_mps) <= 0.3
        assert abs(current.angular_radps) <= 0.8
        if not held:
            assert (current.linear_mps, current.angular_radps) == (0.0, 0.0)


TELEOP = "app.modules.behaviors.teleop:Teleop"


def bench(**options: object) -> Bench:
    return Bench(TELEOP, inputs={"operator": TeleopCommand}, outputs={"twist": Twist}, **options)  # type: ignore[arg-type]


def test_the_module_drives_while_held_and_stops_within_300_ms_of_silence() -> None:
    async def main() -> None:
        async with bench() as b:
            twists = b.listen("twist")
            for i in range(5):
                b.feed("operator", drive(b.clock.now(), i, 1.0, -0.5))
                await b.clock.sleep(0.05)
            last_command = b.clock.now() - 0.05
            moving = drain(twists)
            assert [(t.linear_mps, t.angular_radps) for t in moving] == [(0.4, -0.5)] * 5
            stop = await twists.receive()
            assert (stop.linear_mps, stop.angular_radps) == (0.0, 0.0)
            assert 0.25 <= b.clock.now() - last_command <= 0.3
            await b.clock.sleep(2.0)
            assert drain(twists) == [], "the stop is published once"

    run_virtual(main())


def test_the_desires_speed_scales_and_goes_with_the_desire() -> None:
    async def main() -> None:
        async with bench() as b:
            twists = b.listen("twist")
            # Other modules' parameters of the same desire may come along.
            b.slot.configure({"speed": 0.25, "jpeg_quality": 80})
            b.feed("operator", drive(b.clock.now(), 0, 1.0))
            assert (await twists.receive()).linear_mps == pytest.approx(0.1)
            b.slot.configure({})
            b.feed("operator", drive(b.clock.now(), 1, 1.0))
            assert (await twists.receive()).linear_mps == pytest.approx(0.4)

    run_virtual(main())


def test_closing_the_output_says_stop_once() -> None:
    async def main() -> None:
        async with bench(attended=("twist",)) as b:
            b.graph.filters.apply({"Tested.twist": 1})
            twists = b.listen("twist")
            b.feed("operator", drive(b.clock.now(), 0, 1.0))
            await b.settle()
            b.graph.filters.apply({"Tested.twist": math.inf})
            b.feed("operator", drive(b.clock.now(), 1, 1.0))
            await b.settle()
            assert [t.linear_mps for t in drain(twists)] == [0.4, 0.0]

    run_virtual(main())


def test_a_refused_command_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    async def main() -> None:
        async with bench() as b:
            for i in range(3):
                b.feed("operator", drive(b.clock.now(), i, math.nan))
                await b.settle()

    run_virtual(main())
    assert len([r for r in caplog.records if "refused" in r.message]) == 1


def test_a_hold_of_the_head_alone_says_nothing_of_a_standing_base_and_stops_a_moving_one() -> None:
    def turn_head(stamp: float, sequence: int) -> TeleopCommand:
        return TeleopCommand(stamp, "anne", sequence, False, 0.0, 0.0, head_held=True, pan=1.0)

    gate = DriveGate(LIMITS)
    assert gate.take(turn_head(10.0, 0)).twist is None, "or the robot would leave its way to a goal"
    gate.take(drive(10.05, 1, 1.0))
    assert gate.take(turn_head(10.1, 2)).twist == Twist(10.1, 0.0, 0.0)
    assert gate.take(turn_head(10.15, 3)).twist is None
