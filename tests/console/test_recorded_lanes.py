"""The lanes on a recording: those that were, not those that the replay's own attention has."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from app.logs.log import Logged
from app.messages import LaneRow, Lanes
from tests.console.live_client import page
from tests.console.test_recorded_percepts import manifest
from tests.logs.replay.logs import BEGIN, MemoryLog, lab_messages
from tests.logs.replay.playing import Played, prepare


def lanes(stamp: float) -> Lanes:
    """Of one class, with the second of the recording as its intensity."""
    second = int(stamp - BEGIN + 1e-3)
    return Lanes(stamp, (LaneRow("Listen", float(second), 1.0, 0.5, 2.0, {"A.b": 2.0}, "degraded", f"{second} s"),))


@pytest.fixture
def prepared(tmp_path: Path) -> Any:
    """Six seconds of the lab with lanes at 20 Hz."""
    recorded = [Logged(stamp, "lanes", lanes(stamp)) for stamp in (BEGIN + 0.05 * number for number in range(120))]
    messages = sorted([*lab_messages(6.0), *recorded], key=lambda logged: logged.at)
    return prepare(MemoryLog(messages, manifest(tmp_path)))


async def test_recorded_lanes_are_shown_where_it_is_paused(replay_url: str, play: Played) -> None:
    async with page(replay_url) as ann:
        for second in (4, 2):
            await play.playback.seek(BEGIN + second + 0.5)
            await ann.until("jump")
            past = await ann.until("lanes_history")
            assert past["stamps"] == pytest.approx([BEGIN + 0.5 * number for number in range(2 * second + 2)], abs=0.06)
            (row,) = [row for row in past["rows"] if row["class"] == "Listen"]
            assert [spell["text"] for spell in row["spells"]] == [f"{number} s" for number in range(second + 1)]
            shown = await ann.until("lanes")
            assert shown["rows"] == [
                {
                    "class": "Listen",
                    "intensity": second,
                    "utility": 1,
                    "rate": 0.5,
                    "divisor": 2,
                    "divisors": {"A.b": 2},
                    "state": "degraded",
                    "text": f"{second} s",
                }
            ]
            assert BEGIN + second + 0.4 < shown["stamp"] <= BEGIN + second + 0.5


async def test_recorded_lanes_come_as_they_came_while_it_plays(replay_url: str, play: Played) -> None:
    async with page(replay_url) as ann:
        play.playback.play()
        first = await ann.until("lanes")
        later = await ann.until("lanes", lambda m: m["stamp"] >= first["stamp"] + 1.0)
        assert {row["class"] for row in later["rows"]} == {"Listen"}, "no other lanes come between them"
