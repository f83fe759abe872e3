"""What became of desires: the newest are kept, for a while."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.attention.ended_desires import EndedDesires
from app.messages import DesireReport, Source

KEPT, KEPT_FOR_S = 4, 10.0


def left(number: int, ended: float | None) -> DesireReport:
    source = Source("rest", "rest")
    return DesireReport(f"d-{number}", "GoTo", 8, 4, False, {}, source, 0.0, outcome="expired", ended=ended)


@given(st.lists(st.tuples(st.integers(0, 9), st.floats(0, 6)), max_size=40), st.floats(0, 30))
def test_the_last_that_left_are_kept_each_for_its_time(steps: list[tuple[int, float]], later: float) -> None:
    ended = EndedDesires(KEPT, KEPT_FOR_S)
    now = 0.0
    model: list[tuple[int, float]] = []
    for number, pause in steps:
        now += pause
        ended.add(left(number, now))
        model = [(n, at) for n, at in model if n != number and now - at < KEPT_FOR_S]
        model = [*model, (number, now)][-KEPT:]
    now += later
    known = {f"d-{n}": at for n, at in model if now - at < KEPT_FOR_S}
    for number in range(10):
        report = ended.find(f"d-{number}", now)
        assert (None if report is None else report.ended) == known.get(f"d-{number}")
    for count in range(KEPT + 2):
        assert [r.id for r in ended.newest(count, now)] == [*reversed(known)][:count]


def test_what_has_not_ended_is_refused() -> None:
    with pytest.raises(ValueError, match="'d-1' has not ended"):
        EndedDesires().add(left(1, None))


def test_nothing_is_known_after_a_jump_of_time() -> None:
    ended = EndedDesires()
    ended.add(left(1, 5.0))
    ended.clear()
    assert ended.find("d-1", 5.0) is None
