"""Relative message rates."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.console.live.lanes import RatioWindow
from app.runtime.filter import RateFilter


@given(st.integers(1, 15))
def test_the_rate_is_what_the_filter_lets_through(divisor: int) -> None:
    """20 samples a second of a filter that is offered 100 messages a second."""
    rate_filter, window = RateFilter(divisor), RatioWindow()
    passed = 0
    for beat in range(60):
        window.add(beat * 0.05, 5 * beat, passed)
        passed += sum(rate_filter.offer() for _ in range(5))
    ratio = window.ratio()
    assert ratio == pytest.approx(1 / divisor, abs=0.011)


def test_nothing_offered_has_no_rate() -> None:
    window = RatioWindow()
    assert window.ratio() is None
    for beat in range(30):
        window.add(beat * 0.05, 7, 3)
    assert window.ratio() is None


def test_what_was_before_the_last_second_does_not_count() -> None:
    window = RatioWindow()
    for beat in range(21):
        window.add(beat * 0.05, 10 * beat, 0)
    for beat in range(21, 42):
        window.add(beat * 0.05, 10 * beat, 10 * (beat - 20))
    assert window.ratio() == pytest.approx(1.0)


def test_while_time_stands_nothing_piles_up_and_the_rate_stays() -> None:
    window = RatioWindow()
    for beat in range(30):
        window.add(beat * 0.05, 10 * beat, 5 * beat)
    rate = window.ratio()
    for _ in range(1000):
        window.add(29 * 0.05, 290, 145)
    assert window.ratio() == rate
    assert len(window._samples) < 30
