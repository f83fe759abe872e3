"""Stamps of a robot on the program's clock."""

from __future__ import annotations

import math

import pytest

from app.robots.ros2.stamps import StampClock, WrongClock

NOW = 1_700_000_000.0


def test_a_stamp_on_this_computers_clock_is_taken_as_it_is() -> None:
    clock = StampClock("header", 0.5)
    assert clock.placed(NOW - 0.1, NOW) == NOW - 0.1
    assert clock.placed(None, NOW) == NOW
    assert clock.outgoing(NOW) == NOW


@pytest.mark.parametrize(
    ("stamp", "said"),
    [
        (NOW + 3600, "its time lies 3600.0 s in the future; the robot's clock is not this computer's"),
        (NOW - 0.6, "its time lies 0.6 s in the past; "),
        (12.5, "s in the past; "),
        (math.nan, "its time lies nan s in the past"),
    ],
)
def test_a_stamp_of_another_clock_is_refused(stamp: float, said: str) -> None:
    with pytest.raises(WrongClock, match=said.replace(".", r"\.")):
        StampClock("header", 0.5).placed(stamp, NOW)


def test_a_clock_that_cannot_be_set_is_left_out() -> None:
    clock = StampClock("arrival", 0.5)
    assert clock.placed(12.5, NOW) == NOW
    assert clock.outgoing(NOW) is None


def test_simulated_time_is_placed_by_its_clock() -> None:
    clock = StampClock("sim", 0.5)
    assert clock.outgoing(NOW) is None
    with pytest.raises(WrongClock, match="nothing has come on /clock yet"):
        clock.placed(100.0, NOW)
    assert clock.tick(100.0, NOW)
    assert clock.placed(99.9, NOW + 0.02) == pytest.approx(NOW - 0.1)
    assert clock.placed(100.3, NOW + 0.02) == NOW + 0.02, "nothing is later than its arrival"
    assert clock.outgoing(NOW + 0.25) == pytest.approx(100.25)
    with pytest.raises(WrongClock, match=r"that of /clock: does its node run with use_sim_time\?"):
        clock.placed(NOW, NOW)


def test_simulated_time_that_goes_back_is_noticed() -> None:
    clock = StampClock("sim", 0.5)
    assert clock.tick(100.0, NOW)
    assert clock.tick(99.8, NOW + 0.1), "two of its messages changed places"
    assert not clock.tick(0.0, NOW + 0.2)
