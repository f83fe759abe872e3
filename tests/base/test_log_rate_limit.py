"""What is logged over and over."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.log_rate_limit import FIRST, MOST_LINES, WINDOW_S, RateLimitedHandler


class Bench:
    """A handler with a clock that the test sets, and its output."""

    def __init__(self) -> None:
        self.time = 0.0
        self.out = io.StringIO()
        self.handler = RateLimitedHandler(self.out, now=lambda: self.time)

    def log(self, words: str, *values: object, line: int = 1, **more: object) -> None:
        record = logging.LogRecord("hbba.x", logging.WARNING, "x.py", line, words, values, more.pop("exc_info", None))  # type: ignore[arg-type]
        vars(record).update(more)
        self.handler.handle(record)

    @property
    def said(self) -> list[str]:
        return self.out.getvalue().splitlines()


@pytest.fixture
def bench() -> Iterator[Bench]:
    bench = Bench()
    yield bench
    bench.handler.close()


def test_the_first_are_written_and_the_others_counted(bench: Bench) -> None:
    for _ in range(FIRST + 1000):
        bench.log("no %s", "room")
    assert bench.said == ["no room"] * FIRST
    bench.time = WINDOW_S
    bench.handler.say_held()
    assert bench.said[FIRST:] == ["no room (repeated 1000 times more in 10 s)"]


def test_any_later_line_says_it_too(bench: Bench) -> None:
    for _ in range(FIRST + 1):
        bench.log("no room")
    bench.time = WINDOW_S
    bench.log("something else")
    assert bench.said[FIRST:] == ["no room (repeated once more in 10 s)", "something else"]


def test_what_goes_on_is_only_counted_until_it_pauses(bench: Bench) -> None:
    for _ in range(300):
        bench.time += 0.1
        bench.log("no room")
    bench.time += 2 * WINDOW_S
    bench.handler.say_held()
    assert len([line for line in bench.said if line == "no room"]) == FIRST
    assert sum(int(line.split("repeated ")[1].split()[0]) for line in bench.said[FIRST:]) == 300 - FIRST
    bench.time += 2 * WINDOW_S
    bench.log("no room")
    assert bench.said[-1] == "no room"


def test_the_end_says_what_was_held() -> None:
    bench = Bench()
    for _ in range(FIRST + 7):
        bench.log("no room")
    bench.handler.close()
    assert bench.said[-1] == "no room (repeated 7 times more in 1 s)"


def test_other_values_places_and_exceptions_are_other_lines(bench: Bench) -> None:
    for number in range(2 * FIRST):
        bench.log("lost %d", number)
        bench.log("lost at", line=number)
        bench.log("lost so many", dropped=number)
        bench.log("lost by", exc_info=(ValueError, ValueError(number), None))
    begins = [line for line in bench.said if line.startswith("lost")]
    assert len(begins) == 4 * 2 * FIRST
    assert "repeated" not in bench.out.getvalue()


def test_it_is_said_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.base.log_rate_limit.WINDOW_S", 0.01)
    handler = RateLimitedHandler(io.StringIO(), now=lambda: 0.0)
    ended: list[bool] = []
    monkeypatch.setattr(handler, "say_held", lambda: ended.append(True))
    record = logging.LogRecord("x", logging.INFO, "x.py", 1, "again", (), None)
    for _ in range(FIRST + 1):
        handler.handle(record)
    timer = handler._timer
    assert timer is not None
    timer.join()
    assert ended == [True]


@given(st.lists(st.tuples(st.integers(0, 2 * MOST_LINES), st.floats(0, 4)), max_size=400))
def test_nothing_is_lost_and_memory_is_bounded(steps: list[tuple[int, float]]) -> None:
    bench = Bench()
    logged: dict[str, int] = {}
    for number, wait_s in steps:
        bench.time += wait_s
        for _ in range(1 + 10 * (number % 3)):
            bench.log(f"line {number}.")
            logged[f"line {number}."] = logged.get(f"line {number}.", 0) + 1
        assert len(bench.handler._lines) <= MOST_LINES
    bench.handler.close()
    counted: dict[str, int] = {}
    for line in bench.said:
        words, _, repeated = line.partition(" (repeated ")
        count = repeated.split()[0] if repeated else "1"
        counted[words] = counted.get(words, 0) + (1 if count == "once" else int(count))
    assert counted == logged
