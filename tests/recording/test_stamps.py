"""Times of logs: exact there and back."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from app.recording.stamps import from_ns, to_ns


@given(st.floats(2**23, 2**33))
def test_stamps_of_the_epoch_come_back_exactly(stamp: float) -> None:
    assert from_ns(to_ns(stamp)) == stamp


@given(st.floats(0, 2**23))
def test_small_stamps_come_back_to_half_a_nanosecond(stamp: float) -> None:
    assert abs(from_ns(to_ns(stamp)) - stamp) <= 0.5e-9 * 1.01 + 1e-9 * (stamp > 2**22)


@given(st.integers(0, 2**62))
def test_nanoseconds_split_into_whole_seconds_and_less_than_one(nanoseconds: int) -> None:
    assert abs(from_ns(nanoseconds) * 1e9 - nanoseconds) <= max(1.0, nanoseconds * 2.0**-52)
