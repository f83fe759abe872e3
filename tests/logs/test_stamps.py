"""Times of logs: exact there and back."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from app.logs.stamps import Onward, from_ns, to_ns


@given(st.floats(2**23, 2**33))
def test_stamps_of_the_epoch_come_back_exactly(stamp: float) -> None:
    assert from_ns(to_ns(stamp)) == stamp


@given(st.floats(0, 2**23))
def test_small_stamps_come_back_to_half_a_nanosecond(stamp: float) -> None:
    assert abs(from_ns(to_ns(stamp)) - stamp) <= 0.5e-9 * 1.01 + 1e-9 * (stamp > 2**22)


@given(st.integers(0, 2**62))
def test_nanoseconds_split_into_whole_seconds_and_less_than_one(nanoseconds: int) -> None:
    assert abs(from_ns(nanoseconds) * 1e9 - nanoseconds) <= max(1.0, nanoseconds * 2.0**-52)


def test_a_stamp_that_goes_back_comes_after_the_one_before() -> None:
    stamps = Onward()
    given = [stamps.next(stamp) for stamp in (1.0, 1.2, -1.6, 1.6, 1.8)]
    assert given == [1.0, 1.2, 1.4, 1.6, 1.8]
    assert (stamps.back, stamps.first_back, stamps.seen) == (1, 2, 5)
    assert abs(stamps.most_back_s - 2.8) < 1e-9


def test_a_clock_that_was_set_back_is_followed() -> None:
    stamps = Onward()
    own = [10.0, 10.2, 10.4, 7.6, 7.8, 8.0, *(8.2 + 0.2 * k for k in range(20))]
    given = [stamps.next(stamp) for stamp in own]
    assert given == sorted(given)
    assert given[-1] == own[-1]
    assert stamps.back == 1


def test_one_stamp_far_ahead_does_not_hold_up_those_after_it() -> None:
    stamps = Onward()
    own = [0.0, 0.2, 5.4, *(0.6 + 0.2 * k for k in range(30))]
    given = [stamps.next(stamp) for stamp in own]
    assert given == sorted(given)
    assert given[-1] == own[-1]


@given(st.lists(st.floats(-1e9, 1e9), max_size=40))
def test_whatever_the_stamps_they_never_go_back(own: list[float]) -> None:
    stamps = Onward()
    given = [stamps.next(stamp) for stamp in own]
    assert given == sorted(given)
    if own == sorted(own):
        assert given == own
        assert not stamps.back
