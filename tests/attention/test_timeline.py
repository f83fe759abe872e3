"""The timeline: bounded, queried by time, kind and number."""

from __future__ import annotations

import logging

import pytest

from app.attention.timeline import Timeline
from app.messages import TimelineEvent


def filled(count: int = 10, capacity: int = 100) -> Timeline:
    timeline = Timeline(capacity, lambda: 0.0)
    for n in range(count):
        timeline.add("desire" if n % 2 else "filter", f"s{n}", f"event {n}", {"n": n}, stamp=float(n))
    return timeline


def test_query() -> None:
    timeline = filled()
    assert [e.id for e in timeline.query()] == list(range(1, 11))
    assert [e.stamp for e in timeline.query(since=3, until=6)] == [3, 4, 5]
    assert [e.subject for e in timeline.query(kinds={"desire"}, limit=2)] == ["s7", "s9"]
    assert [e.id for e in timeline.query(after_id=8)] == [9, 10]
    assert timeline.query(limit=0) == ()


def test_bounded() -> None:
    timeline = filled(25, capacity=10)
    assert [e.id for e in timeline.query()] == list(range(16, 26))
    statistics = timeline.statistics()
    assert (statistics.events, statistics.added, statistics.forgotten) == (10, 25, 15)
    with pytest.raises(ValueError, match="at least 1"):
        Timeline(0)


def test_stamps_come_from_the_clock_or_the_event() -> None:
    assert Timeline(5, lambda: 42.0).add("guard", "guard", "stopped").stamp == 42
    assert Timeline(5).add("guard", "guard", "stopped", stamp=3.0).stamp == 3
    with pytest.raises(ValueError, match="stamp"):
        Timeline(5).add("guard", "guard", "stopped")


def test_observers(caplog: pytest.LogCaptureFixture) -> None:
    timeline = Timeline(5, lambda: 0.0)
    seen: list[TimelineEvent] = []

    def broken(event: TimelineEvent) -> None:
        raise ZeroDivisionError

    timeline.observe(broken)
    end = timeline.observe(seen.append)
    with caplog.at_level(logging.ERROR):
        timeline.add("module", "Kinect", "failed")
    assert "an observer of the timeline failed and goes on" in caplog.text
    timeline.add("module", "Kinect", "runs again")
    end()
    timeline.add("module", "Kinect", "failed")
    assert [e.id for e in seen] == [1, 2]


def test_a_cleared_timeline_counts_on() -> None:
    timeline = Timeline(5, lambda: 1.0)
    for text in ("one", "two"):
        timeline.add("module", "M", text)
    timeline.clear()
    assert timeline.query() == ()
    assert timeline.add("module", "M", "three").id == 3
    assert [event.text for event in timeline.query(after_id=2)] == ["three"]
