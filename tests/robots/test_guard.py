"""The guard, stepped through time by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.link import BaseLimits
from app.robots import guard
from app.robots.guard import BaseVelocity, GuardLimits, GuardMode, GuardState, VelocityCommand

BASE = BaseLimits(linear_mps=0.40, angular_radps=1.00, linear_mps2=0.40, angular_radps2=4.00)
LIMITS = GuardLimits(BASE, command_timeout_s=0.2, sensor_timeout_s=0.5)
DT = 0.004


def run(
    state: GuardState, start: float, seconds: float, ages: dict[str, float] | None = None
) -> tuple[GuardState, list[tuple[float, guard.GuardAction, BaseVelocity]]]:
    """Step the guard; returns the state and (time, action, applied) of each step."""
    rows = []
    for i in range(round(seconds / DT)):
        now = start + i * DT
        action = guard.decide(now, state, ages or {}, LIMITS)
        state = guard.step(state, action, LIMITS, DT)
        rows.append((now, action, state.applied))
    return state, rows


def driving(now: float = 100.0, linear: float = 0.4, angular: float = 0.0) -> GuardState:
    """A state that has reached the velocity it was commanded at ``now``."""
    velocity = BaseVelocity(linear, angular)
    return GuardState(applied=guard.clamp(velocity, BASE), command=VelocityCommand(now, velocity))


def test_without_a_command_the_base_stands_idle() -> None:
    state, rows = run(GuardState(), 0.0, 1.0)
    assert state.applied.is_zero
    assert {action.mode for _, action, _ in rows} == {GuardMode.IDLE}
    assert guard.command_age(state, 1.0) is None


def test_a_fresh_command_is_approached_at_the_bases_acceleration() -> None:
    state = GuardState()
    speeds = []
    for i in range(400):
        now = i * DT
        state = guard.accept(state, VelocityCommand(now, BaseVelocity(0.4, 1.0)))
        state = guard.step(state, guard.decide(now, state, {}, LIMITS), LIMITS, DT)
        speeds.append(state.applied)
    first_full = next(i for i, v in enumerate(speeds) if v.linear_mps >= 0.4)
    assert (first_full + 1) * DT == pytest.approx(1.0, abs=0.01)  # 0.4 m/s at 0.4 m/s^2
    first_turning = next(i for i, v in enumerate(speeds) if v.angular_radps >= 1.0)
    assert (first_turning + 1) * DT == pytest.approx(0.25, abs=0.01)


def test_an_ordinary_stop_brakes_at_the_bases_acceleration_and_reads_idle() -> None:
    state = guard.accept(driving(), VelocityCommand(100.1, guard.ZERO))
    action = guard.decide(100.1, state, {}, LIMITS)
    assert action.mode is GuardMode.IDLE
    stepped = guard.step(state, action, LIMITS, 0.1)
    assert stepped.applied.linear_mps == pytest.approx(0.36)


def test_a_command_stands_for_200_ms_and_not_longer() -> None:
    _, rows = run(driving(now=100.0), 100.0, 0.5)
    still_driving = [now for now, action, _ in rows if action.mode is GuardMode.DRIVING]
    assert max(still_driving) == pytest.approx(100.2, abs=1.5 * DT)
    stale = [(now, applied) for now, action, applied in rows if action.mode is GuardMode.STALE_COMMAND]
    assert stale[0][0] == pytest.approx(100.2, abs=1.5 * DT)
    assert all(applied.is_zero for _, applied in stale)


def test_a_stale_command_revived_ramps_up_again_from_zero() -> None:
    state, _ = run(driving(now=100.0), 100.0, 0.5)
    state = guard.accept(state, VelocityCommand(100.5, BaseVelocity(0.4)))
    state = guard.step(state, guard.decide(100.5, state, {}, LIMITS), LIMITS, DT)
    assert state.applied.linear_mps == pytest.approx(0.4 * DT)


def test_a_zero_command_that_goes_stale_while_still_braking_stops_at_once() -> None:
    state = replace(driving(), command=VelocityCommand(100.0, guard.ZERO))
    action = guard.decide(100.3, state, {}, LIMITS)
    assert action.mode is GuardMode.STALE_COMMAND
    assert guard.step(state, action, LIMITS, DT).applied.is_zero
    standing = replace(state, applied=guard.ZERO)
    assert guard.decide(100.3, standing, {}, LIMITS).mode is GuardMode.IDLE


def test_the_emergency_stop_is_latched_keeps_its_first_reason_and_outlasts_commands() -> None:
    state = guard.e_stop(driving(), "the button")
    state = guard.e_stop(state, "another")
    state = guard.accept(state, VelocityCommand(100.01, BaseVelocity(0.4)))
    action = guard.decide(100.01, state, {"hokuyo": 9.0}, LIMITS)
    assert (action.mode, action.immediate) == (GuardMode.E_STOPPED, True)
    assert action.reason == "emergency stop: the button"
    assert guard.step(state, action, LIMITS, DT).applied.is_zero


def test_clearing_the_emergency_stop_waits_for_a_new_command() -> None:
    state = guard.accept(guard.e_stop(driving(), "x"), VelocityCommand(100.1, BaseVelocity(0.4)))
    state = guard.clear_e_stop(state)
    assert guard.decide(100.1, state, {}, LIMITS).mode is GuardMode.IDLE
    state = guard.accept(state, VelocityCommand(100.12, BaseVelocity(0.4)))
    assert guard.decide(100.13, state, {}, LIMITS).mode is GuardMode.DRIVING


def test_clearing_without_a_stop_changes_nothing() -> None:
    assert guard.clear_e_stop(driving()) == driving()


def test_a_failed_sensor_stops_the_base_and_is_named() -> None:
    action = guard.decide(100.05, driving(), {"odometry": 0.01, "hokuyo": 0.7}, LIMITS)
    assert (action.mode, action.immediate) == (GuardMode.SENSOR_FAILURE, True)
    assert "hokuyo" in action.reason
    assert "0.7 s" in action.reason
    assert guard.decide(100.05, driving(), {"odometry": math.nan}, LIMITS).mode is GuardMode.SENSOR_FAILURE


@pytest.mark.parametrize(
    "velocity", [BaseVelocity(math.nan, 0.0), BaseVelocity(0.1, math.inf), BaseVelocity(-math.inf, 0.0)]
)
def test_a_command_that_is_no_number_is_refused_until_a_good_one_comes(velocity: BaseVelocity) -> None:
    state = guard.accept(driving(), VelocityCommand(100.01, velocity))
    action = guard.decide(100.01, state, {}, LIMITS)
    assert (action.mode, action.target, action.immediate) == (GuardMode.STALE_COMMAND, guard.ZERO, True)
    assert "not a number" in action.reason
    state = guard.accept(state, VelocityCommand(100.02, BaseVelocity(0.2)))
    assert guard.decide(100.02, state, {}, LIMITS).mode is GuardMode.DRIVING


def test_a_stamp_that_is_no_number_is_refused() -> None:
    state = guard.accept(GuardState(), VelocityCommand(math.nan, BaseVelocity(0.2)))
    assert guard.decide(100.0, state, {}, LIMITS).mode is GuardMode.STALE_COMMAND
    assert guard.command_age(state, 100.0) is None


def test_a_command_from_the_future_is_refused_with_its_likely_cause() -> None:
    state = guard.accept(GuardState(), VelocityCommand(200.0, BaseVelocity(0.2)))
    action = guard.decide(100.0, state, {}, LIMITS)
    assert action.mode is GuardMode.STALE_COMMAND
    assert "clock" in action.reason


def test_a_command_older_than_the_newest_is_ignored() -> None:
    state = guard.accept(driving(now=100.0, linear=0.1), VelocityCommand(99.9, BaseVelocity(0.4)))
    assert state.command is not None
    assert state.command.velocity.linear_mps == 0.1


number = st.floats(allow_nan=True, allow_infinity=True)
event = st.one_of(
    st.tuples(st.just("command"), st.floats(-0.3, 0.1), number, number),
    st.tuples(st.just("e_stop"), st.just(0.0), st.just(0.0), st.just(0.0)),
    st.tuples(st.just("clear"), st.just(0.0), st.just(0.0), st.just(0.0)),
    st.tuples(st.just("wait"), st.floats(0.0, 0.4), st.just(0.0), st.just(0.0)),
)


@given(st.lists(event, max_size=40))
def test_whatever_comes_the_wheels_get_finite_bounded_smooth_velocities(
    events: list[tuple[str, float, float, float]],
) -> None:
    state, now = GuardState(), 1000.0
    for kind, offset, linear, angular in events:
        if kind == "command":
            state = guard.accept(state, VelocityCommand(now + offset, BaseVelocity(linear, angular)))
        elif kind == "e_stop":
            state = guard.e_stop(state, "test")
        elif kind == "clear":
            state = guard.clear_e_stop(state)
        now += offset if kind == "wait" else DT
        before = state.applied
        action = guard.decide(now, state, {}, LIMITS)
        state = guard.step(state, action, LIMITS, DT)
        applied = state.applied
        assert applied.is_finite
        assert abs(applied.linear_mps) <= BASE.linear_mps
        assert abs(applied.angular_radps) <= BASE.angular_radps
        if not applied.is_zero:
            assert action.mode in (GuardMode.DRIVING, GuardMode.IDLE)
            assert abs(applied.linear_mps - before.linear_mps) <= BASE.linear_mps2 * DT + 1e-12
            assert abs(applied.angular_radps - before.angular_radps) <= BASE.angular_radps2 * DT + 1e-12
        age = guard.command_age(state, now)
        if state.e_stop is not None or age is None or age > LIMITS.command_timeout_s:
            assert applied.is_zero or action.mode is GuardMode.IDLE


HOLONOMIC = BaseLimits(0.40, 1.00, 0.40, 4.00, lateral_mps=0.20)
speeds = st.floats(-2, 2)


@given(speeds, speeds, speeds)
def test_a_velocity_is_clamped_as_a_vector_within_both_limits(forward: float, left: float, turn: float) -> None:
    clamped = guard.clamp(BaseVelocity(forward, turn, left), HOLONOMIC)
    assert math.hypot(clamped.linear_mps / 0.40, clamped.lateral_mps / 0.20) <= 1 + 1e-9
    assert clamped.linear_mps * left == pytest.approx(clamped.lateral_mps * forward, abs=1e-12)  # same direction
    if math.hypot(forward / 0.40, left / 0.20) <= 1:
        assert (clamped.linear_mps, clamped.lateral_mps) == (forward, left)


@given(speeds, speeds)
def test_a_differential_base_gets_no_sideways_speed(forward: float, left: float) -> None:
    assert guard.clamp(BaseVelocity(forward, 0.0, left), BASE) == BaseVelocity(min(max(forward, -0.4), 0.4))


@given(st.tuples(speeds, speeds), st.tuples(speeds, speeds))
def test_forward_and_sideways_ramp_together_on_a_straight_line(
    before: tuple[float, float], wanted: tuple[float, float]
) -> None:
    limits = GuardLimits(HOLONOMIC)
    state = GuardState(applied=BaseVelocity(before[0], 0.0, before[1]))
    target = guard.clamp(BaseVelocity(wanted[0], 0.0, wanted[1]), HOLONOMIC)
    action = guard.GuardAction(GuardMode.DRIVING, "", target, immediate=False)
    after = guard.step(state, action, limits, 0.1).applied
    changed = complex(after.linear_mps - before[0], after.lateral_mps - before[1])
    whole = complex(target.linear_mps - before[0], target.lateral_mps - before[1])
    assert abs(changed) == pytest.approx(min(abs(whole), 0.04))
    assert (changed * whole.conjugate()).imag == pytest.approx(0, abs=1e-9)


def test_a_sideways_speed_that_is_no_number_is_refused() -> None:
    state = guard.accept(driving(), VelocityCommand(100.1, BaseVelocity(0.1, 0.0, math.nan)))
    assert guard.decide(100.1, state, {}, LIMITS).mode is GuardMode.STALE_COMMAND
    assert not BaseVelocity(lateral_mps=0.1).is_zero
