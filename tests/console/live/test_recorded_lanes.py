"""Lanes out of a recording's own records of attention."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from app.attention.desires import Source
from app.console.live.lanes import LaneSampler
from app.console.live.recorded_lanes import recorded_lanes
from app.messages import DesireRecord, DesiresRecord, Divisors, IntentionRecord, ReasonRecord
from app.program.self_report import desire_record, intention_record
from app.program.system import System
from tests.console.program import Body, build

INF = math.inf


@pytest.fixture
def built(tmp_path: Path) -> tuple[System, Body]:
    """A program whose lanes are told."""
    return build(tmp_path)


@pytest.fixture
def lanes(built: tuple[System, Body]) -> LaneSampler:
    """Its lanes."""
    system = built[0]
    return LaneSampler(system.graph, system.classes, system.table.strategies)


def wish(cls: str, intensity: float, utility: float, created: float = 0.0, security: bool = False) -> DesireRecord:
    return DesireRecord(f"d-{cls}", cls, intensity, utility, security, "{}", "operator", "Ann", created, INF)


def intention(stamp: float, strategies: tuple[str, ...], reasons: tuple[ReasonRecord, ...]) -> IntentionRecord:
    return IntentionRecord(stamp, strategies, (), (), 0.0, INF, True, 0.0, (), (), (), "{}", reasons)


def lane(rows: list[dict[str, Any]], cls: str) -> dict[str, Any]:
    return next(row for row in rows if row["class"] == cls)


def test_what_was_desired_and_let_through_is_told_from_when_it_was_so(lanes: LaneSampler) -> None:
    records = [
        DesiresRecord(5.0, (wish("Telepresence", 4, 4),)),
        intention(10.2, ("picture-slow",), (ReasonRecord("Telepresence", "degraded", 1, 4, 4, "too dear"),)),
        Divisors(10.2, ("CameraStream.images", "PointCloudBuilder.images", "Teleop.twist"), (4.0, 15.0, INF)),
        DesiresRecord(11.0, ()),
    ]
    told = dict(recorded_lanes(lanes, records, 9.0, 12.0, 0.5))
    assert list(told) == [9.0, 9.5, 10.0, 10.5, 11.0, 11.5]
    before, during, after = (lane(told[stamp], "Telepresence") for stamp in (10.0, 10.5, 11.0))
    assert (before["intensity"], before["divisor"], before["rate"], before["state"]) == (4, None, 0.0, "unfulfilled")
    assert (during["utility"], during["divisor"], during["state"], during["text"]) == (4, 4, "degraded", "too dear")
    assert during["rate"] == pytest.approx(1 / 4, abs=1e-4)
    assert (after["intensity"], after["state"]) == (None, "needed")
    assert lane(told[10.5], "Teleoperation")["rate"] == 0.0


def test_where_a_channel_did_not_speak_nothing_was_offered(lanes: LaneSampler) -> None:
    records = [
        DesiresRecord(5.0, (wish("Teleoperation", 4, 4),)),
        intention(5.0, ("drive-by-hand",), (ReasonRecord("Teleoperation", "fulfilled", 4, 4, 4, "at its best"),)),
        Divisors(5.0, ("Teleop.twist",), (1.0,)),
    ]
    channel = lanes.channel("Teleop.twist")
    asked = []

    def spoke(name: str, begin: float, end: float) -> bool:
        asked.append(name)
        return name != channel or begin <= 10.2 <= end

    told = dict(recorded_lanes(lanes, records, 9.0, 13.0, 0.5, spoke))
    assert channel in asked
    rates = {stamp: lane(rows, "Teleoperation")["rate"] for stamp, rows in told.items()}
    assert rates == {9.0: None, 9.5: None, 10.0: None, 10.5: 1.0, 11.0: 1.0, 11.5: None, 12.0: None, 12.5: None}


def test_before_the_first_record_nothing_is_told(lanes: LaneSampler) -> None:
    assert list(recorded_lanes(lanes, [], 0.0, 60.0, 0.5)) == []
    told = list(recorded_lanes(lanes, [DesiresRecord(58.3, ())], 0.0, 60.0, 0.5))
    assert [stamp for stamp, _ in told] == [58.5, 59.0, 59.5]


def test_of_several_desires_the_workspace_s_choice_is_told(lanes: LaneSampler) -> None:
    for desires, expected in (
        ([wish("Telepresence", 3, 1), wish("Telepresence", 5, 2), wish("Telepresence", 4, 3)], 2),
        ([wish("Telepresence", 5, 1, security=True), wish("Telepresence", 5, 2, created=9.0)], 1),
        ([wish("Telepresence", 5, 1, created=9.0), wish("Telepresence", 5, 2)], 1),
        ([wish("Telepresence", 5, 1), wish("Telepresence", 5, 2)], 2),
    ):
        ((_, rows),) = recorded_lanes(lanes, [DesiresRecord(0.0, tuple(desires))], 0.0, 0.5, 0.5)
        assert lane(rows, "Telepresence")["utility"] == expected


async def test_recorded_lanes_are_those_that_were(built: tuple[System, Body], lanes: LaneSampler) -> None:
    """What a program records of itself gives the rows it showed."""
    async with built[0] as system:
        system.workspace.add("Telepresence", intensity=4, utility=4, source=Source("operator", "Ann"))
        await system.translator.explained()
        current = system.translator.current
        assert current is not None
        shown = lanes.sample(0.0, system.workspace.strongest(), [s.name for s in current.strategies], current.reasons)
        records = [
            DesiresRecord(0.0, tuple(desire_record(desire) for desire in system.workspace.desires())),
            replace(intention_record(current), stamp=0.0),
            Divisors(0.0, tuple(current.divisors), tuple(current.divisors.values())),
        ]
        ((_, told),) = recorded_lanes(lanes, records, 0.0, 0.5, 0.5)
    for row in (*shown, *told):
        row.pop("rate")  # nothing was offered yet
    assert told == shown
