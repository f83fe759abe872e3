from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.runtime.filter import CLOSED, RateFilter, check_divisor

divisors = st.one_of(st.integers(1, 7), st.just(CLOSED))
#: Each step offers that many messages, or sets φ.
steps = st.lists(st.one_of(st.integers(0, 20).map(lambda n: ("offer", n)), divisors.map(lambda d: ("set", d))))


def model(first: float, history: list[tuple[str, float]]) -> list[bool]:
    """What passes, by the definition: since φ last became another, the messages 0, φ, 2φ ... pass; none if φ is ∞."""
    divisor, since_change, passed = first, 0, []
    for action, value in history:
        if action == "set":
            if value != divisor:
                divisor, since_change = value, 0
        else:
            for _ in range(int(value)):
                passed.append(divisor != CLOSED and since_change % divisor == 0)
                since_change += 1
    return passed


@given(divisors, steps)
def test_exactly_the_defined_messages_pass(first: float, history: list[tuple[str, float]]) -> None:
    rate_filter = RateFilter(first)
    passed = []
    for action, value in history:
        if action == "set":
            rate_filter.divisor = value
        else:
            passed += [rate_filter.offer() for _ in range(int(value))]
    assert passed == model(first, history)


@given(st.integers(1, 50), st.integers(0, 500))
def test_of_n_messages_the_ceiling_of_n_over_phi_pass(divisor: int, messages: int) -> None:
    rate_filter = RateFilter(divisor)
    assert sum(rate_filter.offer() for _ in range(messages)) == math.ceil(messages / divisor)


def test_writing_the_same_divisor_keeps_the_phase_and_calls_no_callback() -> None:
    changes: list[tuple[float, float]] = []
    rate_filter = RateFilter(3, lambda before, after: changes.append((before, after)))
    assert rate_filter.offer()
    rate_filter.divisor = 3
    assert [rate_filter.offer() for _ in range(3)] == [False, False, True]
    assert changes == []
    rate_filter.divisor = CLOSED
    rate_filter.divisor = CLOSED
    rate_filter.divisor = 2
    assert changes == [(3, CLOSED), (CLOSED, 2)]
    assert rate_filter.offer()


@pytest.mark.parametrize("wrong", [0, -1, 0.5, 2.5, -math.inf, math.nan])
def test_a_divisor_that_cannot_be_changes_nothing(wrong: float) -> None:
    rate_filter = RateFilter(2)
    rate_filter.offer()
    with pytest.raises(ValueError, match="integer of at least 1, or infinite"):
        rate_filter.divisor = wrong
    assert rate_filter.divisor == 2
    assert [rate_filter.offer(), rate_filter.offer()] == [False, True]
    with pytest.raises(ValueError, match="integer of at least 1"):
        check_divisor(wrong)


def test_a_closed_filter_stays_closed_however_much_is_offered() -> None:
    rate_filter = RateFilter(CLOSED)
    assert not rate_filter.is_open
    assert not any(rate_filter.offer() for _ in range(1000))


@given(st.integers(1, 9), st.integers(0, 20), st.integers(0, 60))
def test_decimation_begins_at_the_offset(divisor: int, offset: int, messages: int) -> None:
    rate_filter = RateFilter(divisor)
    rate_filter.begin(offset)
    assert [rate_filter.offer() for _ in range(messages)] == [
        number >= offset and (number - offset) % divisor == 0 for number in range(messages)
    ]
