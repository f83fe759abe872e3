"""Wrong tokens cost time."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.console.access.login_attempts import (
    EXPIRE_AFTER_S,
    FREE,
    LONGEST_WAIT_S,
    MANY_A_MINUTE,
    MOST_ADDRESSES,
    Attempts,
    origin_of,
)
from tests.console.access.test_sessions import Now


def test_some_mistakes_are_free_and_then_waits_double() -> None:
    now = Now()
    attempts = Attempts(now)
    waits = []
    for _ in range(FREE + 12):
        attempts.failed("192.0.2.1")
        waits.append(attempts.wait_s("192.0.2.1"))
        now.time += waits[-1]
        assert attempts.wait_s("192.0.2.1") == 0
    assert waits[:FREE] == [0.0] * FREE
    assert waits[FREE : FREE + 4] == [1.0, 2.0, 4.0, 8.0]
    assert waits[-1] == LONGEST_WAIT_S


def test_mistakes_expire() -> None:
    now = Now()
    attempts = Attempts(now)
    for _ in range(FREE + 3):
        attempts.failed("192.0.2.1")
    now.time += EXPIRE_AFTER_S + 1
    attempts.failed("192.0.2.1")
    assert attempts.wait_s("192.0.2.1") == 0


def test_while_many_try_each_has_one_mistake_free_and_the_others_none_to_bear() -> None:
    now = Now()
    attempts = Attempts(now)
    for number in range(MANY_A_MINUTE):
        attempts.failed(f"198.51.100.{number}")
    assert attempts.wait_s("192.0.2.1") == 0
    attempts.failed("192.0.2.1")
    assert attempts.wait_s("192.0.2.1") == 0
    attempts.failed("192.0.2.1")
    assert attempts.wait_s("192.0.2.1") == 1
    now.time += 61
    attempts.failed("192.0.2.2")
    attempts.failed("192.0.2.2")
    assert attempts.wait_s("192.0.2.2") == 0


@given(st.lists(st.integers(0, 3 * MOST_ADDRESSES), max_size=300))
def test_what_is_remembered_is_bounded(numbers: list[int]) -> None:
    attempts = Attempts(Now())
    for number in (*range(MOST_ADDRESSES), *numbers):
        attempts.failed(f"host {number}")
    assert len(attempts) <= MOST_ADDRESSES


@pytest.mark.parametrize(
    ("address", "origin"),
    [
        ("192.0.2.1", "192.0.2.1"),
        ("::ffff:192.0.2.1", "192.0.2.1"),
        ("2001:db8::1", "2001:db8::/64"),
        ("2001:db8::ffff:ffff:ffff:ffff", "2001:db8::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("2001:db8:0:1::1", "2001:db8:0:1::/64"),
        ("", ""),
        ("testclient", "testclient"),
    ],
)
def test_one_computer_counts_as_one(address: str, origin: str) -> None:
    assert origin_of(address) == origin
