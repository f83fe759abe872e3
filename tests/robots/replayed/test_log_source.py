"""Reading ahead: every message once, in the order of the log, from any place on."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.base.geometry import Pose2
from app.logs.log import LogError, Logged
from app.messages import Odometry
from app.robots.replayed.log_source import PIECE_MESSAGES, PIECE_S, LogPosition, LogSource
from tests.logs.replay.logs import MemoryLog, numbered

TIMES = st.lists(st.tuples(st.integers(0, 40).map(lambda n: n / 8), st.sampled_from("abc")), max_size=60)


def made(entries: list[tuple[float, str]]) -> MemoryLog:
    """A log of numbered messages at these times on these channels."""
    return MemoryLog(
        [
            Logged(at, channel, Odometry(at, Pose2(float(number), 0, 0), 0, 0))
            for number, (at, channel) in enumerate(sorted(entries, key=lambda entry: entry[0]))
        ]
    )


def everything(source: LogSource) -> list[Logged]:
    found: list[Logged] = []
    while piece := source.piece():
        assert len(piece) <= PIECE_MESSAGES
        assert piece[-1].at - piece[0].at <= PIECE_S
        found += piece
    return found


@given(TIMES, st.integers(0, 60))
def test_going_on_from_any_message_gives_the_rest(entries: list[tuple[float, str]], stop: int) -> None:
    log = made(entries)
    whole = list(log.messages())
    delivered = whole[:stop]
    at = delivered[-1].at if delivered else -1.0
    passed: dict[str, int] = {}
    for logged in delivered:
        if logged.at == at:
            passed[logged.channel] = passed.get(logged.channel, 0) + 1
    source = LogSource(log, {"a", "b", "c"}, LogPosition(at, passed), math.inf)
    assert everything(source) == whole[stop:]


@given(TIMES, st.sampled_from([0.0, 1.0, 2.5]))
def test_a_channel_opened_later_begins_there(entries: list[tuple[float, str]], since: float) -> None:
    log = made(entries)
    source = LogSource(log, {"a", "b"}, LogPosition(0.5, since={"b": since}), 4.0)
    expected = [
        logged
        for logged in log.messages()
        if 0.5 <= logged.at <= 4.0 and (logged.channel == "a" or (logged.channel == "b" and logged.at >= since))
    ]
    assert everything(source) == expected


def test_nothing_wanted_reads_nothing() -> None:
    log = MemoryLog(numbered(10))
    assert LogSource(log, (), LogPosition(0.0), math.inf).piece() == []
    assert log.decoded == {}


def test_a_damaged_log_says_so() -> None:
    log = MemoryLog(numbered(10), damaged_at=numbered(10)[4].at)
    source = LogSource(log, {"odometry"}, LogPosition(0.0), math.inf)
    with pytest.raises(LogError, match="is damaged"):
        everything(source)
