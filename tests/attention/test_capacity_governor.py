"""The share of the budget: less under pressure, all of it without, and never back and forth."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.attention.capacity_governor import CapacityGovernor, Pressure
from app.attention.reluctance import Patience, Reluctance

CALM = Pressure(waiting=0.05, room=40)
PRESSED = Pressure(waiting=0.5, room=0)


def after(governor: CapacityGovernor, pressure: Pressure, windows: int, now: float = 0.0) -> float:
    for window in range(windows):
        governor.take(now + window, pressure, 40, 40 * governor.share)
    return now + windows


def test_one_pressed_window_is_none_and_two_are() -> None:
    governor = CapacityGovernor(0.4)
    now = after(governor, PRESSED, 1)
    assert governor.share == 1
    after(governor, PRESSED, 1, now)
    assert governor.share < 0.85


def test_pressure_takes_no_more_than_is_allowed() -> None:
    governor = CapacityGovernor(0.4)
    after(governor, Pressure(waiting=0.9, room=0), 60)
    assert governor.share == 0.4


def test_what_was_had_under_pressure_is_nearly_kept() -> None:
    governor = CapacityGovernor(0.1)
    for now in range(2):
        governor.take(now, Pressure(waiting=0.9, room=0), 40, 36)
    assert governor.share == pytest.approx(0.7)


def test_the_share_is_back_soon_after_relief() -> None:
    governor = CapacityGovernor(0.4)
    now = after(governor, PRESSED, 10)
    after(governor, CALM, 4, now)
    assert governor.share == 1


def test_room_is_given_as_far_as_it_goes() -> None:
    governor = CapacityGovernor(0.4)
    now = after(governor, Pressure(waiting=0.9, room=0), 20)
    after(governor, Pressure(waiting=0.05, room=10), 3, now)
    assert governor.share == pytest.approx(0.6), "8 of the 10 % of a core, of a budget of 40"


def test_waiting_for_each_other_where_there_is_room_is_no_pressure() -> None:
    governor = CapacityGovernor(0.4)
    after(governor, Pressure(waiting=0.4, room=30), 20)
    assert governor.share == 1


@pytest.mark.parametrize(
    ("pressure", "lack"),
    [
        (Pressure(), 0.0),
        (Pressure(waiting=0.3, stalled=0.9), 0.3),
        (Pressure(stalled=0.9), 0.4),
        (Pressure(runnable=2.0), 0.5),
        (Pressure(waiting=0.1, late_s=0.1), 0.5),
    ],
)
def test_the_best_witness_counts(pressure: Pressure, lack: float) -> None:
    assert pressure.lack == pytest.approx(lack)


@settings(max_examples=60, deadline=None)
@given(st.floats(0, 1), st.floats(0, 100), st.floats(0, 1))
def test_constant_pressure_gives_a_constant_share(waiting: float, room: float, had: float) -> None:
    governor = CapacityGovernor(0.4)
    shares = []
    for now in range(60):
        governor.take(now, Pressure(waiting=waiting, room=room), 40, 40 * min(had, governor.share))
        shares.append(governor.share)
    assert all(0.4 <= share <= 1 for share in shares)
    steps = [b - a for a, b in itertools.pairwise(shares) if a != b]
    assert not (any(step > 0 for step in steps) and any(step < 0 for step in steps)), "it swings"


def test_tries_that_fail_become_rare() -> None:
    """Others leave room for half: each try for more is answered by pressure."""
    governor = CapacityGovernor(0.1)
    tried = []
    for now in range(1200):
        before = governor.share
        governor.take(now, PRESSED if governor.share > 0.5 else Pressure(waiting=0.05, room=0), 40, 40 * governor.share)
        if governor.share > before:
            tried.append(now)
    gaps = [b - a for a, b in itertools.pairwise(tried)]
    assert len(tried) < 12
    assert gaps[-1] >= 200


def test_a_least_share_that_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="over 0"):
        CapacityGovernor(0)


def test_ease_waits_the_longer_the_more_often_it_was_taken_back() -> None:
    ease = Reluctance(Patience(least_s=2, most_s=8, regret_s=10))
    held = []
    now = 0.0
    for _ in range(5):
        held.append(ease.hold_s)
        while not ease.want(now, True):
            now += 1
        ease.give(now)
        ease.take_back(now + 1)
    assert held == [2, 4, 8, 8, 8]
    assert not ease.want(now, False)
    while not ease.want(now, True):
        now += 1
    ease.give(now)
    ease.take_back(now + 100)
    assert ease.hold_s == 2
    assert not math.isnan(now)
