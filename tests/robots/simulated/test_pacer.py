"""The pacer, stepped by hand: real time where it can, an even slow-down where it cannot."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.robots.simulated.pacer import GO_ON_S, LONGEST_WAIT_S, Pacer
from app.robots.simulated.simulation import Schedule

STEP = 0.002


def turn(pacer: Pacer, now: float) -> int:
    steps = pacer.due(now)
    for _ in range(steps):
        pacer.advance()
    return steps


def test_on_time_it_keeps_real_time_and_its_stamps_follow_the_clock() -> None:
    pacer = Pacer(10.0, STEP)
    for i in range(1, 1001):
        now = 10.0 + 0.004 * i
        turn(pacer, now)
        assert now - STEP - 1e-9 <= pacer.stamp <= now + 1e-9
    assert pacer.rate(14.0) == pytest.approx(1.0, abs=0.005)


def test_a_short_stall_is_made_up_for() -> None:
    pacer = Pacer(0.0, STEP)
    turn(pacer, 0.09)
    for i in range(20):
        turn(pacer, 0.09 + 0.004 * i)
    assert pacer.stamp == pytest.approx(0.09 + 0.076, abs=STEP + 1e-9)


def test_a_long_stall_is_given_up_instead_of_jumped_over() -> None:
    pacer = Pacer(0.0, STEP)
    assert turn(pacer, 5.0) == 12
    total = 12 + sum(turn(pacer, 5.0 + 0.004 * i) for i in range(1, 100))
    assert total * STEP == pytest.approx(0.1 + 0.396, abs=0.01)


def test_an_overloaded_computer_slows_the_world_and_the_rate_says_so() -> None:
    pacer, now = Pacer(0.0, STEP), 0.0
    for _ in range(100):
        now += 0.048  # each turn of at most 12 steps takes as long as 24
        turn(pacer, now)
    assert pacer.rate(now) == pytest.approx(0.5, abs=0.03)


def test_who_waits_for_a_picture_makes_up_for_a_little() -> None:
    pacer = Pacer(0.0, STEP)
    turn(pacer, 0.02)
    assert pacer.waits(0.03, missing=True)
    assert pacer.waits(0.12, missing=True)
    assert pacer.wait_s(0.12, 2) == pytest.approx(2 * STEP)
    assert not pacer.waits(0.12, missing=False)
    assert pacer.stamp == pytest.approx(0.07)
    assert pacer.wait_s(0.12, 2) == 0.0


def test_no_wait_lasts_for_ever() -> None:
    pacer = Pacer(0.0, STEP)
    assert pacer.waits(1.0, missing=True)
    for _ in range(round(GO_ON_S / STEP)):
        assert not pacer.waits(1.01 + LONGEST_WAIT_S, missing=True)
    assert pacer.waits(1.02 + LONGEST_WAIT_S, missing=True)
    assert not pacer.waits(1.1 + LONGEST_WAIT_S, missing=False)
    assert pacer.waits(1.2 + LONGEST_WAIT_S, missing=True)  # for the next one, again


@given(st.lists(st.integers(1, 90), min_size=1, max_size=100))
def test_pictures_keep_their_rate_in_the_worlds_time(drawing: list[int]) -> None:
    """Each picture takes so many turns of 4 ms, up to six periods; one is due every 66 ms of the world's time."""
    pacer, schedule, now, busy_until = Pacer(0.0, STEP), Schedule(15.0), 0.0, 0.0
    steps, taken = 0, []
    for turns in drawing:
        while True:
            now += 0.004
            for _ in range(pacer.due(now)):
                if pacer.waits(now, now < busy_until and schedule.ready(steps * STEP)):
                    break
                pacer.advance()
                steps += 1
            if now >= busy_until and schedule.due(steps * STEP):
                taken.append(steps * STEP)
                busy_until = now + turns * 0.004
                break
    assert all(b - a < 1 / 15 + 2 * GO_ON_S + 0.03 for a, b in pairwise(taken))


def test_it_says_how_long_to_wait_for_the_next_steps() -> None:
    pacer = Pacer(0.0, STEP)
    assert pacer.wait_s(0.001, 2) == pytest.approx(0.003)
    assert pacer.wait_s(1.0, 2) == 0.0


@given(st.lists(st.floats(0.0, 0.5), min_size=1, max_size=50))
def test_time_never_runs_back_nor_ahead_of_the_clock(waits: list[float]) -> None:
    pacer, now, last = Pacer(0.0, STEP), 0.0, 0.0
    for wait in waits:
        now += wait
        assert 0 <= turn(pacer, now) <= 12
        assert last <= pacer.stamp <= now + 1e-9
        last = pacer.stamp


def test_a_command_to_set_out_ends_a_pause_and_pictures_are_waited_for_again_afterwards() -> None:
    pacer = Pacer(0.0, STEP)
    turn(pacer, 0.02)
    assert pacer.waits(0.03, missing=True)
    pacer.go_on()
    stepped = 0
    while not pacer.waits(0.04, missing=True):
        pacer.advance()
        stepped += 1
    assert stepped * STEP == pytest.approx(GO_ON_S)
    # The wait has begun again, and lasts as long as any.
    assert pacer.waits(0.04 + LONGEST_WAIT_S - 0.01, missing=True)
    assert not pacer.waits(0.04 + LONGEST_WAIT_S, missing=True)
